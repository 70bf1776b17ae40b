// From parameters of the method to the settings of a frame, for those who drive frames themselves
// (measurements).
#pragma once

#include "core/many_lights/frame.h"
#include "core/methods/renderer.h"

namespace core {

/// What a frame of `view` (parameters of manylights) is made from. `first`: it is the first of its
/// picture.
many_lights::FrameSettings frameSettings(const World& world, const View& view, bool first);

}  // namespace core
