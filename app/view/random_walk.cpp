// See random_walk.h. Long work (references, exports) gets few samples, so
// that a walk of ten thousand steps ends.
#include "app/view/random_walk.h"

#include <algorithm>
#include <array>

#include <nlohmann/json.hpp>

#include "app/base/json_file.h"
#include "app/session/set_param.h"
#include "core/base/check.h"

namespace app {

using Json = nlohmann::ordered_json;

RandomWalk::RandomWalk(uint64_t seed, std::vector<std::filesystem::path> files,
                       std::filesystem::path folder)
    : random_(seed), files_(std::move(files)), folder_(std::move(folder))
{
    CHECK(!files_.empty());
}

double RandomWalk::real(double low, double high)
{
    return std::uniform_real_distribution<double>(low, high)(random_);
}

size_t RandomWalk::below(size_t count)
{
    return std::uniform_int_distribution<size_t>(0, count - 1)(random_);
}

/// {"name": ..., "value": ...}: one in eight does not fit.
Json RandomWalk::parameter()
{
    const std::span<const std::string_view> shows = core::enumNames<Show>();
    switch (below(18)) {
    case 0:
        return {{"name", "device"}, {"value", below(2) == 0 ? "cpu" : "vulkan"}};
    case 1:
        return {{"name", "max-depth"}, {"value", below(12)}};
    case 2:
        return {{"name", "sampler"}, {"value", below(2) == 0 ? "sobol" : "independent"}};
    case 3:
        return {{"name", "strategy"}, {"value", below(2) == 0 ? "mis" : "light"}};
    case 4:
        return {{"name", "seed"}, {"value", below(1000)}};
    case 5:
        return {{"name", "kernel"}, {"value", below(2) == 0 ? "wavefront" : "megakernel"}};
    case 6:
        return {{"name", "exposure"}, {"value", real(-5, 5)}};
    case 7:
        return {{"name", "tone"}, {"value", below(2) == 0 ? "aces" : "agx"}};
    case 8:
        return {{"name", "show"}, {"value", std::string(shows[below(shows.size())])}};
    case 9:
        return {{"name", "spp-limit"}, {"value", below(20)}};
    case 10:
        return {{"name", "picture-scale"}, {"value", real(0.1, 1)}};
    case 11:
        return {{"name", "moving-rate"}, {"value", real(5, 60)}};
    case 12:
        return {{"name", "clamp-indirect"}, {"value", real(0, 4)}};
    case 13:
        return {{"name", "error-range"}, {"value", real(0.001, 10)}};
    case 14:
        return {{"name", "max-depth"}, {"value", -1}};
    case 15: {
        const auto methods = core::methods();
        return {{"name", "method"}, {"value", std::string(methods[below(methods.size())].id())}};
    }
    case 16:
        return methodParameter();
    default:
        return {{"name", "no-such"}, {"value", Json::array()}};
    }
}

/// Any parameter of any method, which need not be the one in use.
Json RandomWalk::methodParameter()
{
    const auto methods = core::methods();
    const core::MethodInfo& method = methods[below(methods.size())];
    std::vector<Json> all;
    core::AnyParams::visit(method.defaults, [&](const core::Field& field, const auto& value) {
        using Member = std::remove_cvref_t<decltype(value)>;
        const double low = field.range.low;
        const double high =
            field.range.low == field.range.high ? 100 : std::min(field.range.high, 20.0);
        Json chosen;
        if constexpr (std::is_enum_v<Member>)
            chosen =
                std::string(core::enumNames<Member>()[below(core::enumNames<Member>().size())]);
        else if constexpr (std::is_same_v<Member, bool>)
            chosen = below(2) == 0;
        else if constexpr (std::is_integral_v<Member>)
            chosen = static_cast<uint64_t>(real(low, high));
        else
            chosen = real(low, high);
        all.push_back({{"name", field.name}, {"value", chosen}});
    });
    return all[below(all.size())];
}

Json RandomWalk::arguments(const std::string& action)
{
    if (action == "load") return {{"file", files_[below(files_.size())].string()}};
    if (action == "set") return parameter();
    if (action == "orbit" || action == "pan" || action == "look")
        return {{"dx", real(-0.5, 0.5)}, {"dy", real(-0.5, 0.5)}};
    if (action == "dolly") return {{"steps", real(-3, 3)}};
    if (action == "fly")
        return {{"right", real(-1, 1)}, {"forward", real(-1, 1)}, {"seconds", real(0, 0.5)}};
    if (action == "focus") return {{"x", real(0, 1)}, {"y", real(0, 1)}};
    if (action.find("camera") != std::string::npos && action.find("use") == 0)
        return {{"index", below(4)}};
    if (action == "remove-saved-camera" || action == "remove-key") return {{"index", below(3)}};
    if (action == "paste-camera")
        return {{"json", below(2) == 0 ? "{\"position\":[0,1,3]}" : "[1,"}};
    if (action == "reference") return {{"spp", 2 + below(6)}};
    if (action == "params-a" || action == "params-b")
        return {{"params", {{"max-depth", below(4)}}}};
    if (action == "use-params") return {{"side", below(2) == 0 ? "a" : "none"}};
    if (action == "equal-time")
        return {{"seconds", real(0.01, 0.1)}, {"a", {{"max-depth", below(4)}}}};
    if (action == "resize") return {{"width", 64 + below(400)}, {"height", 64 + below(300)}};
    if (action == "preset") return {{"name", below(2) == 0 ? "balanced" : "none such"}};
    if (action == "animation") return {{"play", below(2) == 0}, {"speed", real(0.1, 4)}};
    if (action == "save")
        return {{"file", (folder_ / (below(2) == 0 ? "walk.exr" : "walk.png")).string()}};
    if (action == "screenshot") return {{"file", (folder_ / "walk-screen.png").string()}};
    if (action == "save-path") return {{"file", (folder_ / "walk-path.json").string()}};
    if (action == "load-path" || action == "load-reference" || action == "replay")
        return {{"file", (folder_ / (below(2) == 0 ? "walk-path.json" : "walk.exr")).string()}};
    if (action == "export-path")
        return {{"file", (folder_ / "walk-%04d.png").string()}, {"spp", 1}};
    return Json::object();
}

void RandomWalk::step(Session& session, AppRequests& app)
{
    const std::span<const Action> all = actions();
    const Action* action = &all[below(all.size())];
    // Nothing that may quit, and nothing that names files by the time of day.
    constexpr std::array<std::string_view, 5> kNever{"quit", "quit-now", "save-and-quit", "escape",
                                                     "screenshot-picture"};
    while (std::ranges::count(kNever, action->name) > 0) action = &all[below(all.size())];
    const Json given = arguments(action->name);
    last_ = std::string(action->name) + ' ' + jsonText(given);
    try {
        runAction(action->name, session, app, given);
    } catch (const core::Error& error) {
        if (error.code() != core::ExitCode::commandLine) throw;
    }
}

}  // namespace app
