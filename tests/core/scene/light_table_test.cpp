// T12 and T13: the choice of an emitter and of an environment texel happens exactly as often as its
// probability says.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "core/scene/light_table.h"
#include "core/trace/scene_view.h"
#include "shared/lights.h"
#include "tests/support/scenes/test_scenes.h"
#include "tests/support/statistics/stats.h"

namespace {

using namespace tests;

/// Emitter powers over `decades`, with zeros in between.
std::vector<double> spreadWeights(size_t count, double decades, std::mt19937& random)
{
    std::uniform_real_distribution<double> exponent(-decades, 0);
    std::vector<double> weights(count);
    for (size_t i = 0; i < count; ++i)
        weights[i] = i % 7 == 3 ? 0.0 : std::pow(10.0, exponent(random));
    return weights;
}

TEST(LightTable, CdfEndsAndIsExact)
{
    std::mt19937 random(1);
    for (const size_t count : {1u, 2u, 3u, 1000u, 100000u}) {
        const std::vector<double> weights = spreadWeights(count, 12, random);
        const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
        const std::vector<float> cdf = core::makeCdf(weights);
        ASSERT_EQ(cdf.size(), count + 1);
        EXPECT_EQ(cdf.front(), 0.0f);
        EXPECT_EQ(cdf.back(), 1.0f);
        double sum = 0;
        for (size_t i = 0; i < count; ++i) {
            const double pmf = static_cast<double>(cdf[i + 1] - cdf[i]);
            sum += pmf;
            if (weights[i] == 0) {
                ASSERT_EQ(pmf, 0.0) << i;
            } else {
                // One unit each first, the rest in proportion: off by at most a unit and the share
                // of those units.
                const double unit = std::exp2(-24.0), share = weights[i] / total;
                ASSERT_GE(pmf, unit) << i;
                ASSERT_NEAR(pmf, share, 2 * unit + share * static_cast<double>(count) * unit) << i;
            }
        }
        EXPECT_EQ(sum, 1.0);  // multiples of 2^-24: the sum is exact
    }
}

TEST(LightTable, ZeroEverywhereIsUniform)
{
    const std::vector<float> cdf = core::makeCdf(std::vector<double>(4, 0.0));
    for (size_t i = 0; i <= 4; ++i) EXPECT_EQ(cdf[i], 0.25f * static_cast<float>(i));
}

/// A scene with lamps of every kind, some without power or area.
SceneBuilder lampScene()
{
    SceneBuilder b;
    const int grey = b.material(lambert(glm::vec3(0.5f)));
    b.quad({-5, 0, 5}, {10, 0, 0}, {0, 0, -10}, grey);
    for (int i = 0; i < 40; ++i) {
        const float strength =
            i % 5 == 2 ? 0.0f : std::pow(10.0f, 0.1f * static_cast<float>(i) - 2.0f);
        const int lamp = b.material(emitter(strength * glm::vec3(1, 0.5f, 0.2f)));
        const float x = 0.2f * static_cast<float>(i) - 4.0f;
        b.quad({x, 3, 0}, {0.1f, 0, 0}, {0, 0, 0.1f + 0.02f * static_cast<float>(i)}, lamp);
    }
    const int lamp = b.material(emitter(glm::vec3(3)));
    b.mesh({{0, 4, 0}, {1, 4, 0}, {2, 4, 0}}, {{0, 1, 2}}, lamp);  // no area
    core::PunctualLight point;
    point.intensity = 5;
    b.light(point, glm::dmat4(1));
    point.intensity = 0;
    b.light(point, glm::dmat4(1));
    b.constantEnvironment(glm::vec3(0.1f));
    b.scene.sun = core::Sun{{0, 1, 0}, 0.00465f, glm::vec3(1000)};
    return b;
}

/// The intervals that are stored for parts of [0,1) lead to the one that a plain scan finds, at the
/// ends of parts and of intervals, too, and with rows that are black.
TEST(LightTable, PartsLeadToTheIntervalThatAScanFinds)
{
    std::mt19937 random(4);
    for (const glm::uvec2 size : {glm::uvec2(1, 1), {3, 2}, {128, 5}, {129, 130}, {1000, 3}}) {
        std::vector<double> weights = spreadWeights(size_t(size.x) * size.y, 12, random);
        if (size.y > 1) std::fill_n(weights.begin(), size.x, 0.0);
        const std::vector<float> cdf = core::makeEnvironmentCdf(weights, size.x, size.y);
        shared::SceneView scene{};
        scene.environmentCdf = cdf.data();
        const uint32_t parts = shared::firstCdfPart(size.x, size.y);
        for (uint32_t i = 0; i <= size.y; ++i) {
            const uint32_t first = i == 0 ? 0 : size.y + 1 + (i - 1) * (size.x + 1);
            const std::span own(cdf.data() + first, (i == 0 ? size.y : size.x) + 1);
            std::vector<float> numbers(own.begin(), own.end() - 1);
            for (uint32_t k = 0; k < shared::kCdfParts; ++k) {
                const float u = static_cast<float>(k) / shared::kCdfParts;
                numbers.insert(numbers.end(), {u, std::nextafter(u, 0.0f),
                                               shared::unitFloat(static_cast<uint32_t>(random()))});
            }
            for (float u : numbers) {
                if (!(u < 1)) continue;
                const auto above = std::upper_bound(own.begin(), own.end(), u);
                const auto expected = static_cast<uint32_t>(above - own.begin() - 1);
                float pmf = 0, rest = u;
                ASSERT_EQ(shared::invertEnvironmentCdf(
                              scene, first, parts + i * (shared::kCdfParts + 1), rest, pmf),
                          expected)
                    << u << " in row " << i << " of " << size.x << "x" << size.y;
                ASSERT_EQ(pmf, own[expected + 1] - own[expected]);
            }
        }
    }
}

TEST(LightTable, EmittersAreChosenByTheirProbability)
{
    const auto world = lampScene().world();
    // 32 of 40 lamps shine, two triangles each; one point light; environment; sun.
    ASSERT_EQ(world->emitters.size(), 67u);
    const shared::SceneView scene = core::sceneView(*world);
    const uint32_t count = static_cast<uint32_t>(world->emitters.size());
    std::vector<double> observed(count), expected(count);
    std::mt19937 random(7);
    const int draws = 1'000'000;
    for (int i = 0; i < draws; ++i) {
        const float u = static_cast<float>(random() >> 8) * 0x1p-24f;
        float pmf = 0;
        const uint32_t chosen = shared::chooseEmitter(scene, count, u, pmf);
        ASSERT_LT(chosen, count);
        ASSERT_EQ(pmf, shared::pmfEmitter(scene, chosen));
        observed[chosen] += 1;
    }
    double sum = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const double pmf = static_cast<double>(shared::pmfEmitter(scene, i));
        EXPECT_GT(pmf, 0.0);
        sum += pmf;
        expected[i] = pmf * draws;
    }
    EXPECT_NEAR(sum, 1.0, 1e-5);
    EXPECT_GT(chiSquareTest(observed, expected).p, kLevel);
}

