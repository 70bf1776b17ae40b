// Pictures of what a guide knows of the first hit in each pixel, the same on every device.
#pragma once

#include <vector>

#include "core/guiding/guide.h"
#include "core/methods/renderer.h"
#include "shared/layout.h"

namespace core {

/// Maps in the order of guideMaps() (method.h). `aovs` are the first hits through the pixels'
/// centres of that camera.
std::vector<Image> makeGuideMaps(const Aovs& aovs, const shared::CameraData& camera,
                                 const guiding::Guide& guide);

}  // namespace core
