// T9 and T10: scenes whose radiance is known everywhere. Inside a closed emitter of radiance Le and
// albedo a it is Le / (1 - a); a convex diffuse body in a constant environment L shows a L. Each
// for every estimator, then the estimators against each other where nothing is known.
#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/scenes/test_scenes.h"
#include "tests/support/statistics/stats.h"

namespace {

using namespace tests;
using core::Strategy;

void expectMean(const PictureMean& e, double exact, double mdb)
{
    EXPECT_LT(std::abs(score(e, exact)), kScore) << "mean " << e.mean << " instead of " << exact;
    EXPECT_LT(detectable(e, exact), mdb) << "underpowered";
}

/// A furnace of albedo `a` and emission 1 on all sides, seen from inside.
std::shared_ptr<const core::World> boxFurnace(float a)
{
    SceneBuilder b;
    b.box({-1, -1, -1}, {1, 1, 1}, b.material(emitter(glm::vec3(1), glm::vec3(a))), true);
    b.camera({0.1, 0.2, 0.3}, {1, 0.4, -0.5}, 1.2);
    return b.world();
}

std::shared_ptr<const core::World> sphereFurnace(float a)
{
    SceneBuilder b;
    b.sphere({0, 0, 0}, 1, 4, b.material(emitter(glm::vec3(1), glm::vec3(a))), true);
    b.camera({0.1, 0.2, 0.3}, {1, 0.4, -0.5}, 1.2);
    return b.world();
}

/// Light sampling alone has infinite variance in a box's corners (1 / r^2): it is tested in the
/// sphere only, where the geometry term is constant.
TEST(Furnace, ClosedBox)
{
    for (const float a : {0.5f, 0.8f}) {
        for (const Strategy strategy : {Strategy::mis, Strategy::bsdf}) {
            const uint32_t spp = a < 0.6f ? 240 : 360;
            const PictureMean e =
                estimate(render(boxFurnace(a), 64, 64, spp, independentParams(strategy)));
            SCOPED_TRACE(testing::Message() << "albedo " << a << ", " << core::enumName(strategy));
            expectMean(e, 1 / (1 - static_cast<double>(a)), 0.005);
        }
    }
}

TEST(Furnace, ClosedSphere)
{
    for (const Strategy strategy : {Strategy::mis, Strategy::bsdf, Strategy::light}) {
        const PictureMean e =
            estimate(render(sphereFurnace(0.5f), 64, 64, 240, independentParams(strategy)));
        SCOPED_TRACE(core::enumName(strategy));
        expectMean(e, 2, 0.005);
    }
}

/// With at most d scattering events the answer is the partial sum of the series (N15).
TEST(Furnace, DepthLimitCutsTheSeries)
{
    double exact = 0, power = 1;
    for (uint32_t depth = 0; depth <= 4; ++depth, power *= 0.8) {
        exact += power;
        core::PathParams params = independentParams(Strategy::mis, depth);
        params.rouletteDepth = 4096;
        SCOPED_TRACE(depth);
        const PictureMean e = estimate(render(sphereFurnace(0.8f), 32, 32, 32, params));
        EXPECT_LT(std::abs(score(e, exact)), kScore) << e.mean << " instead of " << exact;
        EXPECT_LT(detectable(e, exact), 0.01) << "underpowered";
    }
}

/// Roulette is unbiased, wherever it begins.
TEST(Furnace, RouletteIsPaidBack)
{
    for (const uint32_t roulette : {1u, 8u}) {
        core::PathParams params = independentParams();
        params.rouletteDepth = roulette;
        SCOPED_TRACE(roulette);
        expectMean(estimate(render(sphereFurnace(0.9f), 48, 48, 80, params)), 10, 0.02);
    }
}

TEST(Furnace, SphereInConstantEnvironment)
{
    SceneBuilder b;
    b.sphere({5, 2, -3}, 1, 4, b.material(lambert(glm::vec3(0.6f))));
    b.constantEnvironment(glm::vec3(2.0f));
    b.camera({5, 2, 2}, {5, 2, -3}, 0.2);  // sees nothing but the sphere
    const auto world = b.world();
    for (const Strategy strategy : {Strategy::mis, Strategy::bsdf, Strategy::light}) {
        SCOPED_TRACE(core::enumName(strategy));
        const uint32_t spp = strategy == Strategy::light ? 840 : 60;
        expectMean(estimate(render(world, 64, 64, spp, independentParams(strategy))), 1.2, 0.005);
    }
}

/// Emission from both faces of a sheet, and from the front of another only, seen directly.
TEST(Furnace, OneSidedEmittersAreBlackBehind)
{
    for (const bool twoSided : {false, true}) {
        SceneBuilder b;
        b.quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0},
               b.material(emitter(glm::vec3(3), glm::vec3(0), twoSided)));
        b.camera({0, 0, 5}, {0, 0, 0}, 0.1);
        b.camera({0, 0, -5}, {0, 0, 0}, 0.1);
        const auto world = b.world();
        EXPECT_NEAR(estimate(render(world, 8, 8, 2, independentParams(), 0)).mean, 3.0, 1e-6);
        EXPECT_NEAR(estimate(render(world, 8, 8, 2, independentParams(), 1)).mean,
                    twoSided ? 3.0 : 0.0, 1e-6);
    }
}

