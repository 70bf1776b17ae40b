// The flat BVH2 that the GPU traverses: both children of a node in 32 bytes on a 16-bit grid, built
// by binned SAH with spatial splits. The CPU traversal of the same nodes is there for tests.
//   Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007 (binning);
//   Stich, Friedrich, Dietrich, "Spatial splits in bounding volume hierarchies", 2009.
#pragma once

#include <cstdint>
#include <functional>
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
};

/// Node i is words 2i and 2i+1, one per child: (xlo | xhi << 16, ylo | yhi << 16, zlo | zhi << 16,
/// reference), see intersect.h for the reference. Node 0 is the root and always exists. No leaf is
/// empty: over so few triangles that they fill one leaf both children of the root are that leaf,
/// over none both are kBvhDone.
struct Bvh {
    std::vector<shared::uvec4> nodes;
    // Triangle in each slot, in leaf order; spatial splits repeat triangles
    std::vector<uint32_t> slots;
    glm::vec3 gridLow{0};  // cell = (x - gridLow) * gridScale, 0 to 65535
    glm::vec3 gridScale{1};
    uint32_t depth = 0;  // nodes on the longest way down; at most shared::kBvhMaxDepth
    // SAH cost: expected box-pair tests plus triangleCost times triangle tests of a line
    float cost = 0;
};

/// Builds over all triangles (finite vertices, indices in range). The result depends on the input
/// alone, not on the number of threads. `progress` (may be empty) gets the fraction done, from any
/// thread but never from two at a time. Returns a Bvh without nodes when `stop` was requested.
/// Throws core::Error beyond 2^27 references.
Bvh buildBvh(std::span<const glm::vec3> positions, std::span<const WorldTriangle> triangles,
             const BvhOptions& options = {}, const std::function<void(double)>& progress = {},
             std::stop_token stop = {});

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
