// See frame_budget.h.
#include "app/commands/frame_budget.h"

#include <algorithm>
#include <cmath>

#include "app/base/read_value.h"

namespace app {

namespace {

/// Rays per pixel: those that a view takes whatever its number of new paths, and those of each
/// path.
struct Cost {
    double view = 1, path = 0;
};

struct Sample {
    double rays = 0, paths = 0;  // per pixel
};

Sample sampleOf(core::Renderer& renderer, const core::View& view, core::Start start)
{
    renderer.setView(view, start);
    const core::RenderStats before = renderer.stats();
    renderer.advance({.samples = 1}, {});
    const core::RenderStats after = renderer.stats();
    const double pixels = double(view.size.x) * view.size.y;
    return {double(after.rays - before.rays) / pixels, double(after.paths - before.paths) / pixels};
}

/// What old samples are asked for comes on top of the first hits and is seen once there are some.
Cost costOf(core::Renderer& renderer, const core::View& view)
{
    constexpr int kFull = 8;  // views after which a pixel keeps as much as it will
    constexpr double kNothing = 0.02;
    const Sample first = sampleOf(renderer, view, core::Start::anew);
    Cost cost{1, std::max(first.rays - 1, 0.0) / std::max(first.paths, 1e-9)};
    for (int i = 0; i < kFull; ++i) {
        const Sample next = sampleOf(renderer, view, core::Start::moved);
        const double others = next.rays - cost.path * next.paths;
        if (others < (1 + kNothing) * cost.view) break;
        cost.view = others;
    }
    return cost;
}

/// Changes the parameter `rays`; false when the method has none.
bool setRays(core::AnyParams& params, double rays)
{
    bool found = false;
    core::AnyParams::visit(params, [&](const core::Field& field, auto& member) {
        if constexpr (std::is_same_v<std::remove_cvref_t<decltype(member)>, float>) {
            if (std::string_view(field.name) != "rays") return;
            found = true;
            if (rays < static_cast<double>(member))
                member = static_cast<float>(std::max(rays, field.range.low));
        }
    });
    return found;
}

std::string rounded(double value)
{
    return numberText(std::round(100 * value) / 100);
}

}  // namespace

std::string fitRays(core::Renderer& renderer, size_t count, const ViewMaker& viewOf,
                    double raysPerPixel, core::AnyParams& params)
{
    double rays = 1e30, dearest = 0;
    for (size_t i = 0; i < count; ++i) {
        const Cost cost = costOf(renderer, viewOf(i));
        rays = std::min(rays, (raysPerPixel - cost.view) / std::max(cost.path, 1e-9));
        dearest = std::max(dearest, cost.view + cost.path);
    }
    if (dearest <= raysPerPixel) return {};
    std::string text = "--budget-rays " + numberText(raysPerPixel) +
                       ": a path for each pixel takes up to " + rounded(dearest) +
                       " rays per pixel";
    const float* const chosen =
        setRays(params, rays) ? core::findParam<float>(params, "rays") : nullptr;
    if (chosen == nullptr) return text + ", and fewer than one sample there is not";
    text += " — --rays is " + rounded(static_cast<double>(*chosen));
    if (rays < 0.999 * static_cast<double>(*chosen)) text += ", the least there is";
    return text;
}

}  // namespace app
