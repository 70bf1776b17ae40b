// Walks over all nodes of a BVH. See bvh_walk.h.
#include "tests/support/scenes/bvh_walk.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace tests {

namespace {

/// A grid, by the words of a change or as the root has it.
struct CellGrid {
    glm::dvec3 low, scale;
};

/// A box in world space, made of child records: with the slack that makeGridRay adds on its side.
struct Bounds {
    glm::dvec3 low{-1e300}, high{1e300};

    void cut(const CellGrid& grid, const shared::uvec4& record)
    {
        constexpr double slack = 0.02;
        for (int a = 0; a < 3; ++a) {
            const auto place = [&](double cell) { return cell / grid.scale[a] + grid.low[a]; };
            low[a] = std::max(low[a], place((record[a] & 0xffffu) - slack));
            high[a] = std::min(high[a], place((record[a] >> 16) + slack));
        }
    }
    bool contains(glm::dvec3 p) const
    {
        return glm::all(glm::greaterThanEqual(p, low)) && glm::all(glm::lessThanEqual(p, high));
    }
};

/// One leaf's occurrence of a triangle, with the intersection of all boxes on the way down.
struct Occurrence {
    uint32_t triangle;
    Bounds bounds;
};

CellGrid gridOf(const shared::uvec4* words)
{
    const auto vector = [](shared::uvec4 w) {
        return glm::dvec3(shared::uintAsFloat(w.x), shared::uintAsFloat(w.y),
                          shared::uintAsFloat(w.z));
    };
    return {vector(words[0]), vector(words[1])};
}

struct Walk {
    std::vector<Occurrence> occurrences;
    std::vector<uint32_t> slotUse;  // how many leaves hold each slot
    std::vector<uint32_t> nodeUse;
    uint32_t depth = 0;
    uint32_t largestLeaf = 0;
    uint32_t gridChanges = 0;
};

void walk(const core::Bvh& bvh, uint32_t reference, const CellGrid& grid, const Bounds& bounds,
          uint32_t depth, Walk& out);

/// A change of grid: two nodes, of which the second leads back to what is around.
void walkChange(const core::Bvh& bvh, uint32_t reference, const CellGrid& grid,
                const Bounds& bounds, uint32_t depth, Walk& out)
{
    const uint32_t node = reference & shared::kBvhIndexMask;
    ASSERT_LT(node + 1, bvh.nodeCount());
    ++out.nodeUse[node];
    ++out.nodeUse[node + 1];
    ++out.gridChanges;
    const shared::uvec4 *there = bvh.node(node), *back = bvh.node(node + 1);
    EXPECT_EQ(back[0].w, shared::kBvhDone);
    const CellGrid around = gridOf(back);
    EXPECT_EQ(around.low, grid.low);
    EXPECT_EQ(around.scale, grid.scale);
    walk(bvh, there[0].w, gridOf(there), bounds, depth + 1, out);
}

void walk(const core::Bvh& bvh, uint32_t reference, const CellGrid& grid, const Bounds& bounds,
          uint32_t depth, Walk& out)
{
    if (reference == shared::kBvhDone) return;
    if (reference >= shared::kBvhChange) {
        walkChange(bvh, reference, grid, bounds, depth, out);
        return;
    }
    if ((reference & shared::kBvhLeaf) != 0) {
        const uint32_t count = (reference >> shared::kBvhCountShift) & shared::kBvhCountMask;
        const uint32_t first = reference & shared::kBvhIndexMask;
        EXPECT_GT(count, 0u);
        out.largestLeaf = std::max(out.largestLeaf, count);
        for (uint32_t i = first; i < first + count; ++i) {
            ASSERT_LT(i, bvh.slotCount());
            ++out.slotUse[i];
            out.occurrences.push_back({bvh.triangle(i), bounds});
        }
        return;
    }
    ASSERT_LT(reference, bvh.nodeCount());
    ++out.nodeUse[reference];
    out.depth = std::max(out.depth, depth + 1);
    for (uint32_t k = 0; k < 2; ++k) {
        const shared::uvec4 child = bvh.node(reference)[k];
        Bounds inside = bounds;
        inside.cut(grid, child);
        walk(bvh, child.w, grid, inside, depth + 1, out);
    }
}

}  // namespace

void expectSound(const Mesh& mesh, const core::Bvh& bvh, const core::BvhOptions& options)
{
    ASSERT_GE(bvh.nodeCount(), 1u);
    Walk w;
    w.slotUse.resize(bvh.slotCount());
    w.nodeUse.resize(bvh.nodeCount());
    walk(bvh, 0, {glm::dvec3(bvh.gridLow), glm::dvec3(bvh.gridScale)}, {}, 0, w);
    EXPECT_EQ(w.gridChanges, bvh.gridChanges());
    EXPECT_EQ(w.depth, bvh.depth);
    EXPECT_LE(bvh.depth, shared::kBvhMaxDepth);
    EXPECT_LE(w.largestLeaf, options.leafSize);
    const bool oneLeaf = bvh.node(0)[0].w == bvh.node(0)[1].w;
    for (const uint32_t n : w.slotUse) {
        ASSERT_EQ(n, oneLeaf ? 2u : 1u) << "every slot lies in exactly one leaf";
    }
    const size_t roomEnd = bvh.moving.nodes.size() / 2;
    for (size_t n = 0; n < w.nodeUse.size(); ++n) {
        const bool room = n >= bvh.movingNodes && n < roomEnd;
        ASSERT_EQ(w.nodeUse[n], room ? 0u : 1u) << "node " << n << " has exactly one parent";
    }
    const double budget =
        static_cast<double>(options.duplicateBudget) * static_cast<double>(mesh.triangles.size());
    EXPECT_LE(static_cast<double>(bvh.slotCount()),
              static_cast<double>(mesh.triangles.size()) + budget);

    std::ranges::sort(w.occurrences, {}, &Occurrence::triangle);
    std::mt19937 engine(7);
    std::uniform_real_distribution<double> uniform(0, 1);
    size_t i = 0;
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const size_t begin = i;
        while (i < w.occurrences.size() && w.occurrences[i].triangle == t) ++i;
        ASSERT_GT(i, begin) << "triangle " << t << " is in no leaf";
        const core::WorldTriangle& tri = mesh.triangles[t];
        const glm::dvec3 a = mesh.positions[tri.v0], b = mesh.positions[tri.v1],
                         c = mesh.positions[tri.v2];
        for (int k = 0; k < 8; ++k) {
            // Corners first, then points inside: each lies in the boxes of at least one of its
            // leaves.
            const double s = std::sqrt(uniform(engine)), u = uniform(engine);
            const glm::dvec3 p =
                k == 0 ? a
                       : (k == 1 ? b : (k == 2 ? c : (1 - s) * a + s * (1 - u) * b + s * u * c));
            const bool covered =
                std::any_of(w.occurrences.begin() + static_cast<std::ptrdiff_t>(begin),
                            w.occurrences.begin() + static_cast<std::ptrdiff_t>(i),
                            [&](const Occurrence& o) { return o.bounds.contains(p); });
            ASSERT_TRUE(covered) << "triangle " << t << ", point " << k;
        }
    }
}

}  // namespace tests
