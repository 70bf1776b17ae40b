// The sum of a piece as its kernel has it (shaders/many_lights/gather.comp), one entry after the
// other: the kernel's twin, and what sums lights with extent on the CPU.
#pragma once

#include <stop_token>

#include "core/many_lights/slice_queue.h"

namespace core::many_lights {

/// Adds to radiance[row] what the row gets from the piece's columns. Stops between rows when `stop`
/// is requested: false then.
bool sumPiece(const shared::SceneView& scene, const SlicePiece& piece, const SumRules& rules,
              std::span<glm::vec3> radiance, const std::stop_token& stop = {});

}  // namespace core::many_lights
