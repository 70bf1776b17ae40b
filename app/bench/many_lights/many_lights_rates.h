// How fast shadow rays are answered: by full sampling, and by the tracer alone.
#pragma once

#include "app/bench/many_lights/many_lights_scene.h"

namespace app::many_lights {

/// Measures on slices of the subset, a few of them, with `clusters` lights each: full sampling in
/// packets and ray by ray, and rtcOccluded16 over the same packets, made before. They take turns on
/// each slice. Nothing when a stop came first.
std::optional<RayRates> measureRates(LitScene& scene, const Subset& subset, uint32_t clusters);

}  // namespace app::many_lights
