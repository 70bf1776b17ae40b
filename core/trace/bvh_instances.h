// The trees of what is shown by instances, and the leaves that stand for these in the tree above.
// Private to bvh*.cpp.
#pragma once

#include <vector>

#include "core/trace/bvh_builder.h"

namespace core::bvh {

/// The trees of all prototypes, one behind the other.
struct PrototypeTrees {
    std::vector<shared::uvec4> nodes;
    std::vector<uint32_t> slots;     // the triangle in each slot
    std::vector<IndexRange> ranges;  // slots of each prototype
    uint32_t depth = 0;              // of the deepest, with the way in and out
    uint32_t gridChanges = 0;
};

/// One per instance, with nothing but the box.
std::vector<InstanceLeaf> makeInstanceLeaves(const Mesh& mesh, const BvhOptions& options);

/// Builds the trees, whose nodes and slots are numbered from `firstNode` and `firstSlot`, and
/// completes the leaves.
PrototypeTrees buildPrototypes(const Mesh& mesh, const BvhOptions& options, size_t firstNode,
                               size_t firstSlot, std::vector<InstanceLeaf>& leaves,
                               BuildProgress& progress, const std::stop_token& stop);

}  // namespace core::bvh
