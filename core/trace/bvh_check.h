// Whether a hierarchy that comes from outside of the program may be traversed.
#pragma once

#include <span>

#include "core/trace/bvh.h"

namespace core {

/// Whether `bvh`, which may hold anything, is a hierarchy of these triangles under these options:
/// references lead to nodes and slots that exist, each of them once, so that every ray comes to an
/// end with the stack that it has; the boxes on the way to a triangle hold its corners, those on
/// the way to an instance all of it. What lies between the corners of a triangle that has been
/// split is taken on trust. Throws nothing but what memory demands.
bool isSound(const Bvh& bvh, std::span<const glm::vec3> positions,
             std::span<const WorldTriangle> triangles, const BvhOptions& options);

}  // namespace core
