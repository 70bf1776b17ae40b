// Light paths: where they meet surfaces, virtual lights are placed. The estimate is unbiased,
// unlike that of the thesis's program: roulette divides by its probability, the number of paths is
// decided before they are traced (ending at the K-th light in the middle of a path favours short
// ones), and flux is scattered by the adjoint of the BSDF (Veach, "Robust Monte Carlo Methods for
// Light Transport Simulation", 1997, 5.3).
#pragma once

#include <optional>
#include <stop_token>

#include "core/many_lights/virtual_light.h"
#include "core/trace/accel.h"

namespace core::many_lights {

/// Frame number of paths that only tell how many lights a path makes, and how far they see.
inline constexpr uint32_t kPilotFrame = 0xffffffffu;

/// The virtual lights of `paths` light paths: of emitters with extent one light per path that
/// begins there, of those without one each, and one at each surface with a lobe that has a density.
/// Of `settings` sampler, seed and maxDepth count (a light is left out when the scattering at the
/// receiver would be one event too many), and what describes the scene. Frames are independent of
/// each other; the lights do not depend on the number of threads. Empty when `stop` came first.
std::optional<LightSet> traceVirtualLights(const Accel& accel, const shared::PathSettings& settings,
                                           uint32_t frame, uint32_t paths,
                                           const std::stop_token& stop = {});

/// Whether paths place lights at all: one that may not scatter leaves none, unless at an emitter
/// with extent.
bool pathsPlaceLights(const World& world, uint32_t maxDepth);

/// How many paths make about `wanted` lights, by those of the pilot frame, and no more than 64 for
/// each; so many, too, where the pilot's have placed none, for where an emitter shines only here
/// and there others may. 0 where the pilot had no paths. That the pilot's paths are not among the
/// frames' own keeps these unbiased.
uint32_t pathsForLights(const LightSet& pilot, uint32_t wanted);

}  // namespace core::many_lights
