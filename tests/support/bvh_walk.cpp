// Walks over all nodes of a BVH. See bvh_walk.h.
#include "tests/support/bvh_walk.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace tests {

namespace {

/// A box in cells, as a child record holds it.
struct Cells {
    glm::dvec3 low{0}, high{65535};

    /// With the slack that makeGridRay adds on its side.
    bool contains(glm::dvec3 p) const
    {
        constexpr double slack = 0.02;
        return glm::all(glm::greaterThanEqual(p, low - slack)) &&
               glm::all(glm::lessThanEqual(p, high + slack));
    }
};

/// One leaf's occurrence of a triangle, with the intersection of all boxes on the way down.
struct Occurrence {
    uint32_t triangle;
    Cells cells;
};

struct Walk {
    std::vector<Occurrence> occurrences;
    std::vector<uint32_t> slotUse;  // how many leaves hold each slot
    std::vector<uint32_t> nodeUse;
    uint32_t depth = 0;
    uint32_t largestLeaf = 0;
};

void walk(const core::Bvh& bvh, uint32_t reference, const Cells& cells, uint32_t depth, Walk& out)
{
    if (reference == shared::kBvhDone) return;
    if ((reference & shared::kBvhLeaf) != 0) {
        const uint32_t count = (reference >> shared::kBvhCountShift) & shared::kBvhCountMask;
        const uint32_t first = reference & shared::kBvhIndexMask;
        EXPECT_GT(count, 0u);
        out.largestLeaf = std::max(out.largestLeaf, count);
        for (uint32_t i = first; i < first + count; ++i) {
            ASSERT_LT(i, bvh.slotCount());
            ++out.slotUse[i];
            out.occurrences.push_back({bvh.triangle(i), cells});
        }
        return;
    }
    ASSERT_LT(reference, bvh.nodeCount());
    ++out.nodeUse[reference];
    out.depth = std::max(out.depth, depth + 1);
    for (uint32_t k = 0; k < 2; ++k) {
        const shared::uvec4 child = bvh.node(reference)[k];
        Cells inside = cells;
        for (int a = 0; a < 3; ++a) {
            inside.low[a] = std::max(inside.low[a], static_cast<double>(child[a] & 0xffffu));
            inside.high[a] = std::min(inside.high[a], static_cast<double>(child[a] >> 16));
        }
        walk(bvh, child.w, inside, depth + 1, out);
    }
}

}  // namespace

void expectSound(const Mesh& mesh, const core::Bvh& bvh, const core::BvhOptions& options)
{
    ASSERT_GE(bvh.nodeCount(), 1u);
    Walk w;
    w.slotUse.resize(bvh.slotCount());
    w.nodeUse.resize(bvh.nodeCount());
    walk(bvh, 0, {}, 0, w);
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
            const glm::dvec3 cell = (p - glm::dvec3(bvh.gridLow)) * glm::dvec3(bvh.gridScale);
            const bool covered =
                std::any_of(w.occurrences.begin() + static_cast<std::ptrdiff_t>(begin),
                            w.occurrences.begin() + static_cast<std::ptrdiff_t>(i),
                            [&](const Occurrence& o) { return o.cells.contains(cell); });
            ASSERT_TRUE(covered) << "triangle " << t << ", point " << k;
        }
    }
}

}  // namespace tests
