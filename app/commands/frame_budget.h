// What a frame of a flight may cost in rays, where one path for each pixel would be too many.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "core/methods/renderer.h"

namespace app {

/// View `i` of a flight; the renderer that it is for has then the world of that view.
using ViewMaker = std::function<core::View(size_t i)>;

/// Sets the parameter `rays` of the method (new paths per pixel and view), if it has one, so that
/// each of `count` views takes at most `raysPerPixel` rays per pixel, as far as its range allows;
/// never more than it is. Takes some samples of each view to know what a path costs there, before
/// the next one is made: `renderer` has a world, and must begin anew afterwards. Returns what was
/// found, in words, when the budget is less than one sample; else nothing.
std::string fitRays(core::Renderer& renderer, size_t count, const ViewMaker& viewOf,
                    double raysPerPixel, core::AnyParams& params);

}  // namespace app
