// See bvh_instances.h.
#include "core/trace/bvh_instances.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/scene/instances.h"
#include "core/trace/bvh_traverse.h"
#include "shared/instances.h"

namespace core::bvh {
namespace {

using shared::uvec4;

constexpr float kWayCost = 3;   // of going in and out
constexpr uint32_t kSpare = 8;  // levels by which the tree above may be out of balance

Box boxOf(const Mesh& mesh, const IndexRange& triangles)
{
    Box box;
    for (uint32_t i = triangles.begin; i < triangles.end; ++i) box.grow(boundsOf(mesh, i));
    return box;
}

/// Bounds of a box under a matrix, with room for the rounding of the rays that go there.
Box placed(const Box& box, const shared::InstanceMatrix& m)
{
    Box result;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::vec3 p(corner & 1 ? box.low[0] : box.high[0],
                          corner & 2 ? box.low[1] : box.high[1],
                          corner & 4 ? box.low[2] : box.high[2]);
        result.grow(load(shared::transformPoint(m, p)));
    }
    float far = 0;
    for (int a = 0; a < 3; ++a)
        far = std::max({far, std::abs(result.low[a]), std::abs(result.high[a])});
    const float room = 1e-6f * far;
    const Float4 margin{room, room, room, 0};
    return {result.low - margin, result.high + margin};
}

/// Appends the tree of one prototype; returns the number of the node that leads to its root.
uint32_t append(PrototypeTrees& trees, Builder& builder, size_t firstNode, size_t firstSlot,
                float& cost)
{
    const size_t way = trees.nodes.size(), slot = trees.slots.size();
    const Grid grid(builder.box());
    builder.build(grid, 0);
    const auto number = static_cast<uint32_t>(firstNode + way / 2);
    uint32_t root = shared::kBvhDone;
    double least = 0;
    const BvhPart part =
        builder.layOut({}, number + 1, static_cast<uint32_t>(firstSlot + slot), root, least);
    trees.nodes.resize(way + 2);
    writeWay(&trees.nodes[way], grid, root);
    trees.nodes.insert(trees.nodes.end(), part.nodes.begin(), part.nodes.end());
    trees.slots.insert(trees.slots.end(), part.slots.begin(), part.slots.end());
    trees.ranges.push_back({static_cast<uint32_t>(firstSlot + slot),
                            static_cast<uint32_t>(firstSlot + trees.slots.size())});
    trees.depth = std::max(trees.depth, part.depth + 2);
    trees.gridChanges += part.gridChanges;
    const double area = static_cast<double>(builder.box().halfArea());
    cost = kWayCost + (area > 0 ? static_cast<float>(part.cost / area) : 1.0f);
    return number;
}

}  // namespace

std::vector<InstanceLeaf> makeInstanceLeaves(const Mesh& mesh, const BvhOptions& options)
{
    std::vector<InstanceLeaf> leaves(options.instances.size());
    for (const Prototype& prototype : options.prototypes) {
        const Box box = boxOf(mesh, prototype.triangles);
        for (uint32_t i = prototype.instances.begin; i < prototype.instances.end; ++i)
            leaves[i].box = placed(box, options.instances[i]);
    }
    return leaves;
}

PrototypeTrees buildPrototypes(const Mesh& mesh, const BvhOptions& options, size_t firstNode,
                               size_t firstSlot, std::vector<InstanceLeaf>& leaves,
                               BuildProgress& progress, const std::stop_token& stop)
{
    PrototypeTrees trees;
    BvhOptions below = options;
    const size_t above = mesh.triangles.size() + leaves.size();
    below.maxDepth -= static_cast<uint32_t>(std::bit_width(above)) + kSpare;
    std::vector<uint32_t> ways;
    for (const Prototype& prototype : options.prototypes) {
        const IndexRange& triangles = prototype.triangles;
        Builder builder(mesh, {triangles.begin, ~0u, 0, triangles.size()}, below, progress, stop);
        float cost = 0;
        ways.push_back(append(trees, builder, firstNode, firstSlot, cost));
        if (stop.stop_requested()) return trees;
        const IndexRange& instances = prototype.instances;
        for (uint32_t i = instances.begin; i < instances.end; ++i) leaves[i].cost = cost;
    }
    const auto slots = instanceSlots(options.prototypes, trees.ranges);
    CHECK(slots);
    for (size_t p = 0; p < ways.size(); ++p) {
        const IndexRange& instances = options.prototypes[p].instances;
        parallelFor(instances.size(), 1 << 10, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i) {
                const size_t instance = instances.begin + i;
                leaves[instance].words =
                    wayInto(options.instances[instance], ways[p],
                            (*slots)[p].at(static_cast<uint32_t>(i)) - trees.ranges[p].begin,
                            static_cast<uint32_t>(instance + 1));
            }
        });
    }
    return trees;
}

}  // namespace core::bvh

namespace core {

std::array<shared::uvec4, 4> wayInto(const shared::InstanceMatrix& m, uint32_t way,
                                     uint32_t slotOffset, uint32_t number)
{
    const glm::dmat4 toWorld = glm::transpose(
        glm::dmat4(glm::dvec4(m.row0), glm::dvec4(m.row1), glm::dvec4(m.row2), {0, 0, 0, 1}));
    const glm::dmat4 inverse = glm::inverse(toWorld);
    const glm::dmat4 rows = glm::transpose(inverse);
    return {bvh::floatWord(glm::vec3(rows[0]), way),
            bvh::floatWord(glm::vec3(rows[1]), shared::kBvhInstance),
            bvh::floatWord(glm::vec3(rows[2]), slotOffset),
            bvh::floatWord(glm::vec3(inverse[3]), number)};
}

}  // namespace core
