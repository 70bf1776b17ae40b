// T32: thin smooth walls let light straight through, dimmed by their Fresnel transmission and tint:
// closed forms in double for every kind of light, by every strategy.
#include <cmath>
#include <functional>
#include <numbers>

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "core/methods/method.h"
#include "tests/support/scenes/test_scenes.h"
#include "tests/support/statistics/stats.h"

namespace {

using namespace tests;

using core::Strategy;
using std::numbers::pi;
constexpr double kFloorAlbedo = 0.6;

/// What one wall of index 1.5 lets through at this cosine: 1 - F, exact for unpolarised light.
double throughWall(double cosine)
{
    const double eta = 1.5, c = std::abs(cosine);
    const double t = std::sqrt(1 - (1 - c * c) / (eta * eta));
    const double s = (c - eta * t) / (c + eta * t), p = (t - eta * c) / (t + eta * c);
    return 1 - 0.5 * (s * s + p * p);
}

core::Material pane(const glm::vec3& tint = glm::vec3(1))
{
    core::Material m = lambert(tint);
    m.data.transmission = 1;
    m.data.roughness = 0;
    m.data.specular = 1;
    m.data.ior = 1.5f;
    return m;
}

/// A grey floor around the origin under horizontal walls, seen from below them.
struct House {
    SceneBuilder builder;

    explicit House(float size = 8)
    {
        builder.quad({-size, 0, size}, {2 * size, 0, 0}, {0, 0, -2 * size},
                     builder.material(lambert(glm::vec3(static_cast<float>(kFloorAlbedo)))));
        builder.camera({0.02, 0.05, 0.03}, {0, 0, 0}, 0.002);
    }

    void addWall(float y, const core::Material& material, float size = 2000)
    {
        builder.quad({-size, y, size}, {2 * size, 0, 0}, {0, 0, -2 * size},
                     builder.material(material));
    }

    /// Reflected radiance at the origin against albedo / pi times `irradiance`.
    void compare(double irradiance, uint32_t spp, Strategy strategy, uint32_t maxDepth) const
    {
        core::PathParams params = independentParams(strategy, maxDepth);
        params.rouletteDepth = 4096;
        compareBy(params, irradiance, spp, core::enumName(strategy));
    }
    /// The same with virtual lights, which panes block.
    void compareManyLights(double irradiance, uint32_t spp, uint32_t maxDepth) const
    {
        core::ManyLightsParams params;
        params.lights = 100;
        params.maxDepth = maxDepth;
        compareBy(params, irradiance, spp, "manylights");
    }

