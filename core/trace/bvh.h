// The flat BVH2 that the GPU traverses: both children of a node in 32 bytes on a 16-bit grid, built
// by binned SAH with spatial splits. What is far smaller than the scene has a grid of its own, and
// what an animation moves a tree of its own, refitted from pose to pose; so has what is shown
// often, whose instances are leaves of the others' tree. The CPU traversal of the same nodes serves
// picking and tests.
//   Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007 (binning);
//   Stich, Friedrich, Dietrich, "Spatial splits in bounding volume hierarchies", 2009.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/scene/world.h"
#include "shared/intersect.h"

namespace core {

struct BvhOptions {
    uint32_t leafSize = 8;  // triangles per leaf at most, 1 to 14
    // Spatial splits may add this fraction of references; 0 = object splits only.
    float duplicateBudget = 0.5f;
    // Of one triangle test, in box-pair tests: decides where leaves begin.
    float triangleCost = 1.0f;
    // Triangles that later poses move: they get a tree of their own beside that of the others,
    // without spatial splits, whose cuts would go wrong with the first movement.
    IndexRange moving{};
    // A box that the grid is to cover besides the triangles, so that motion stays on it; empty when
    // low exceeds high.
    glm::vec3 reachLow{1}, reachHigh{-1};
    // What is stored once, and where it is shown: World's. Its triangles are the last ones.
    std::span<const Prototype> prototypes{};
    std::span<const shared::InstanceMatrix> instances{};
    uint32_t maxDepth = shared::kBvhMaxDepth;  // see Bvh::depth
};

/// One of the two trees: its nodes and slots as they follow each other, and what is said of it.
struct BvhPart {
    SharedArray<shared::uvec4> nodes;  // two words per node
    SharedArray<uint32_t> slots;       // the triangle in each slot
    glm::vec3 low{1}, high{-1};        // bounds; empty when low exceeds high
    uint32_t depth = 0;                // of its deepest node in the whole, from 1
    uint32_t gridChanges = 0;          // finer grids within
    double cost = 0;                   // expected tests of a line, times half the whole's surface
};

/// Node i is two words, one per child: (xlo | xhi << 16, ylo | yhi << 16, zlo | zhi << 16,
/// reference), see intersect.h for the reference. Node 0 is the root and always exists. No leaf is
/// empty: over so few triangles that they fill one leaf both children of the root are that leaf,
/// over none both are kBvhDone.
///
/// A room on a plane of kilometres would lie in a few cells of one grid. So boxes may lie on a
/// finer grid from some node on, and again below. The reference to such a subtree is a change of
/// grid (see intersect.h): two nodes whose words hold floats. The first leads there: (low.xyz,
/// reference to the subtree's root), (scale.xyz, kBvhDone); the one behind leads back: (low.xyz,
/// kBvhDone) and (scale.xyz, kBvhDone) of the grid around. A traversal that enters pushes the way
/// back, so that the change counts as a node in the depth. Where node 0 has such a subtree, rays
/// begin in there (entryOf). Most scenes have no change, and kernels are compiled without
/// (kFeatureGridChanges, kFeatureSurroundings).
///
/// A prototype has a tree over its own space, on a grid of its own. In the tree of the world each
/// instance is a leaf: a change of space, three nodes. The first two lead there: rows of the matrix
/// that takes the ray to the prototype, each without its last column, which is the fourth word; in
/// the last components the number of the node that leads to the prototype's root (as a change of
/// grid does), kBvhInstance, by how much the instance's slots are greater than the prototype's
/// (shared/instances.h), and the instance's number from 1. The third leads back, as that of a
/// change of grid but with kBvhWorld in its second word.
///
/// Numbers of nodes and slots run through `moving` and then through `still`. Where triangles of
/// both kinds exist, node 0 joins the two trees; a pose changes no word of `still`, which begins
/// with the trees of prototypes. `moving.nodes`
/// ends with room for a tree that is built anew; both words of such nodes are zero.
struct Bvh {
    BvhPart moving, still;
    glm::vec3 gridLow{0};  // at the root: cell = (x - gridLow) * gridScale, 0 to 65535
    glm::vec3 gridScale{1};
    uint32_t depth = 0;  // nodes on the longest way down; at most shared::kBvhMaxDepth
    // SAH cost: expected box-pair tests plus triangleCost times triangle tests of a line
    float cost = 0;
    float triangleCost = 1;
    uint32_t movingNodes = 0;  // in use, of moving.nodes
    // As BvhPart::cost, if every moving triangle were a leaf of its own under no node: a measure
    // that grows with the triangles but not with the distances between them
    double movingLeast = 0;
    double movingRatio = 1;  // of moving.cost to movingLeast when that tree was built
    std::vector<IndexRange> prototypeSlots;  // of each prototype

