// The distance below which virtual lights do not become brighter.
#pragma once

#include "core/many_lights/virtual_light.h"
#include "core/trace/accel.h"

namespace core::many_lights {

/// Mean over lights of the nearest surface that each sees, and a tenth of the way from there to the
/// mean of the farthest; metres. The thesis's: S. Wang, "Efficient Sample Usage in Photo-Realistic
/// Rendering" (2022). It is large, a third of a room. At most 512 lights are asked, with 64 rays
/// each. 0 without positional lights.
float clampDistance(const Accel& accel, const LightSet& lights);

}  // namespace core::many_lights
