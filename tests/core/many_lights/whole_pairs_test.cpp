// M25. Pairs of receivers and lights that are taken as a whole: where they may be, what is asked
// before, and what comes of it in rooms with shadows.
#include "core/many_lights/whole_pairs.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <set>

#include "core/many_lights/flat_lights.h"
#include "core/many_lights/illumination_cut.h"
#include "tests/support/methods/light_stage.h"
#include "tests/support/scenes/asset.h"
#include "tests/support/scenes/test_scenes.h"

namespace core::many_lights {
namespace {

using namespace tests;
using glm::vec3;

/// The receivers of a picture as one slice, in the order of their tree.
struct StagePairs : StageRows {
    SlicePairs pairs;

    explicit StagePairs(const LightStage& stage) : StageRows(stage)
    {
        pairs.reset(job, stage.lights->tree, receivers, chosen);
    }

    Column light(uint32_t index) const { return columnOf(job.lights->lights[index], 1, index, 0); }
    float weight(uint32_t row, uint32_t index)
    {
        pairs.rows.weigh(light(index), job.gather, {row, row + 1}, pairs.weights);
        return pairs.weights[row];
    }
};

/// Lights in a unit cube: on its faces, or facing anywhere.
std::vector<VirtualLight> lightsOf(bool flat, uint32_t count)
{
    Pcg32 random(3, flat ? 1 : 0);
    std::vector<VirtualLight> lights(count);
    for (uint32_t i = 0; i < count; ++i) {
        VirtualLight& l = lights[i];
        l.position = vec3(random(), random(), random());
        l.normal = glm::normalize(vec3(random(), random(), random()) - 0.5f);
        l.importance = 1;
        if (!flat) continue;
        const int axis = static_cast<int>(i % 3);
        l.position[axis] = i % 2 == 0 ? 0.0f : 1.0f;
        l.normal = vec3(0);
        l.normal[axis] = i % 2 == 0 ? 1.0f : -1.0f;
    }
    return lights;
}

TEST(FlatLights, LieOnWallsAndNotAnywhere)
{
    for (const uint32_t count : {50u, 100u, 3000u, 20000u}) {
        EXPECT_TRUE(lieInFewPlanes(*makeLightTree(lightsOf(true, count), {}))) << count;
        EXPECT_FALSE(lieInFewPlanes(*makeLightTree(lightsOf(false, count), {}))) << count;
        // A fifth of them on something else.
        std::vector<VirtualLight> mixed = lightsOf(true, count);
        const std::vector<VirtualLight> others = lightsOf(false, count);
        for (uint32_t i = 0; i < count; i += 5) mixed[i] = others[i];
        EXPECT_FALSE(lieInFewPlanes(*makeLightTree(mixed, {}))) << count;
    }
    EXPECT_FALSE(lieInFewPlanes(*makeLightTree({}, {})));
}

TEST(FlatLights, SlicesOfWallsAreFlatAndGlossyOnesDoNotCount)
{
    for (const char* name : {"cornell-diffuse", "cornell-glossy"}) {
        const LightStage stage(asset(name), 24, 200);
        const StagePairs s(stage);
        EXPECT_EQ(areFewFlatPieces(s.pairs.pixels, s.pairs.rows),
                  name == std::string("cornell-diffuse"));
    }
    const LightStage ball(asset("furnace-sphere"), 24, 200);
    const StagePairs s(ball);
    EXPECT_FALSE(areFewFlatPieces(s.pairs.pixels, s.pairs.rows));
}

TEST(PairSamples, AreOfTheirPairAndHoldItsCorners)
{
    const LightStage stage(asset("cornell-diffuse"), 12, 300);
    const StagePairs s(stage);
    const LightTree& tree = stage.lights->tree;
    const NodeLights nodeLights(tree);
    std::vector<Outermost> outermost;
    outermostRows(s.pairs.pixels, s.pairs.rows, outermost);
    Pcg32 random(5, 0);
    for (uint32_t i = 0; i < tree.nodes.size(); i += 3) {
        std::set<uint32_t> below;
        for (uint32_t j = i; j < i + 2 * tree.nodes[i].count - 1; ++j)
            if (tree.nodes[j].isLeaf()) below.insert(tree.nodes[j].representative);
        ASSERT_EQ(below.size(), tree.nodes[i].count);
        for (uint32_t p = 0; p < s.pairs.pixels.nodes().size(); p += 5) {
            const PixelNode& node = s.pairs.pixels.nodes()[p];
            if (uint64_t(node.rows.size()) * below.size() <= 16) continue;
            std::array<PairSample, 16> samples;
            samplePair(node, outermost[p], tree.nodes[i], i, nodeLights, random, samples);
            std::set<uint32_t> rows;
            for (const PairSample& sample : samples) {
                EXPECT_TRUE(node.rows.begin <= sample.row && sample.row < node.rows.end);
                EXPECT_TRUE(below.contains(sample.light));
                rows.insert(sample.row);
            }
            for (const uint32_t row : outermost[p]) EXPECT_TRUE(rows.contains(row)) << row;
        }
    }
}

/// All bits alike or none, and never of next to no samples unless these do not matter.
TEST(WholePairs, AreNoneWhoseSamplesDiffer)
{
    for (uint64_t asked = 0; asked < 256; ++asked) {
        for (uint64_t visible = 0; visible < 256; ++visible) {
            if ((visible & ~asked) != 0) continue;
            for (const bool few : {false, true}) {
                const Agreement found = agreementOf(asked, visible, few);
                const bool enough = few || std::popcount(asked) >= 4;
                const bool differ = visible != 0 && visible != asked;
                EXPECT_EQ(found == Agreement::none, differ || !enough);
                EXPECT_TRUE(found != Agreement::visible || visible == asked);
                EXPECT_TRUE(found != Agreement::hidden || visible == 0);
            }
        }
    }
}

/// What is said to be behind a horizon gets next to nothing: cosines of a ten thousandth.
TEST(WholePairs, NothingIsDroppedThatFacesEachOther)
{
    const LightStage stage(asset("cornell-diffuse"), 16, 200);
    StagePairs s(stage);
    const LightTree& tree = stage.lights->tree;
    const uint32_t root = tree.roots[size_t(LightKind::surface)];
    const NodeLights lights(tree);
    uint32_t dropped = 0, kept = 0;
    for (uint32_t p = 0; p < s.pairs.pixels.nodes().size(); ++p) {
        const PixelNode& node = s.pairs.pixels.nodes()[p];
        for (uint32_t i = root; i < root + 2 * tree.nodes[root].count - 1; i += 3) {
            if (mayFace(node, tree.nodes[i], LightKind::surface)) {
                ++kept;
                continue;
            }
            ++dropped;
            const float clamp2 = s.job.gather.clampDistance * s.job.gather.clampDistance;
            for (uint32_t row = node.rows.begin; row < node.rows.end; ++row)
                for (uint32_t k = 0; k < tree.nodes[i].count; ++k)
                    ASSERT_LE(s.weight(row, lights.light(i, k)) * clamp2, 1e-3f);
        }
    }
    EXPECT_GT(dropped, 1000u);
    EXPECT_GT(kept, 1000u);
}

/// Luminance that a row gets from all lights, shadows included.
double lightOf(StagePairs& s, uint32_t row)
{
    const IndexRange range{row, row + 1};
    s.pairs.rows.clear(range);
    ShadowPackets packets(*s.job.receivers.accel, s.pairs.rows);
    for (uint32_t i = 0; i < s.job.lights->lights.size(); ++i) {
        if (!(s.weight(row, i) > 0)) continue;
        uint64_t visible = 0;
        packets.add(ShadowTarget(s.light(i)), row, &visible, 1);
        packets.flush();
        if (visible != 0) s.pairs.rows.add(s.light(i), *s.job.lights, range, s.pairs.weights);
    }
    return double(shared::luminance(s.pairs.rows.radiance(row)));
}

/// In a lit box, and in a room that all light enters by a gap, where most rows see next to nothing
/// of what would come: those whose light is lowered get less, but for few, and few are lowered.
TEST(DarkRows, AreThoseThatGetLess)
{
    for (const char* name : {"cornell-diffuse", "door-ajar"}) {
        const LightStage stage(asset(name), 40, 400);
        StagePairs s(stage);
        RoughLight rough;
        Pcg32 random(9, 0);
        ASSERT_TRUE(rough.find(s.pairs, true, random, {}));
        const auto nodes = s.pairs.pixels.nodes();
        std::vector<double> before(nodes.size());
        for (uint32_t i = 0; i < nodes.size(); ++i) before[i] = rough.of(i);
        DarkRows dark;
        dark.find(s.pairs, rough, random);
        uint32_t lowered = 0, wrong = 0, leaves = 0;
        for (uint32_t i = 0; i < nodes.size(); ++i) {
            EXPECT_LE(rough.of(i), before[i]);
            if (!nodes[i].isLeaf()) {
                const uint32_t row = dark.darkest(i);
                EXPECT_TRUE(nodes[i].rows.begin <= row && row < nodes[i].rows.end);
                continue;
            }
            ++leaves;
            if (!(rough.of(i) < 0.5 * before[i])) continue;
            ++lowered;
            if (lightOf(s, nodes[i].rows.begin) > 0.5 * before[i]) ++wrong;
        }
        EXPECT_GT(lowered, 0u) << name;
        EXPECT_LT(lowered, leaves / 20) << name;
        EXPECT_LE(wrong, lowered / 10) << name;
    }
}

/// A box with the shadows of two blocks is near the sum over all lights for a part of the rays, in
/// the same bits on any number of threads.
TEST(WholePairs, LightABoxWithShadowsForFewRays)
{
    LightStage stage(asset("cornell-diffuse"), 96, 2000);
    stage.settings.sliceSize = 250;
    ASSERT_TRUE(lieInFewPlanes(stage.lights->tree));
    const core::Image all = stage.all();
    double sum = 0, mean = 0;
    FrameStats stats;
    const core::Image found = stage.image(Technique::illuminationCut, 0, 0.005f, 1, &stats);
    for (size_t i = 0; i < all.pixels.size(); ++i) {
        const double d = double(found.pixels[i]) - double(all.pixels[i]);
        sum += d * d;
        mean += double(all.pixels[i]);
    }
    const auto n = static_cast<double>(all.pixels.size());
    EXPECT_LT(std::sqrt(sum / n) / (mean / n), 0.004);
    EXPECT_LT(stats.slices.completion.visibility(), 0.25);
    const core::ThreadLimit one(1);
    EXPECT_EQ(stage.image(Technique::illuminationCut, 0, 0.005f, 1).pixels, found.pixels);
}

}  // namespace
}  // namespace core::many_lights
