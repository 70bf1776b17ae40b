// Pictures of what a guide knows of the first hit in each pixel, the same on every device.
#pragma once

#include <memory>
#include <vector>

#include "core/guiding/guide.h"
#include "core/methods/renderer.h"
#include "shared/layout.h"

namespace core {

/// Maps in the order of guideMaps() (method.h). `aovs` are the first hits through the pixels'
/// centres of that camera.
std::vector<Image> makeGuideMaps(const Aovs& aovs, const shared::CameraData& camera,
                                 const guiding::Guide& guide);

/// Which directions the guide holds worth going: for each place a picture of the hemisphere over
/// it, looked at along the normal, in densities per steradian.
std::shared_ptr<const PlaceProbe> makeGuideProbe(Aovs aovs, const shared::CameraData& camera,
                                                 std::shared_ptr<const guiding::GuideTables> guide);

}  // namespace core
