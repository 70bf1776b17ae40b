// M9, M17. Cuts through the tree of lights: of slices, for all of their rows, and of single
// receivers, where no node may err by more than its part.
#include "core/many_lights/lightcuts.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/many_lights/sphere_bound.h"
#include "tests/support/methods/light_stage.h"
#include "tests/support/scenes/asset.h"
#include "tests/support/statistics/stats.h"

namespace core::many_lights {
namespace {

using namespace tests;

/// Mean squared error over rows and trees of what a cut of 100 clusters adds, nothing in between.
double cutError(StageRows& r, const CutQuery& query)
{
    const std::vector<VirtualLight>& lights = r.job.lights->lights;
    std::vector<float> weights(r.rows.count());
    const auto add = [&](uint32_t light, float scale) {
        const Column column = columnOf(lights[light], scale, 0, 0);
        r.rows.weigh(column, r.job.gather, weights);
        r.rows.add(column, *r.job.lights, weights);
    };
    const auto sums = [&] {
        std::vector<double> found;
        for (uint32_t row = 0; row < r.rows.count(); ++row)
            found.push_back(double(shared::luminance(r.rows.radiance(row))));
        r.rows.clear({0, r.rows.count()});
        return found;
    };
    for (uint32_t i = 0; i < lights.size(); ++i) add(i, 1);
    const std::vector<double> exact = sums();
    Moments errors;
    CutMemory memory;
    std::vector<LightCluster> cut;
    for (uint32_t seed = 0; seed < 20; ++seed) {
        cutLightTree(*makeLightTree(lights, {0.1f, seed}), query, 100, memory, cut);
        for (const LightCluster& c : cut) add(c.light, c.scale);
        const std::vector<double> found = sums();
        for (size_t row = 0; row < found.size(); ++row)
            errors.add((found[row] - exact[row]) * (found[row] - exact[row]));
    }
    return errors.mean();
}

/// One slice around a corner: lights that its mean does not face matter to some of its rows.
TEST(Slices, CutsCountLightsThatOnlySomeRowsFace)
{
    for (const char* name : {"cornell-diffuse", "lights"}) {
        const LightStage stage(asset(name), 16, 500);
        StageRows r(stage);
        const CutQuery query = r.rows.query(r.job.gather);
        EXPECT_GT(query.spread, 0);
        EXPECT_LT(query.cosHalf, 0.98f);
        CutQuery mean = query;
        mean.cosHalf = 1;
        mean.sinHalf = mean.spread = 0;
        EXPECT_LT(2 * cutError(r, query), cutError(r, mean)) << name;
    }
}

/// The luminance of all lights below a node, with nothing in between.
double open(StageRows& r, const LightTree& tree, uint32_t index, uint32_t row)
{
    const LightNode& node = tree.nodes[index];
    if (!node.isLeaf()) return open(r, tree, index + 1, row) + open(r, tree, node.right, row);
    const Column column = columnOf(r.job.lights->lights[node.representative], 1, 0, 0);
    std::vector<float> weights(r.rows.count());
    const core::IndexRange range{row, row + 1};
    r.rows.weigh(column, r.job.gather, range, weights);
    r.rows.clear(range);
    r.rows.add(column, *r.job.lights, range, weights);
    return double(shared::luminance(r.rows.radiance(row)));
}

/// A cut ends where no node can err by more than a part of the sum, unless it may have no more
/// nodes; every light is in one node.
TEST(Lightcuts, NoNodeMayErrByMoreThanItsPart)
{
    const LightStage stage(asset("cornell-diffuse"), 8, 400);
    StageRows r(stage);
    const LightTree& tree = stage.lights->tree;
    const float error = 0.02f;
    LightcutGroup group(r.job, tree, 1u << 30, error);
    size_t nodes = 0, inner = 0;
    for (uint32_t begin = 0; begin + LightcutGroup::kRows <= r.rows.count();
         begin += LightcutGroup::kRows) {
        ASSERT_TRUE(group.run(r.rows, {begin, begin + LightcutGroup::kRows}, {}));
        for (uint32_t k = 0; k < LightcutGroup::kRows; ++k) {
            const double total = double(shared::luminance(group.radiance(k)));
            uint32_t lights = 0;
            for (const CutEntry& entry : group.cut(k)) {
                const LightNode& node = tree.nodes[entry.node];
                lights += node.count;
                ++nodes;
                if (node.isLeaf()) continue;
                ++inner;
                EXPECT_LE(double(entry.bound), double(error) * total * 1.0001);
                EXPECT_LE(open(r, tree, entry.node, begin + k),
                          double(entry.bound) * 1.0001 + 1e-12);
            }
            EXPECT_EQ(lights, stage.lights->set.lights.size());
        }
    }
    EXPECT_GT(inner, nodes / 20) << "there is nothing to see";
    EXPECT_LT(nodes, r.rows.count() * stage.lights->set.lights.size() * 3 / 4);
}

/// The bound by distance alone is never below that by distance and cosines, nor, for receivers
/// anywhere in a sphere, below that of any of them.
TEST(Lightcuts, BoundsByDistanceAreTheLooser)
{
    for (const char* name : {"cornell-diffuse", "sky", "lights"}) {
        const LightStage stage(asset(name), 8, 200);
        StageRows r(stage);
        const LightTree& tree = stage.lights->tree;
        size_t finite = 0;
        for (uint32_t index = 0; index < tree.nodes.size(); ++index) {
            const LightNode& node = tree.nodes[index];
            const LightKind kind = stage.lights->set.lights[node.representative].kind;
            for (uint32_t row = 0; row + 1 < r.rows.count(); row += 5) {
                const CutQuery a = r.rows.queryAt(row, r.job.gather),
                               b = r.rows.queryAt(row + 1, r.job.gather);
                const float radius = glm::distance(a.position, b.position);
                const float loose =
                    sphereBound(node, kind, a.position, radius, r.job.gather.clampDistance);
                ASSERT_GE(loose, 0.999f * clusterBound(node, kind, a));
                ASSERT_GE(loose, 0.999f * clusterBound(node, kind, b));
                finite += std::isfinite(loose) ? 1u : 0u;
            }
        }
        EXPECT_GT(finite, tree.nodes.size()) << name;
    }
}

TEST(Lightcuts, HaveNoMoreNodesThanAllowed)
{
    const LightStage stage(asset("cornell-glossy"), 8, 400);
    StageRows r(stage);
    for (const uint32_t most : {1u, 2u, 9u, 100u}) {
        LightcutGroup group(r.job, stage.lights->tree, most, 1e-4f);
        ASSERT_TRUE(group.run(r.rows, {0, LightcutGroup::kRows}, {}));
        for (uint32_t k = 0; k < LightcutGroup::kRows; ++k) EXPECT_EQ(group.cut(k).size(), most);
    }
}

}  // namespace
}  // namespace core::many_lights
