// What a frame of a flight may cost in rays, where one path for each pixel would be too many.
#pragma once

#include <span>
#include <string>

#include "core/methods/renderer.h"

namespace app {

/// Sets the parameter `rays` of the method (new paths per pixel and view), if it has one, so that
/// each of `views` takes at most `raysPerPixel` rays per pixel, as far as its range allows; never
/// more than it is. Takes one sample of each view to know what a path costs there: `renderer` has a
/// world, and must begin anew afterwards. Returns what was found, in words, when the budget is less
/// than one sample; else nothing.
std::string fitRays(core::Renderer& renderer, std::span<const core::View> views,
                    double raysPerPixel, core::AnyParams& params);

}  // namespace app