/// N9, N10: whatever its parameters, a white surface in a white environment gives back at most what
/// it gets, and no sample is lost to rounding.
TEST(Furnace, NoSurfaceCreatesEnergy)
{
    struct Case {
        float metallic, roughness, ior, transmission;
    };
    std::vector<Case> cases;
    for (const float alpha : {0.0f, 1e-6f, 1e-4f, 9e-4f, 1.1e-3f, 0.01f, 0.25f, 1.0f}) {
        cases.push_back({1, std::sqrt(alpha), 1.5f, 0});
        cases.push_back({0, std::sqrt(alpha), 1.5f, 0});
        cases.push_back({0, std::sqrt(alpha), 1.5f, 1});
    }
    for (const float ior : {1.0f, 1.0001f, 1 / 1.5f, 100.0f}) {
        cases.push_back({0, 0.0f, ior, 1});
        cases.push_back({0, 0.3f, ior, 1});
        cases.push_back({0, 0.3f, ior, 0});
    }
    double mirrorBelow = 0, mirrorAbove = 0;
    for (const Case& c : cases) {
        SceneBuilder b;
        core::Material m = glossy(glm::vec3(1), c.metallic, c.roughness);
        m.data.ior = c.ior;
        m.data.transmission = c.transmission;
        m.data.flags = c.transmission > 0 ? shared::kMaterialVolume : shared::kMaterialDoubleSided;
        b.sphere({0, 0, 0}, 1, 4, b.material(m), false, true);
        b.constantEnvironment(glm::vec3(1));
        b.camera({0, 0, 6}, {0, 0, 0}, 0.25);
        SCOPED_TRACE(testing::Message() << "metallic " << c.metallic << " roughness " << c.roughness
                                        << " ior " << c.ior << " transmission " << c.transmission);
        const PictureMean e = estimate(render(b.world(), 24, 24, 64, independentParams()));
        EXPECT_LT(e.mean, 1 + 1e-3 + kScore * std::sqrt(e.varianceOfMean));
        EXPECT_GT(e.mean, c.roughness > 0.9f ? 0.3 : 0.8);
        const float alpha = c.roughness * c.roughness;
        if (c.metallic > 0 && std::abs(alpha - 9e-4f) < 1e-5f) mirrorBelow = e.mean;
        if (c.metallic > 0 && std::abs(alpha - 1.1e-3f) < 1e-5f) mirrorAbove = e.mean;
    }
    EXPECT_NEAR(mirrorBelow / mirrorAbove, 1.0, 0.01);  // no step where the lobe becomes a delta
}

// --- T10: pairwise

/// Estimators of the same image agree: over the whole image, and on tiles of 8 x 8 pixels.
void expectAgreement(const core::Estimate& a, const core::Estimate& b, double mdb)
{
    const PictureMean ea = estimate(a), eb = estimate(b);
    EXPECT_LT(std::abs(score(ea, eb)), kScore) << ea.mean << " and " << eb.mean;
    EXPECT_LT(detectable(ea, eb), mdb) << "underpowered";
    const uint32_t tiles = a.mean.width / 8;
    const double limit = normalQuantile(1 - 0.5 * kLevel / (tiles * tiles));
    for (uint32_t tile = 0; tile < tiles * tiles; ++tile) {
        const glm::uvec2 low(tile % tiles * 8, tile / tiles * 8), high = low + 8u;
        EXPECT_LT(std::abs(score(estimate(a, low, high), estimate(b, low, high))), limit)
            << "tile " << tile;
    }
}

class Strategies : public testing::TestWithParam<float> {};

/// Diffuse (roughness below zero), rough and glossy rooms. BSDF sampling is the noisiest and sets
/// the power.
TEST_P(Strategies, AgreeInARoom)
{
    const float roughness = GetParam();
    const core::Material thing = roughness < 0
                                     ? lambert(glm::vec3(0.7f))
                                     : glossy(glm::vec3(0.7f, 0.6f, 0.4f), 0.5f, roughness);
    const auto world = room(lambert(glm::vec3(0.7f)), thing).world();
    const uint32_t size = 32, spp = 768;
    const core::Estimate mis = render(world, size, size, spp, independentParams(Strategy::mis, 5));
    core::PathParams other = independentParams(Strategy::bsdf, 5);
    other.seed = 2;
    const core::Estimate bsdf = render(world, size, size, 2 * spp, other);
    other.strategy = Strategy::light;
    other.seed = 3;
    const core::Estimate light = render(world, size, size, spp, other);
    {
        SCOPED_TRACE("mis and bsdf");
        expectAgreement(mis, bsdf, 0.03);
    }
    SCOPED_TRACE("mis and light");
    expectAgreement(mis, light, 0.03);
}

INSTANTIATE_TEST_SUITE_P(T10, Strategies, testing::Values(-1.0f, 0.7f, 0.25f));

}  // namespace
