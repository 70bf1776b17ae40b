// Equal-time runs and what stored pictures are called.
#include "app/pictures/comparison.h"

#include <algorithm>
#include <cstdio>
#include <string_view>
#include <type_traits>
#include <utility>

#include "app/pictures/param_defaults.h"

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

template <class T> std::string valueText(const T& value)
{
    if constexpr (std::is_enum_v<T>)
        return std::string(core::enumName(value));
    else if constexpr (std::is_same_v<T, bool>)
        return value ? "yes" : "no";
    else if constexpr (std::is_floating_point_v<T>)
        return formatted("%g", static_cast<double>(value));
    else
        return std::to_string(value);
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
                          text += std::string(", ") + field.name + " " + valueText(member);
                      });
    return text;
}

/// Names and values of the method's parameters.
std::vector<std::pair<std::string, std::string>> valuesOf(const core::AnyParams& params)
{
    std::vector<std::pair<std::string, std::string>> values;
    core::AnyParams::visit(params, [&](const core::Field& field, const auto& member) {
        values.emplace_back(field.name, valueText(member));
    });
    return values;
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

std::vector<ParamDifference> differences(const RenderParams& a, const RenderParams& b)
{
    std::vector<ParamDifference> found;
    const auto add = [&](const std::string& name, const std::string& x, const std::string& y) {
        if (x != y) found.push_back({name, x, y});
    };
    add("method", std::string(a.method.id()), std::string(b.method.id()));
    add("device", valueText(a.device), valueText(b.device));
    add("device-index", valueText(a.deviceIndex), valueText(b.deviceIndex));
    auto ofA = valuesOf(a.method), ofB = valuesOf(b.method);
    for (const auto& own : ofA) {
        const auto same = std::find_if(ofB.begin(), ofB.end(),
                                       [&](const auto& other) { return other.first == own.first; });
        add(own.first, own.second, same == ofB.end() ? "-" : same->second);
        if (same != ofB.end()) ofB.erase(same);
    }
    for (const auto& [name, value] : ofB) add(name, "-", value);
    return found;
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
