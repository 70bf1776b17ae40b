// New boxes for an old tree: those of the leaves from their triangles, then upwards. Children are
// numbered behind their parents, so one pass from the last node to the first suffices.
#include <array>
#include <numeric>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/trace/bvh.h"
#include "core/trace/bvh_grid.h"

namespace core {
namespace {

using bvh::Box;
using shared::uvec4;

/// Of both children of a node.
using Pair = std::array<Box, 2>;

/// The part that is refitted.
class Refit {
public:
    Refit(const Bvh& bvh, const bvh::Mesh& mesh)
        : bvh_(bvh), mesh_(mesh), joined_(!bvh.still.slots.empty()), boxes_(bvh.movingNodes),
          least_(bvh.movingNodes)
    {
        parallelFor(bvh.movingNodes, 1 << 10, [&](size_t begin, size_t end) {
            for (size_t node = begin; node < end; ++node) fitLeaves(node);
        });
        for (size_t node = boxes_.size(); node-- > 0;) fitInner(node);
    }

    /// Bounds of the moving triangles.
    Box bounds() const
    {
        Box box = boxes_[0][0];
        if (!joined_) box.grow(boxes_[0][1]);
        return box;
    }

    /// The nodes with their new boxes; cost and least cost of the tree (see Bvh). What has a finer
    /// grid gets it anew, over its new bounds.
    std::vector<uvec4> nodes(const bvh::Grid& grid, double& cost, double& least) const
    {
        std::vector<uvec4> nodes = bvh_.moving.nodes.toVector();
        cost = joined_ ? 0 : static_cast<double>(bounds().halfArea());
        least = std::accumulate(least_.begin(), least_.end(), 0.0);
        writeNode(nodes, 0, grid, cost);
        return nodes;
    }

private:
    uint32_t child(size_t node, size_t k) const { return bvh_.moving.nodes[2 * node + k].w; }
    bool isStill(size_t node, size_t k) const { return joined_ && node == 0 && k == 1; }
    /// A leaf that is the whole tree stands twice; its second box stays empty.
    bool isRepeated(size_t node, size_t k) const
    {
        return k == 1 && child(node, 0) == child(node, 1);
    }

    static bool isNode(uint32_t reference) { return (reference & shared::kBvhLeaf) == 0; }
    static bool isLeaf(uint32_t reference)
    {
        return !isNode(reference) && !bvh::changesGrid(reference) && reference != shared::kBvhDone;
    }

    /// Tests of a ray that enters the box of a child.
    double testsOf(uint32_t reference) const
    {
        if (!isLeaf(reference)) return 1;
        const uint32_t count = (reference >> shared::kBvhCountShift) & shared::kBvhCountMask;
        return static_cast<double>(bvh_.triangleCost) * count;
    }

    void fitLeaves(size_t node)
    {
        for (size_t k = 0; k < 2; ++k) {
            const uint32_t reference = child(node, k);
            if (!isLeaf(reference) || isStill(node, k) || isRepeated(node, k)) continue;
            const uint32_t count = (reference >> shared::kBvhCountShift) & shared::kBvhCountMask;
            const uint32_t first = reference & shared::kBvhIndexMask;
            for (uint32_t slot = first; slot < first + count; ++slot) {
                const Box box = bvh::boundsOf(mesh_, bvh_.moving.slots[slot]);
                boxes_[node][k].grow(box);
                least_[node] +=
                    static_cast<double>(box.halfArea()) * static_cast<double>(bvh_.triangleCost);
            }
        }
    }

    /// The way to a finer grid counts as a node whose first child is what lies on it.
    void fitInner(size_t node)
    {
        for (size_t k = 0; k < 2; ++k) {
            const uint32_t reference = child(node, k);
            const bool changes = bvh::changesGrid(reference);
            if ((!changes && !isNode(reference)) || isStill(node, k)) continue;
            const uint32_t below = reference & shared::kBvhIndexMask;
            CHECK(below > node && below < boxes_.size());
            boxes_[node][k] = boxes_[below][0];
            boxes_[node][k].grow(boxes_[below][1]);
        }
    }

    /// Writes the records of a node and of all below, which lie on `grid`; adds to the cost.
    void writeNode(std::vector<uvec4>& nodes, uint32_t node, const bvh::Grid& grid,
                   double& cost) const
    {
        for (uint32_t k = 0; k < 2; ++k) {
            if (isStill(node, k)) continue;
            const Box& box = boxes_[node][k];
            uvec4& record = nodes[2 * size_t(node) + k];
            const uint32_t reference = record.w;
            cost += static_cast<double>(box.halfArea()) * testsOf(reference);
            record = grid.record(box, reference);
            if (isNode(reference)) writeNode(nodes, reference, grid, cost);
            if (!bvh::changesGrid(reference)) continue;
            const uint32_t change = reference & shared::kBvhIndexMask;
            const uint32_t root = child(change, 0);
            const bvh::Grid finer(box);
            bvh::writeGridChange(&nodes[2 * size_t(change)], finer, grid, root);
            writeNode(nodes, root, finer, cost);
        }
    }

    const Bvh& bvh_;
    const bvh::Mesh& mesh_;
    const bool joined_;
    std::vector<Pair> boxes_;
    std::vector<double> least_;
};

}  // namespace

std::optional<Bvh> refitBvh(const Bvh& bvh, std::span<const glm::vec3> positions,
                            std::span<const WorldTriangle> triangles)
{
    if (bvh.moving.slots.empty()) return bvh;
    const bvh::Mesh mesh{positions, triangles};
    const Refit refit(bvh, mesh);
    const bvh::Grid grid(bvh.gridLow, bvh.gridScale);
    const Box bounds = refit.bounds();
    if (!grid.holds(bounds)) return std::nullopt;
    Bvh out = bvh;
    out.moving.nodes = refit.nodes(grid, out.moving.cost, out.movingLeast);
    out.moving.low = bvh::asVec3(bounds.low);
    out.moving.high = bvh::asVec3(bounds.high);
    bvh::sumUp(out);
    return out;
}

double looseness(const Bvh& bvh)
{
    const double tight = bvh.still.cost + bvh.movingRatio * bvh.movingLeast;
    return tight > 0 ? std::max(1.0, (bvh.still.cost + bvh.moving.cost) / tight) : 1;
}

}  // namespace core