TEST(LightTable, TriangleNamesItsEmitter)
{
    const auto world = lampScene().world();
    ASSERT_EQ(world->triangleEmitter.size(), world->triangles.size());
    size_t named = 0;
    for (uint32_t t = 0; t < world->triangles.size(); ++t) {
        const uint32_t emitter = world->triangleEmitter[t];
        const bool emits = world->materials[world->triangles[t].material].emissive.x > 0;
        ASSERT_EQ(emitter != shared::kNone, emits);
        if (!emits) continue;
        ++named;
        EXPECT_EQ(world->emitters[emitter].slot, t);
        EXPECT_EQ(world->emitters[emitter].a, world->positions[world->triangles[t].v0]);
    }
    EXPECT_EQ(named, 64u);
}

// --- environment

struct EnvironmentCase {
    const char* name;
    uint32_t width, height;
    float (*radiance)(uint32_t x, uint32_t y);
};

std::shared_ptr<const core::World> environmentWorld(const EnvironmentCase& c)
{
    SceneBuilder b;
    b.quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, b.material(lambert(glm::vec3(0.5f))));
    core::Environment e;
    e.width = c.width;
    e.height = c.height;
    for (uint32_t y = 0; y < c.height; ++y) {
        for (uint32_t x = 0; x < c.width; ++x)
            e.texels.emplace_back(glm::vec3(c.radiance(x, y)), 1.0f);
    }
    b.scene.environment = std::move(e);
    return b.world();
}

