// Cuts through a light tree: the clusters with which one slice is lit.
#pragma once

#include <span>
#include <vector>

#include "core/many_lights/light_tree.h"

namespace core::many_lights {

/// The receiver for which a cut is made; it stands for its slice.
struct CutQuery {
    glm::vec3 position{0};
    glm::vec3 normal{0};             // unit; zero: light may come from anywhere
    float cosHalf = 1, sinHalf = 0;  // of a cone around the normals that it stands for
    float clampDistance = 0;         // lights do not count as nearer than this
};

/// A representative that stands for all lights of its node.
struct LightCluster {
    uint32_t node = 0;
    uint32_t light = 0;
    float scale = 1;  // times what the representative contributes
};

/// No less than what all lights of the node together contribute to a Lambertian receiver of albedo
/// pi at the query's position, whatever is in between; infinite for unclamped lights around it. Of
/// lights that are not Lambertian an estimate, as if they were.
float clusterBound(const LightNode& node, LightKind kind, const CutQuery& query);

/// Replaces the node with the largest bound by its children until there are `clusters` (or every
/// light is one); in the order of the nodes, which is that of neighbouring lights. Depends on no
/// representative, so that it does not bias. `heap` is memory that may be kept between calls.
struct CutMemory {
    struct Entry {
        float bound;
        uint32_t node;
        LightKind kind;
    };
    std::vector<Entry> heap;
};
void cutLightTree(const LightTree& tree, std::span<const VirtualLight> lights,
                  const CutQuery& query, uint32_t clusters, CutMemory& memory,
                  std::vector<LightCluster>& out);

}  // namespace core::many_lights