    /// The same with samples that are kept.
    void compareReuse(double irradiance, uint32_t spp, uint32_t maxDepth) const
    {
        core::ReuseParams params;
        params.maxDepth = maxDepth;
        params.sampler = core::SamplerKind::independent;
        compareBy(params, irradiance, spp, "reuse");
    }

private:
    void compareBy(const core::AnyParams& params, double irradiance, uint32_t spp,
                   std::string_view name) const
    {
        const PictureMean e = estimate(render(builder.world(), 16, 16, spp, params));
        const double exact = kFloorAlbedo / pi * irradiance;
        EXPECT_LT(std::abs(e.mean - exact), kScore * std::sqrt(e.varianceOfMean) + 1e-4 * exact)
            << e.mean << " instead of " << exact << ", " << name;
        EXPECT_LT(detectable(e, exact), 0.02) << "underpowered, " << name;
    }
};

TEST(Panes, PointLightBehindOne)
{
    House house;
    house.addWall(0.5f, pane());
    core::PunctualLight light;
    light.intensity = 7;
    const glm::dvec3 at(0.9, 1.7, -0.6);
    house.builder.light(light, glm::translate(glm::dmat4(1), at));
    const double cosine = at.y / glm::length(at);
    const double irradiance = 7 * cosine / glm::dot(at, at) * throughWall(cosine);
    house.compare(irradiance, 4, Strategy::mis, 2);
    house.compareManyLights(irradiance, 4, 2);
    house.compareReuse(irradiance, 4, 2);
}

/// A wall lets as much through whichever side it shows, and colours add up as products.
TEST(Panes, ManyTinted)
{
    House house;
    double through = 1;
    const glm::dvec3 at(0.9, 1.7, -0.6);
    const double cosine = at.y / glm::length(at);
    for (int i = 0; i < 5; ++i) {
        const float tint = 0.5f + 0.1f * static_cast<float>(i);
        house.addWall(0.2f + 0.1f * static_cast<float>(i), pane(glm::vec3(tint)),
                      i % 2 == 0 ? 2000.0f : -2000.0f);
        through *= static_cast<double>(tint) * throughWall(cosine);
    }
    core::PunctualLight light;
    light.intensity = 7;
    house.builder.light(light, glm::translate(glm::dmat4(1), at));
    const double irradiance = 7 * cosine / glm::dot(at, at) * through;
    house.compare(irradiance, 4, Strategy::mis, 6);
    house.compareManyLights(irradiance, 4, 6);
    house.compareReuse(irradiance, 4, 6);
}

/// A passage is a scattering event: paths that may scatter once do not come through.
TEST(Panes, PassagesCountAsEvents)
{
    for (const Strategy strategy : {Strategy::mis, Strategy::bsdf, Strategy::light}) {
        House house;
        house.addWall(0.5f, pane());
        house.builder.constantEnvironment(glm::vec3(1));
        const core::Estimate film =
            render(house.builder.world(), 8, 8, 16, independentParams(strategy, 1));
        EXPECT_EQ(estimate(film).mean, 0.0);
    }
}

class PanesBy : public testing::TestWithParam<Strategy> {};

TEST_P(PanesBy, ConstantEnvironment)
{
    House house(9000);  // what the wall reflects does not get past the floor
    house.addWall(0.5f, pane());
    house.builder.constantEnvironment(glm::vec3(1));
    double irradiance = 0;
    const int steps = 100'000;
    for (int i = 0; i < steps; ++i) {
        const double c = (i + 0.5) / steps;
        irradiance += 2 * pi * c * throughWall(c) / steps;
    }
    house.compare(irradiance, 1500, GetParam(), 2);
}

TEST_P(PanesBy, Sun)
{
    House house;
    house.addWall(0.5f, pane());
    house.addWall(0.7f, pane(glm::vec3(0.8f)));
    const double radius = 0.2;
    const glm::dvec3 towards = glm::normalize(glm::dvec3(0.5, 1, 0.2));
    house.builder.scene.sun = core::Sun{towards, static_cast<float>(radius), glm::vec3(10)};
    double irradiance = 0;
    const int rings = 400, turns = 64;
    const glm::dvec3 side = glm::normalize(glm::cross(towards, glm::dvec3(0, 0, 1)));
    const glm::dvec3 other = glm::cross(towards, side);
    for (int i = 0; i < rings; ++i) {
        for (int k = 0; k < turns; ++k) {
            const double c = 1 - (i + 0.5) / rings * (1 - std::cos(radius));
            const double phi = 2 * pi * (k + 0.5) / turns, s = std::sqrt(1 - c * c);
            const glm::dvec3 w = c * towards + s * (std::cos(phi) * side + std::sin(phi) * other);
            irradiance += 10 * w.y * 0.8 * std::pow(throughWall(w.y), 2);
        }
    }
    irradiance *= 2 * pi * (1 - std::cos(radius)) / (rings * turns);
    house.compare(irradiance, GetParam() == Strategy::bsdf ? 16384 : 256, GetParam(), 3);
    if (GetParam() == Strategy::mis) house.compareManyLights(irradiance, 64, 3);
}

TEST_P(PanesBy, LampInFrontOfAndBehindWalls)
{
    House house;
    house.addWall(0.5f, pane());
    house.builder.quad({-1, 1.5f, -1}, {2, 0, 0}, {0, 0, 2},
                       house.builder.material(emitter(glm::vec3(3))));
    double irradiance = 0;
    const int steps = 1000;
    for (int i = 0; i < steps; ++i) {
        for (int k = 0; k < steps; ++k) {
            const glm::dvec3 p(-1 + 2 * (i + 0.5) / steps, 1.5, -1 + 2 * (k + 0.5) / steps);
            const double cosine = p.y / glm::length(p);
            irradiance += 3 * cosine * cosine / glm::dot(p, p) * throughWall(cosine);
        }
    }
    house.compare(irradiance * 4 / (double(steps) * steps), 1500, GetParam(), 2);
}

/// Where it is not there the wall dims nothing.
TEST_P(PanesBy, HalfTransparentWall)
{
    House house;
    core::Material m = pane();
    m.data.flags |= shared::kMaterialAlphaBlend;
    m.data.alpha = 0.4f;
    house.addWall(0.5f, m);
    const double radius = 0.2;
    house.builder.scene.sun = core::Sun{{0, 1, 0}, static_cast<float>(radius), glm::vec3(10)};
    double irradiance = 0;
    const int steps = 10'000;
    for (int i = 0; i < steps; ++i) {
        const double c = 1 - (i + 0.5) / steps * (1 - std::cos(radius));
        irradiance += 10 * c * (0.4 * throughWall(c) + 0.6);
    }
    irradiance *= 2 * pi * (1 - std::cos(radius)) / steps;
    house.compare(irradiance, GetParam() == Strategy::bsdf ? 16384 : 256, GetParam(), 2);
}

INSTANTIATE_TEST_SUITE_P(AllStrategies, PanesBy,
                         testing::Values(Strategy::mis, Strategy::bsdf, Strategy::light),
                         [](const auto& one) { return std::string(core::enumName(one.param)); });

/// A thick wall, and a rough one, block connections as before: only smooth thin ones are panes.
TEST(Panes, AreThinAndSmooth)
{
    const auto features = [](const core::Material& m) {
        House house;
        house.addWall(0.5f, m);
        return house.builder.world()->features;
    };
    EXPECT_NE(features(pane()) & shared::kFeaturePanes, 0u);
    core::Material solid = pane(), rough = pane();
    solid.data.flags |= shared::kMaterialVolume;
    rough.data.roughness = 0.5f;
    EXPECT_EQ(features(solid) & shared::kFeaturePanes, 0u);
    EXPECT_EQ(features(rough) & shared::kFeaturePanes, 0u);
    EXPECT_EQ(features(lambert(glm::vec3(0.5f))) & shared::kFeaturePanes, 0u);
}

}  // namespace