const EnvironmentCase kEnvironments[] = {
    {"constant", 16, 8, [](uint32_t, uint32_t) { return 1.0f; }},
    {"pole", 32, 16, [](uint32_t, uint32_t y) { return y == 0 ? 50.0f : 0.1f; }},
    {"seam", 32, 16, [](uint32_t x, uint32_t) { return x == 0 || x == 31 ? 20.0f : 0.0f; }},
    {"one-texel sun", 64, 32,
     [](uint32_t x, uint32_t y) { return x == 17 && y == 9 ? 1e9f : 1e-2f; }},
    {"one-texel sun alone", 64, 32,
     [](uint32_t x, uint32_t y) { return x == 0 && y == 31 ? 1e9f : 0.0f; }},
};

class EnvironmentTable : public testing::TestWithParam<EnvironmentCase> {};

TEST_P(EnvironmentTable, TexelsAreDrawnByTheirDensity)
{
    const auto world = environmentWorld(GetParam());
    const shared::SceneView scene = core::sceneView(*world);
    const shared::PathSettings settings = core::worldSettings(*world);
    const uint32_t width = settings.environmentWidth, height = settings.environmentHeight;
    // Cells are half texels in each direction, shifted against the texels by the seam and the poles
    // themselves; their expectation comes from integrating the density that renderers divide by,
    // not from the table.
    const uint32_t across = 2 * width, down = 2 * height;
    std::vector<double> observed(size_t(across) * down), expected(observed.size());
    const int draws = 1'000'000;
    int moved = 0;  // into another texel by rounding
    std::mt19937 random(11);
    for (int i = 0; i < draws; ++i) {
        const glm::vec2 u(static_cast<float>(random() >> 8) * 0x1p-24f,
                          static_cast<float>(random() >> 8) * 0x1p-24f);
        shared::EmitterSample s;
        if (!shared::sampleEnvironment(scene, settings, 0, u, s)) continue;
        moved += std::abs(shared::pdfEnvironment(scene, settings, 0, s.wi) / s.pdf - 1) > 1e-3f;
        const glm::vec2 uv = shared::environmentUv(s.wi);
        const auto x =
            std::min(static_cast<uint32_t>(uv.x * static_cast<float>(across)), across - 1);
        const auto y = std::min(static_cast<uint32_t>(uv.y * static_cast<float>(down)), down - 1);
        observed[y * across + x] += 1;
    }
    const int steps = 8;
    double total = 0;
    for (uint32_t y = 0; y < down; ++y) {
        for (uint32_t x = 0; x < across; ++x) {
            double integral = 0;
            for (int k = 0; k < steps;
                 ++k) {  // the density depends on the row's sine only, inside a texel
                const double v = (y + (k + 0.5) / steps) / down;
                const glm::vec3 d = shared::environmentDirection(
                    {(static_cast<float>(x) + 0.5f) / static_cast<float>(across),
                     static_cast<float>(v)});
                integral += static_cast<double>(shared::pdfEnvironment(scene, settings, 0, d)) *
                            std::sin(std::numbers::pi * v);
            }
            const double cell = 2 * std::numbers::pi * std::numbers::pi / (double(across) * down);
            expected[y * across + x] = integral / steps * cell * draws;
            total += expected[y * across + x] / draws;
        }
    }
    EXPECT_NEAR(total, 1.0, 1e-4);  // the density is normalised
    const ChiSquare test = chiSquareTest(observed, expected);
    EXPECT_GT(test.p, kLevel) << "chi-square " << test.statistic << " of " << test.degreesOfFreedom;
    EXPECT_LE(moved, 1e-4 * draws);
    // Rounding may carry a sample over the border of a texel that is never drawn.
    EXPECT_LE(test.outside, 1e-5 * draws);
}

