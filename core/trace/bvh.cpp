// The whole hierarchy from its two trees; see bvh.h.
#include "core/trace/bvh.h"

#include <algorithm>

#include "core/base/check.h"
#include "core/trace/bvh_builder.h"
#include "core/trace/bvh_instances.h"

namespace core {
namespace {

using bvh::Box;
using bvh::Builder;
using bvh::BuildProgress;
using bvh::Float4;
using bvh::Grid;
using bvh::PrototypeTrees;
using bvh::Subset;
using shared::uvec4;

Subset movingSubset(const BvhOptions& options)
{
    return {options.moving.begin, ~0u, 0, options.moving.size()};
}

/// Options of the moving triangles' tree.
BvhOptions withoutSplits(BvhOptions options)
{
    options.duplicateBudget = 0;
    return options;
}

/// Both trees' bounds and where motion may lead; not further from the triangles than they are
/// large, as the cells grow with it.
Box gridBounds(Box bounds, const BvhOptions& options)
{
    const Box reach{bvh::load(options.reachLow), bvh::load(options.reachHigh)};
    if (reach.empty() || bounds.empty()) return bounds;
    const Float4 size = bounds.high - bounds.low;
    const Box near{bounds.low - size, bounds.high + size};
    bounds.grow(bvh::intersection(reach, near));
    return bounds;
}

/// The root of a tree that stands alone but has no node: a single leaf, or nothing. Leaves are
/// never empty: the traversal tests a triangle first and counts then. So a single leaf stands
/// twice, the second time in a box of one corner, and nothing at all ends the traversal.
std::vector<uvec4> rootOver(const Grid& grid, const Box& box, uint32_t reference)
{
    return {grid.record(box, reference), grid.record(Box{}, reference)};
}

/// Takes over the still triangles' tree behind those of `prototypes`; returns what a joining root
/// says of it. Its nodes are numbered behind `room` others, its slots behind `firstSlot`.
uvec4 layOutStill(Bvh& out, Builder& builder, const Grid& grid, size_t room, size_t firstSlot,
                  PrototypeTrees prototypes)
{
    const bool alone = room == 0;
    const bool ownRoot = alone && !prototypes.nodes.empty();  // of the whole
    const size_t rootWords = ownRoot ? 2 : 0;
    std::vector<uvec4> begin(rootWords + prototypes.nodes.size());
    std::ranges::copy(prototypes.nodes, begin.begin() + static_cast<ptrdiff_t>(rootWords));
    const size_t firstNode = room + begin.size() / 2;
    uint32_t root = shared::kBvhDone;
    double least = 0;
    out.still =
        builder.layOut(std::move(begin), static_cast<uint32_t>(firstNode),
                       static_cast<uint32_t>(firstSlot + prototypes.slots.size()), root, least);
    if (ownRoot || (alone && out.still.nodes.empty())) {
        std::vector<uvec4> nodes = out.still.nodes.toVector();
        const std::vector<uvec4> over = rootOver(grid, builder.box(), root);
        nodes.resize(std::max(nodes.size(), over.size()));
        std::copy(over.begin(), over.end(), nodes.begin());
        out.still.nodes = std::move(nodes);
    }
    if (!prototypes.slots.empty()) {
        const size_t before = prototypes.slots.size();
        prototypes.slots.resize(before + out.still.slots.size());
        std::copy(out.still.slots.begin(), out.still.slots.end(),
                  prototypes.slots.begin() + static_cast<ptrdiff_t>(before));
        out.still.slots = std::move(prototypes.slots);
    }
    out.still.gridChanges += prototypes.gridChanges;
    out.prototypeSlots = std::move(prototypes.ranges);
    return grid.record(builder.box(), root);
}

/// Takes over the moving triangles' tree with `room` for nodes, under node 0 beside the other tree
/// if `still` is given.
void layOutMoving(Bvh& out, Builder& builder, const Grid& grid, size_t room, const uvec4* still)
{
    uint32_t root = shared::kBvhDone;
    out.movingLeast = 0;
    std::vector<uvec4> begin(still != nullptr ? 2 : 0);
    const uint32_t firstNode = static_cast<uint32_t>(begin.size() / 2);
    out.moving = builder.layOut(std::move(begin), firstNode, 0, root, out.movingLeast);
    std::vector<uvec4> nodes = out.moving.nodes.toVector();
    if (still != nullptr) {
        nodes[0] = grid.record(builder.box(), root);
        nodes[1] = *still;
    } else if (nodes.empty()) {
        nodes = rootOver(grid, builder.box(), root);
    }
    out.movingNodes = static_cast<uint32_t>(nodes.size() / 2);
    nodes.resize(2 * room, uvec4(0));
    out.moving.nodes = std::move(nodes);
    out.movingRatio = out.movingLeast > 0 ? out.moving.cost / out.movingLeast : 1;
}

}  // namespace

Bvh buildBvh(std::span<const glm::vec3> positions, std::span<const WorldTriangle> triangles,
             const BvhOptions& options, const std::function<void(double)>& progress,
             std::stop_token stop)
{
    CHECK(options.leafSize >= 1 && options.leafSize <= shared::kBvhCountMask - 1);
    CHECK(options.moving.begin <= options.moving.end && options.moving.end <= triangles.size());
    const size_t flat =
        options.prototypes.empty() ? triangles.size() : options.prototypes.front().triangles.begin;
    const size_t movingCount = options.moving.size();
    const size_t stillCount = flat - movingCount + options.instances.size();
    const bool joined = movingCount > 0 && stillCount > 0;
    const bvh::Mesh mesh{positions, triangles};
    std::vector<bvh::InstanceLeaf> leaves = bvh::makeInstanceLeaves(mesh, options);
    BuildProgress reports(progress, triangles.size() + leaves.size());
    Builder moving(mesh, movingSubset(options), withoutSplits(options), reports, stop);
    Builder still({positions, triangles.first(flat), leaves},
                  {0, options.moving.begin, options.moving.size(), stillCount}, options, reports,
                  stop);
    Box bounds = still.box();
    bounds.grow(moving.box());
    const Grid grid(gridBounds(bounds, options));
    if (movingCount > 0) moving.build(grid, joined ? 1 : 0);
    // A tree over other positions of the same triangles has a few more nodes, or a few less.
    const size_t needed = movingCount > 0 ? moving.nodeCount() + 1 : 0;
    const size_t room = needed + needed / 4;
    const bool ownRoot = !joined && !leaves.empty();
    PrototypeTrees prototypes = bvh::buildPrototypes(mesh, options, room + (ownRoot ? 1 : 0),
                                                     movingCount, leaves, reports, stop);
    if (stillCount > 0 || movingCount == 0)
        still.build(grid, (joined || ownRoot ? 1 : 0) + prototypes.depth);
    if (stop.stop_requested()) return {};

    Bvh out;
    out.gridLow = grid.low;
    out.gridScale = grid.scale;
    out.triangleCost = options.triangleCost;
    uvec4 stillRecord(0);
    if (stillCount > 0 || movingCount == 0)
        stillRecord = layOutStill(out, still, grid, room, movingCount, std::move(prototypes));
    if (movingCount > 0) layOutMoving(out, moving, grid, room, joined ? &stillRecord : nullptr);
    if (std::max(out.nodeCount(), out.slotCount()) > bvh::kMaxReferences)
        throw bvh::tooLarge(triangles.size());
    bvh::sumUp(out);
    if (progress) progress(1.0);
    return out;
}

std::optional<Bvh> rebuildMoving(const Bvh& bvh, std::span<const glm::vec3> positions,
                                 std::span<const WorldTriangle> triangles,
                                 const BvhOptions& options)
{
    const std::function<void(double)> quiet;
    BuildProgress reports(quiet, triangles.size());
    Builder moving({positions, triangles}, movingSubset(options), withoutSplits(options), reports,
                   {});
    const Grid grid(bvh.gridLow, bvh.gridScale);
    if (!grid.holds(moving.box())) return std::nullopt;
    const bool joined = !bvh.still.slots.empty();
    moving.build(grid, joined ? 1 : 0);
    const size_t room = bvh.moving.nodes.size() / 2;
    if (moving.nodeCount() + 1 > room) return std::nullopt;
    Bvh out = bvh;
    layOutMoving(out, moving, grid, room, joined ? &bvh.moving.nodes[1] : nullptr);
    bvh::sumUp(out);
    return out;
}

}  // namespace core
