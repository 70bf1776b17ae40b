// Light that virtual lights do not bring: what the clamp takes from those that are near, and what
// comes by way of mirrors, clear glass and panes, where no virtual light can be and their rays end.
// Each receiver finds it by one path, and straight through panes by a connection. Kollig and
// Keller, "Illumination in the Presence of Weak Singularities" (2006), for the former.
#pragma once

#include <span>

#include "core/many_lights/receivers.h"

namespace core::many_lights {

/// Whether there is any such light: with a clamp, or in scenes with lobes without density.
bool losesLight(const World& world, float clampDistance);

/// Adds to out[i] an estimate, unbiased, of the light that receiver chosen[i] lacks, towards where
/// it is seen from. Returns the rays traced.
uint64_t addLostLight(const ReceiverJob& job, float clampDistance,
                      std::span<const Receiver> receivers, std::span<const uint32_t> chosen,
                      std::span<glm::vec3> out);

}  // namespace core::many_lights