TEST_P(EnvironmentTable, RadianceHasDensityEverywhere)
{
    const auto world = environmentWorld(GetParam());
    const shared::SceneView scene = core::sceneView(*world);
    const shared::PathSettings settings = core::worldSettings(*world);
    std::mt19937 random(13);
    size_t lit = 0;
    for (int i = 0; i < 200'000; ++i) {
        const glm::vec2 u(static_cast<float>(random() >> 8) * 0x1p-24f,
                          static_cast<float>(random() >> 8) * 0x1p-24f);
        const glm::vec3 d = shared::environmentDirection(u);
        if (!(shared::environmentRadiance(scene, settings, d).x > 0)) continue;
        ++lit;
        ASSERT_GT(shared::pdfEnvironment(scene, settings, 0, d), 0.0f) << u.x << ' ' << u.y;
    }
    EXPECT_GT(lit, 100u);
}

/// The estimate of the total from samples equals the sum over texels, in double.
TEST_P(EnvironmentTable, EstimatesItsOwnPower)
{
    const auto world = environmentWorld(GetParam());
    const shared::SceneView scene = core::sceneView(*world);
    const shared::PathSettings settings = core::worldSettings(*world);
    const std::vector<double> weights = core::environmentWeights(
        world->environment, settings.environmentWidth, settings.environmentHeight);
    // Mean over the texel is by the bilinear footprint, its sine by the row's own mean
    double exact = 0;
    using std::numbers::pi;
    const uint32_t width = settings.environmentWidth, height = settings.environmentHeight;
    const int fine = 32;
    for (uint32_t y = 0; y < height * fine; ++y) {
        const double v = (y + 0.5) / (height * fine);
        double row = 0;
        for (uint32_t x = 0; x < width * 8; ++x) {
            const glm::vec3 d = shared::environmentDirection(
                {(static_cast<float>(x) + 0.5f) / static_cast<float>(width * 8),
                 static_cast<float>(v)});
            row += static_cast<double>(shared::environmentRadiance(scene, settings, d).x);
        }
        exact += row / (width * 8) * std::sin(pi * v) * 2 * pi * pi / (height * fine);
    }
    Moments estimate;
    std::mt19937 random(17);
    for (int i = 0; i < 1'000'000; ++i) {
        const glm::vec2 u(static_cast<float>(random() >> 8) * 0x1p-24f,
                          static_cast<float>(random() >> 8) * 0x1p-24f);
        shared::EmitterSample s;
        const bool found = shared::sampleEnvironment(scene, settings, 0, u, s);
        estimate.add(found ? static_cast<double>(s.radiance.x) / static_cast<double>(s.pdf) : 0.0);
    }
    const Comparison c = againstExact(estimate, exact);
    EXPECT_LT(std::abs(estimate.mean() / exact - 1),
              1e-3 + kScore * std::sqrt(estimate.varianceOfMean()) / exact);
    EXPECT_LT(c.detectable, 0.01) << "underpowered";
    // What the table believes the environment sends is what it sends, up to the sine inside a
    // texel.
    EXPECT_NEAR(std::accumulate(weights.begin(), weights.end(), 0.0) / exact, 1.0, 0.2);
}

INSTANTIATE_TEST_SUITE_P(T13, EnvironmentTable, testing::ValuesIn(kEnvironments),
                         [](const auto& testCase) {
                             std::string name = testCase.param.name;
                             for (char& c : name) {
                                 if (c == ' ' || c == '-') c = '_';
                             }
                             return name;
                         });

}  // namespace
