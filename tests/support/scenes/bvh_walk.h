// What must hold of every BVH, walked from the root.
#pragma once

#include "core/trace/bvh.h"
#include "tests/support/scenes/meshes.h"

namespace tests {

/// Every triangle is reachable through boxes that contain it, every slot and every node that is in
/// use has one parent, depth, leaves and duplicates are within their bounds, changes of grid lead
/// there and back. Triangles have points
/// of their surface tried at random.
void expectSound(const Mesh& mesh, const core::Bvh& bvh, const core::BvhOptions& options);

}  // namespace tests