    size_t nodeCount() const { return (moving.nodes.size() + still.nodes.size()) / 2; }
    uint32_t gridChanges() const { return moving.gridChanges + still.gridChanges; }
    size_t slotCount() const { return moving.slots.size() + still.slots.size(); }
    /// Both words of a node.
    const shared::uvec4* node(uint32_t i) const
    {
        const size_t word = 2 * static_cast<size_t>(i), first = moving.nodes.size();
        return word < first ? moving.nodes.data() + word : still.nodes.data() + (word - first);
    }
    /// The triangle in a slot, below kFirstInstancedSlot; spatial splits repeat triangles.
    uint32_t triangle(uint32_t slot) const
    {
        const size_t first = moving.slots.size();
        return slot < first ? moving.slots[slot] : still.slots[slot - first];
    }
};

/// Builds over all triangles (finite vertices, indices in range). The result depends on the input
/// alone, not on the number of threads. `progress` (may be empty) gets the fraction done, from any
/// thread but never from two at a time. Returns a Bvh without nodes when `stop` was requested.
/// Throws core::Error beyond 2^27 references.
Bvh buildBvh(std::span<const glm::vec3> positions, std::span<const WorldTriangle> triangles,
             const BvhOptions& options = {}, const std::function<void(double)>& progress = {},
             std::stop_token stop = {});

/// The same tree over a pose in which the moving triangles have gone elsewhere: their boxes anew
/// from the leaves up. Nothing when the grid does not reach there.
std::optional<Bvh> refitBvh(const Bvh& bvh, std::span<const glm::vec3> positions,
                            std::span<const WorldTriangle> triangles);

/// The tree of the moving triangles built anew, the other one kept; `options` are those of `bvh`.
/// Nothing when the grid does not reach there or the tree needs more nodes than there is room for.
std::optional<Bvh> rebuildMoving(const Bvh& bvh, std::span<const glm::vec3> positions,
                                 std::span<const WorldTriangle> triangles,
                                 const BvhOptions& options);

/// Where rays begin in a hierarchy, which is not empty.
shared::BvhEntry entryOf(const Bvh& bvh);

/// How many times more tests a line is expected to take than if the moving triangles' tree were as
/// tight as when it was built: 1 or more.
double looseness(const Bvh& bvh);

struct BvhHit {
    float t = shared::kInfinity;
    glm::vec2 barycentrics{0};  // weights of the second and third vertex
    uint32_t slot = shared::kNone;
};

/// Nearest hit with tMin < t < tMax; no hit for directions that are zero or not finite. Throws
/// nothing.
bool traceClosest(const Bvh& bvh, std::span<const glm::vec3> positions,
                  std::span<const WorldTriangle> triangles, glm::vec3 origin, glm::vec3 direction,
                  float tMin, float tMax, BvhHit& hit);

/// Whether anything is hit with tMin < t < tMax.
bool traceAny(const Bvh& bvh, std::span<const glm::vec3> positions,
              std::span<const WorldTriangle> triangles, glm::vec3 origin, glm::vec3 direction,
              float tMin, float tMax);

}  // namespace core
