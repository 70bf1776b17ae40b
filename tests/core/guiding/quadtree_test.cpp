// Quadtrees as densities (T-20), what two have in common (T-21), and samples of what one lacks
// (T-22).
#include "core/guiding/quadtree.h"

#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <vector>

#include "core/base/pcg32.h"
#include "tests/support/statistics/stats.h"

namespace {

using core::Pcg32;
using core::guiding::bestC;
using core::guiding::Overlap;
using core::guiding::overlap;
using core::guiding::Quadtree;
using core::guiding::residual;
using core::guiding::Residual;
using Node = Quadtree::Node;

Quadtree flatTree()
{
    return Quadtree({Node{{1, 1, 1, 1}, {}}});
}

/// Sums 4, 2, 1, 1; `split`: the first divided .7, .1, .1, .1.
Quadtree exampleTree(bool split)
{
    if (!split) return Quadtree({Node{{4, 2, 1, 1}, {}}});
    return Quadtree({Node{{0, 20, 10, 10}, {1, 0, 0, 0}}, Node{{28, 4, 4, 4}, {}}});
}

/// Splits with probability 0.6 down to `depth`; `leaf` makes the sums.
Quadtree randomTree(Pcg32& random, uint32_t depth, const std::function<float()>& leaf)
{
    std::vector<Node> nodes;
    const std::function<uint16_t(uint32_t)> grow = [&](uint32_t level) {
        const size_t index = nodes.size();
        nodes.emplace_back();
        for (size_t i = 0; i < 4; ++i) {
            if (level < depth && random() < 0.6) {
                const uint16_t child = grow(level + 1);
                nodes[index].child[i] = child;
            } else {
                nodes[index].sum[i] = leaf();
            }
        }
        return static_cast<uint16_t>(index);
    };
    grow(1);
    return Quadtree(std::move(nodes));
}

Quadtree randomTree(Pcg32& random, uint32_t depth)
{
    return randomTree(random, depth, [&random] {
        return random() < 0.2 ? 0.0f : static_cast<float>(std::pow(10, 4 * random() - 2));
    });
}

/// Densities in the cells of a grid of 2^level per side, at their centres.
std::vector<double> onGrid(const Quadtree& tree, uint32_t level)
{
    const uint32_t n = 1u << level;
    std::vector<double> densities;
    for (uint32_t y = 0; y < n; ++y)
        for (uint32_t x = 0; x < n; ++x)
            densities.push_back(tree.pdf({(x + 0.5) / n, (y + 0.5) / n}));
    return densities;
}

double mean(const std::vector<double>& values)
{
    double sum = 0;
    for (const double v : values) sum += v;
    return sum / double(values.size());
}

/// Counts of `count` samples in the cells of a grid, against the densities there.
tests::ChiSquare chiSquareOfSamples(const Quadtree& tree, const std::vector<double>& densities,
                                    uint32_t level, int count, uint32_t seed)
{
    const uint32_t n = 1u << level;
    std::vector<double> observed(densities.size()), expected(densities.size());
    for (size_t i = 0; i < densities.size(); ++i)
        expected[i] = densities[i] * count / double(densities.size());
    Pcg32 random(seed);
    for (int i = 0; i < count; ++i) {
        const Quadtree::Sample s = tree.sample(random);
        EXPECT_GT(s.pdf, 0);
        EXPECT_DOUBLE_EQ(s.pdf, tree.pdf(s.x));
        observed[static_cast<uint32_t>(s.x.x * n) + n * static_cast<uint32_t>(s.x.y * n)] += 1;
    }
    return tests::chiSquareTest(observed, expected);
}

TEST(Quadtree, ExampleHasItsDensities)
{
    const Quadtree plain = exampleTree(false), split = exampleTree(true);
    const double expected[] = {2, 1, 0.5, 0.5};
    for (int i = 0; i < 4; ++i) {
        const glm::dvec2 low(0.5 * (i & 1), 0.5 * (i >> 1));
        EXPECT_DOUBLE_EQ(plain.pdf(low + 0.1), expected[i]);
        if (i > 0) {
            EXPECT_DOUBLE_EQ(split.pdf(low + 0.1), expected[i]);
        }
        EXPECT_DOUBLE_EQ(split.pdf(0.5 * low + 0.1), i == 0 ? 5.6 : 0.8);
    }
    EXPECT_EQ(plain.total(), 8);
    EXPECT_EQ(split.total(), 80);
    EXPECT_EQ(split.nodes()[0].sum[0], 40);  // computed from the node below
    EXPECT_EQ(plain.depth(), 1u);
    EXPECT_EQ(split.depth(), 2u);
    // The far edges belong to the last cells.
    EXPECT_EQ(plain.pdf({1, 1}), 0.5);
    EXPECT_EQ(plain.pdf({1, 0}), 1);
}

TEST(Quadtree, EmptyTreesAreUniform)
{
    for (const Quadtree& tree : {Quadtree(), Quadtree({Node{{}, {0, 1, 0, 0}}, Node{}})}) {
        Pcg32 random(1);
        EXPECT_EQ(tree.total(), 0);
        EXPECT_EQ(onGrid(tree, 3), std::vector<double>(64, 1));
        EXPECT_GT(chiSquareOfSamples(tree, std::vector<double>(64, 1), 3, 100000, 2).p, 1e-3);
    }
}

TEST(Quadtree, DensityIntegratesToOneAndIsSampled)
{
    Pcg32 random(601);
    for (int i = 0; i < 6; ++i) {
        const Quadtree tree = randomTree(random, 5);
        const std::vector<double> densities = onGrid(tree, 6);
        EXPECT_NEAR(mean(densities), 1, 1e-12);
        // The grid is finer than the tree, so that places inside leaves are tested as well.
        const tests::ChiSquare chi =
            chiSquareOfSamples(tree, densities, 6, 200000, 700 + static_cast<uint32_t>(i));
        EXPECT_GT(chi.p, 1e-3);
        EXPECT_EQ(chi.outside, 0);
    }
}

TEST(Quadtree, WrongSumsAreSeen)
{
    // The chi-square above must notice a tree whose quarters are swapped.
    const Quadtree right({Node{{4, 2, 1, 1}, {}}}), wrong({Node{{4, 1, 2, 1}, {}}});
    EXPECT_LT(chiSquareOfSamples(wrong, onGrid(right, 2), 2, 10000, 3).p, 1e-6);
}

TEST(Quadtree, ExtremeSums)
{
    Pcg32 random(602);
    for (const float scale : {1e-30f, 1e30f}) {
        const Quadtree tree =
            randomTree(random, 6, [&] { return scale * static_cast<float>(random() + 0.1); });
        EXPECT_NEAR(mean(onGrid(tree, 7)), 1, 1e-12);
    }
    const Quadtree tree = randomTree(random, 6, [&] { return random() < 0.5 ? 1e-30f : 1e30f; });
    EXPECT_NEAR(mean(onGrid(tree, 7)), 1, 1e-12);
    for (int i = 0; i < 100000; ++i) {
        const Quadtree::Sample s = tree.sample(random);
        ASSERT_TRUE(s.pdf > 0 && std::isfinite(s.pdf));
        ASSERT_TRUE(s.x.x >= 0 && s.x.x < 1 && s.x.y >= 0 && s.x.y < 1);
    }
    for (const double c : {1e-6, 0.7, 1e3}) {
        const Overlap o = overlap(tree, flatTree(), c);
        EXPECT_NEAR(o.overlap + o.residual, 1, 1e-12);
    }
}

TEST(Quadtree, DeepestLeafIsHitWhereItIs)
{
    // A chain to the last corner, twenty levels down: coordinates next to one.
    std::vector<Node> nodes(Quadtree::kMaxDepth);
    for (size_t i = 0; i < nodes.size(); ++i)
        nodes[i] = {{0, 0, 0, 1},
                    {0, 0, 0, static_cast<uint16_t>(i + 1 < nodes.size() ? i + 1 : 0)}};
    const Quadtree tree(std::move(nodes));
    EXPECT_EQ(tree.depth(), Quadtree::kMaxDepth);
    const double density = std::pow(4.0, Quadtree::kMaxDepth);
    EXPECT_DOUBLE_EQ(tree.pdf({1, 1}), density);
    EXPECT_EQ(tree.pdf({0.9, 0.9}), 0);
    const double last = 1 - 0x1p-53;
    for (const double u : {0.0, 0.3, last}) {
        const auto always = [u] { return u; };
        const Quadtree::Sample s = tree.sample(always);
        EXPECT_DOUBLE_EQ(s.pdf, density);
        EXPECT_DOUBLE_EQ(tree.pdf(s.x), density);
        EXPECT_LT(s.x.x, 1);
    }
    const Overlap o = overlap(flatTree(), tree, 1);
    EXPECT_NEAR(o.overlap, 1 / density, 1e-12 / density);
}

TEST(QuadtreeOverlap, ExampleOfQuarters)
{
    const double expected[][3] = {{0.5, 0.5, 0.5}, {1, 0.7125, 0.2875}, {2, 0.775, 0.225}};
    for (const auto& [c, o, r] : expected) {
        const Overlap found = overlap(flatTree(), exampleTree(true), c);
        EXPECT_NEAR(found.overlap, o, 1e-12) << c;
        EXPECT_NEAR(found.residual, r, 1e-12) << c;
    }
}

TEST(QuadtreeOverlap, IdentitiesOnRandomTrees)
{
    Pcg32 random(603);
    for (int i = 0; i < 30; ++i) {
        const Quadtree a = randomTree(random, 8), b = randomTree(random, 8);
        for (const double c : {0.0, 1e-6, 0.3, 1.0, 1.7, 40.0}) {
            const Overlap ab = overlap(a, b, c);
            EXPECT_NEAR(ab.overlap + ab.residual, 1, 1e-12);
            EXPECT_NEAR(ab.residual, ab.above.p - c * ab.above.q, 1e-12);
            EXPECT_NEAR(overlap(a, a, c).overlap, std::min(c, 1.0), 1e-12);
            if (c > 0) {
                EXPECT_NEAR(ab.overlap, c * overlap(b, a, 1 / c).overlap, 1e-12 * std::max(1.0, c));
            }
        }
        EXPECT_EQ(overlap(a, a, 1).residual, 0);
    }
}

TEST(QuadtreeOverlap, AgreesWithBruteForce)
{
    Pcg32 random(604);
    for (int i = 0; i < 4; ++i) {
        const Quadtree q = randomTree(random, 8), p = randomTree(random, 8);
        ASSERT_LE(std::max(q.depth(), p.depth()), 8u);
        const std::vector<double> qs = onGrid(q, 8), ps = onGrid(p, 8);
        for (const double c : {0.2, 1.0, 3.0}) {
            double common = 0, above = 0;
            for (size_t j = 0; j < qs.size(); ++j) {
                common += std::min(c * qs[j], ps[j]) / double(qs.size());
                if (ps[j] > c * qs[j]) above += qs[j] / double(qs.size());
            }
            const Overlap found = overlap(q, p, c);
            EXPECT_NEAR(found.overlap, common, 1e-12);
            EXPECT_NEAR(found.above.q, above, 1e-12);
        }
    }
}

TEST(QuadtreeOverlap, SolvesForC)
{
    Pcg32 random(605);
    for (int i = 0; i < 20; ++i) {
        const Quadtree q = randomTree(random, 6), p = randomTree(random, 6);
        for (const double n : {1.0, 8.0, 64.0}) {
            const double c = bestC(q, p, 8, n);
            EXPECT_NEAR(c * n / (8 * overlap(q, p, c).residual), 1, 1e-9);
        }
    }
    const Quadtree same = randomTree(random, 6);
    EXPECT_NEAR(bestC(same, same, 8, 2), 0.8, 1e-12);
}

/// Samples of the residual tree against (p - c q)+ / R in the cells that both trees resolve.
void expectSamplesOfResidual(const Quadtree& q, const Quadtree& p, double c, uint32_t level,
                             uint32_t seed)
{
    const Residual missing = residual(q, p, c);
    const double R = overlap(q, p, c).residual;
    EXPECT_NEAR(missing.mass, R, 1e-12);
    const std::vector<double> qs = onGrid(q, level), ps = onGrid(p, level),
                              rs = onGrid(missing.tree, level);
    std::vector<double> expected;
    for (size_t i = 0; i < qs.size(); ++i) {
        expected.push_back(std::max(ps[i] - c * qs[i], 0.0) / R);
        ASSERT_NEAR(rs[i], expected[i], 1e-5 * expected[i]);
    }
    const tests::ChiSquare chi = chiSquareOfSamples(missing.tree, expected, level, 300000, seed);
    EXPECT_GT(chi.p, 1e-3) << "c " << c;
    EXPECT_EQ(chi.outside, 0);
}

TEST(QuadtreeResidual, IsSampled)
{
    expectSamplesOfResidual(flatTree(), exampleTree(true), 1, 2, 21);
    Pcg32 random(606);
    const Quadtree q = randomTree(random, 5), p = randomTree(random, 5);
    for (const double c : {0.1, 0.5, 1.0, 2.0})
        expectSamplesOfResidual(q, p, c, 5, 30 + static_cast<uint32_t>(10 * c));
    expectSamplesOfResidual(Quadtree(), p, 0.6, 5, 22);
    expectSamplesOfResidual(q, Quadtree(), 0.6, 5, 23);
    // Nothing to reuse: all of p is missing.
    expectSamplesOfResidual(q, p, 0, 5, 24);
}

TEST(QuadtreeResidual, NothingMissing)
{
    Pcg32 random(607);
    const Quadtree q = randomTree(random, 6);
    for (const double c : {1.0, 2.0, 1e6}) {
        const Residual none = residual(q, q, c);
        EXPECT_EQ(none.mass, 0);
        EXPECT_EQ(none.tree.total(), 0);
        EXPECT_EQ(none.tree.nodes().size(), 1u);
        EXPECT_EQ(none.tree.pdf({0.3, 0.8}), 1);
    }
    EXPECT_NEAR(residual(q, q, 0.75).mass, 0.25, 1e-12);
}

/// A full tree below two of the root's quarters, so that two such trees together are too many.
Quadtree fullTree(Pcg32& random, uint32_t levels, size_t first)
{
    std::vector<Node> nodes(1);
    std::vector<size_t> front = {0};
    for (uint32_t level = 0; level < levels; ++level) {
        std::vector<size_t> next;
        for (const size_t at : front) {
            for (size_t i = 0; i < 4; ++i) {
                if (at == 0 && i / 2 != first) continue;
                nodes[at].child[i] = static_cast<uint16_t>(nodes.size());
                next.push_back(nodes.size());
                nodes.emplace_back();
            }
        }
        front = next;
    }
    for (Node& node : nodes)
        for (float& sum : node.sum) sum = static_cast<float>(0.05 + random());
    nodes[0].sum.fill(36000);  // as much as in the quarters below which there are 4^8 leaves
    return Quadtree(std::move(nodes));
}

TEST(QuadtreeResidual, MoreLeavesThanATreeCanHave)
{
    Pcg32 random(608);
    const Quadtree q = fullTree(random, 8, 0), p = fullTree(random, 8, 1);
    ASSERT_GT(q.nodes().size() + p.nodes().size(), size_t(Quadtree::kMaxNodes));
    const Residual missing = residual(q, p, 0.8);
    EXPECT_EQ(missing.tree.nodes().size(), Quadtree::kMaxNodes);
    EXPECT_NEAR(missing.mass, overlap(q, p, 0.8).residual, 1e-12);
    EXPECT_NEAR(mean(onGrid(missing.tree, 9)), 1, 1e-12);
    const std::vector<double> qs = onGrid(q, 9), ps = onGrid(p, 9), rs = onGrid(missing.tree, 9);
    size_t lost = 0;
    for (size_t i = 0; i < qs.size(); ++i) lost += ps[i] > 0.8 * qs[i] && !(rs[i] > 0);
    EXPECT_EQ(lost, 0u) << "where p > c q the residual must be positive";
}

}  // namespace
