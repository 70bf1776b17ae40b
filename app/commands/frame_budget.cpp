// See frame_budget.h.
#include "app/commands/frame_budget.h"

#include <algorithm>

#include "app/base/read_value.h"

namespace app {

namespace {

/// Rays per pixel of one sample: those to the first hits, and those of each new path behind it.
struct Cost {
    double first = 1, path = 0;
};

Cost costOf(core::Renderer& renderer, const core::View& view)
{
    renderer.setView(view, core::Start::anew);
    const core::RenderStats before = renderer.stats();
    renderer.advance({.samples = 1}, {});
    const core::RenderStats after = renderer.stats();
    const double pixels = double(view.size.x) * view.size.y;
    const double rays = double(after.rays - before.rays) / pixels,
                 paths = double(after.paths - before.paths) / pixels;
    return {1, std::max(rays - 1, 0.0) / std::max(paths, 1e-9)};
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

}  // namespace

std::string fitRays(core::Renderer& renderer, std::span<const core::View> views,
                    double raysPerPixel, core::AnyParams& params)
{
    double rays = 1e30, dearest = 0;
    for (const core::View& view : views) {
        const Cost cost = costOf(renderer, view);
        rays = std::min(rays, (raysPerPixel - cost.first) / std::max(cost.path, 1e-9));
        dearest = std::max(dearest, cost.first + cost.path);
    }
    if (dearest <= raysPerPixel) return {};
    std::string text = "--budget-rays " + numberText(raysPerPixel) +
                       ": a path for each pixel takes up to " +
                       numberText(std::round(100 * dearest) / 100) + " rays per pixel";
    const float* const chosen =
        setRays(params, rays) ? core::findParam<float>(params, "rays") : nullptr;
    if (chosen == nullptr) return text + ", and fewer than one sample there is not";
    text += " — --rays is " + numberText(static_cast<double>(*chosen));
    if (rays < static_cast<double>(*chosen)) text += ", the least there is";
    return text;
}

}  // namespace app
