// Equal-time runs and what stored pictures are called.
#include "app/session/comparison.h"

#include <algorithm>
#include <cstdio>
#include <string_view>
#include <type_traits>

#include "app/session/param_defaults.h"

namespace app {
namespace {

constexpr double kLeastSeconds = 0.01;

std::string formatted(const char* format, double value)
{
    char text[64];
    std::snprintf(text, sizeof text, format, value);
    return text;
}

RenderParams timed(RenderParams params, double seconds)
{
    params.sppLimit = 0;
    params.errorLimit = 0;
    params.secondsLimit = seconds;
    return params;
}

/// ", clamp-indirect 10, sampler independent": fields that are not at their defaults, but for the
/// depth.
std::string unusual(const core::AnyParams& params)
{
    std::string text;
    visitWithDefaults(params,
                      [&](const core::Field& field, const auto& member, const auto& standard) {
                          if (member == standard || std::string_view(field.name) == "max-depth")
                              return;
                          using Member = std::remove_cvref_t<decltype(member)>;
                          text += std::string(", ") + field.name + " ";
                          if constexpr (std::is_enum_v<Member>)
                              text += core::enumName(member);
                          else if constexpr (std::is_floating_point_v<Member>)
                              text += formatted("%g", static_cast<double>(member));
                          else
                              text += std::to_string(member);
                      });
    return text;
}

}  // namespace

void EqualTime::start(const RenderParams& a, const RenderParams& b, double seconds, uint64_t newest)
{
    seconds_ = std::max(seconds, kLeastSeconds);
    params_ = {timed(a, seconds_), timed(b, seconds_)};
    stage_ = Stage::first;
    fraction_ = 0;
    before_ = newest;
}

void EqualTime::cancel()
{
    stage_ = Stage::none;
    fraction_ = 0;
}

const RenderParams& EqualTime::wanted() const
{
    return params_[static_cast<size_t>(side())];
}

std::optional<Slot> EqualTime::offer(const std::shared_ptr<const Picture>& picture)
{
    if (!running() || !picture || picture->preview || picture->samples == 0) return {};
    if (picture->generation <= before_) return {};
    if (timed(picture->params, seconds_) != wanted()) return {};
    fraction_ = std::clamp(picture->seconds / seconds_, 0.0, 1.0);
    if (picture->seconds < seconds_) return {};
    stage_ = stage_ == Stage::first ? Stage::second : Stage::none;
    fraction_ = 0;
    before_ = picture->generation;
    return Slot{picture, pictureLabel(*picture)};
}

std::string paramsLabel(const RenderParams& params)
{
    std::string text =
        std::string(params.method.id()) + ", " + std::string(core::enumName(params.device));
    if (const uint32_t* depth = core::findParam<uint32_t>(params.method, "max-depth"))
        text += ", depth " + std::to_string(*depth);
    return text + unusual(params.method);
}

std::string pictureLabel(const Picture& picture)
{
    const char* const seconds = picture.seconds < 10 ? ", %.1f s" : ", %.0f s";
    return paramsLabel(picture.params) + ", " + std::to_string(picture.samples) + " spp" +
           formatted(seconds, picture.seconds);
}

}  // namespace app
