// First-hit data of the CPU renderers.
#pragma once

#include "core/methods/renderer.h"
#include "core/trace/accel.h"

namespace core {

/// What the ray through each pixel's centre meets. Normals are the shading normals that the
/// estimator uses (normal maps included), on the side of the camera; albedo is shared::albedoBsdf.
/// Rays that hit nothing leave zeros, ids -1 and the radiance of the environment.
Aovs traceAovs(const Accel& accel, const shared::CameraData& camera, uint32_t width,
               uint32_t height, Sight sight);

}  // namespace core
