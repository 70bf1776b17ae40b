// M19. Virtual lights with extent: closed forms, the point as their limit, quadrature for glossy
// surfaces at both ends, the distribution of what is drawn, and their radii.
#include "shared/extended_light.h"

#include <gtest/gtest.h>

#include <random>

#include "core/many_lights/light_radii.h"
#include "tests/support/methods/bsdf_cases.h"

namespace {

using namespace tests;
using shared::kLightShapeDisc, shared::kLightShapeSphere;
using shared::LightReceiver, shared::LightRecord;

constexpr shared::GatherRules kRules{8, 0};

/// At the origin, facing up, seen along `wo`.
LightReceiver receiver(const BsdfInputs& material, vec3 wo, uint seed)
{
    LightReceiver r{};
    r.frame = shared::mat3(1);
    r.side = vec3(0, 0, 1);
    r.wo = glm::normalize(wo);
    r.bsdf = shared::makeBsdf(material);
    r.lobes = shared::lobesAt(r.bsdf, r.wo);
    r.seed = seed;
    return r;
}

/// White, of power 1, facing down.
LightRecord lightAt(vec3 position, float radius)
{
    LightRecord light{};
    light.position = position;
    light.kind = shared::kVirtualSurface;
    light.normal = vec3(0, 0, -1);
    light.radius = radius;
    light.intensity = vec3(shared::kInvPi);
    light.detail = shared::kNone;
    return light;
}

/// The mean over seeds, of at least so many pairs of samples.
double meanOverSeeds(const BsdfInputs& material, vec3 wo, const LightRecord& light,
                     const std::vector<glm::vec4>& details, uint shape, double samples)
{
    const float distance = glm::length(light.position);
    const double each = std::max(
        1.0, std::floor(100 * std::sqrt(double(shared::lightCone(shape, light.radius, distance)))));
    const auto seeds = static_cast<uint>(std::ceil(samples / each));
    double sum = 0;
    for (uint seed = 0; seed < seeds; ++seed)
        sum += double(shared::extendedContribution(receiver(material, wo, shared::hashUint(seed)),
                                                   {details.data()}, light, kRules, shape)
                          .x);
    return sum / seeds;
}

/// Both ends Lambertian and face to face: L = 2 / (3 pi^2 r^2) (1 - cos^3 of half the angle).
TEST(ExtendedLight, LambertianEndsFaceToFaceAreTheClosedForm)
{
    constexpr double r = 0.1;
    for (const auto& [d, expected] : {std::pair{10.0, .00101309}, std::pair{1.0, .100069},
                                      std::pair{0.1, 4.3666}, std::pair{0.01, 6.748}}) {
        const double cosine = d / std::sqrt(d * d + r * r);
        const double exact = 2 / (3 * kPi * kPi * r * r) * (1 - cosine * cosine * cosine);
        EXPECT_NEAR(exact, expected, 1e-4 * expected);
        const LightRecord light = lightAt(vec3(0, 0, d), float(r));
        EXPECT_NEAR(meanOverSeeds(matte(), vec3(0.3, 0, 1), light, {}, kLightShapeDisc, 1e6), exact,
                    1e-3 * exact)
            << "disc, distance " << d;
        // Of a sphere that the receiver is in, all directions above both horizons.
        const double sine = std::min(1.0, r / d), across = std::sqrt(1 - sine * sine);
        const double ofSphere = 2 / (3 * kPi * kPi * r * r) * (1 - across * across * across);
        EXPECT_NEAR(meanOverSeeds(matte(), vec3(0.3, 0, 1), light, {}, kLightShapeSphere, 1e6),
                    ofSphere, 1e-3 * ofSphere)
            << "sphere, distance " << d;
    }
}

TEST(ExtendedLight, WithoutRadiusItIsThePointToTheBit)
{
    std::mt19937 random(1);
    std::uniform_real_distribution<float> u(-1, 1);
    for (uint i = 0; i < 1000; ++i) {
        const LightReceiver r = receiver(plastic(0.4f), vec3(u(random), u(random), 1), i);
        const LightRecord light = lightAt(vec3(u(random), u(random), 1.5f + u(random)), 0);
        for (const uint shape : {kLightShapeSphere, kLightShapeDisc})
            ASSERT_EQ(shared::extendedContribution(r, {nullptr}, light, kRules, shape),
                      shared::lightContribution(r, {nullptr}, light, kRules));
    }
}

/// And it is the limit of small radii, for glossy surfaces, too.
TEST(ExtendedLight, SmallRadiiComeNearThePoint)
{
    for (const BsdfInputs& material : {matte(), plastic(0.5f)}) {
        LightRecord light = lightAt(vec3(0.4f, 0.2f, 1), 0);
        const double point =
            double(shared::lightContribution(receiver(material, vec3(-0.4, 0, 1), 0), {nullptr},
                                             light, kRules)
                       .x);
        for (const uint shape : {kLightShapeSphere, kLightShapeDisc}) {
            light.radius = 1e-3f;
            EXPECT_NEAR(meanOverSeeds(material, vec3(-0.4, 0, 1), light, {}, shape, 2e3), point,
                        1e-3 * point);
            light.radius = 0.5f;
            EXPECT_GT(
                std::abs(meanOverSeeds(material, vec3(-0.4, 0, 1), light, {}, shape, 2e4) - point),
                0.02 * point);
        }
    }
}

/// Nearer and nearer, through the disc's own plane: finite, and no more than its bound.
TEST(ExtendedLight, ReceiversInsideAreFinite)
{
    constexpr float r = 0.1f;
    const double bound = 2 / (3 * kPi * kPi * double(r) * double(r));
    for (const float d : {1e-2f, 1e-4f, 1e-7f, 1e-8f, 0.0f})
        for (const uint shape : {kLightShapeSphere, kLightShapeDisc}) {
            const double found =
                meanOverSeeds(matte(), vec3(0, 0, 1), lightAt(vec3(0, 0, d), r), {}, shape, 2e4);
            EXPECT_LT(found, 1.01 * bound) << d;
            if (d >= 1e-7f) {
                EXPECT_GT(found, 0.97 * bound) << d;
            }
        }
}

/// Glossy at both ends and aslant, against quadrature over the cone.
TEST(ExtendedLight, GlossyEndsAreTheirQuadrature)
{
    shared::LightSurface surface{};
    surface.frame = shared::makeFrame(vec3(0, 0, -1));
    surface.normal = vec3(0, 0, -1);
    surface.incident = glm::normalize(vec3(0.3, 0.2, 1));
    surface.bsdf = shared::makeBsdf(plastic(0.5f));
    surface.lobes = shared::lobesAt(surface.bsdf, surface.incident);
    std::vector<glm::vec4> details;
    for (uint word = 0; word < shared::kLightSurfaceWords; ++word)
        details.push_back(shared::lightSurfaceWord(surface, word));
    for (const uint shape : {kLightShapeSphere, kLightShapeDisc})
        for (const float radius : {0.2f, 0.7f, 2.0f}) {
            LightRecord light = lightAt(vec3(0.5f, 0.1f, 0.8f), radius);
            light.detail = 0;
            const vec3 wo(-0.5, -0.2, 0.7);
            const LightReceiver r = receiver(plastic(0.4f), wo, 0);
            const float cone = shared::lightCone(shape, radius, glm::length(light.position));
            const shared::mat3 around = shared::makeFrame(glm::normalize(light.position));
            constexpr uint kSide = 600;
            double sum = 0;
            for (uint i = 0; i < kSide * kSide; ++i) {
                const vec2 u((float(i % kSide) + 0.5f) / kSide, (float(i / kSide) + 0.5f) / kSide);
                float pdf;
                sum += double(
                    shared::lightFrom(r, {details.data()}, light,
                                      shared::toWorld(around, shared::sampleCone(u, cone)), pdf)
                        .x);
            }
            const double exact = sum / (double(kSide) * kSide) / double(shared::pdfCone(cone)) /
                                 (kPi * double(radius) * double(radius));
            EXPECT_NEAR(meanOverSeeds(plastic(0.4f), wo, light, details, shape, 3e5), exact,
                        3e-3 * exact)
                << "shape " << shape << ", radius " << radius;
        }
}

/// The numbers of different receivers and lights are uniform and independent in pairs.
TEST(ExtendedLight, WhatIsDrawnIsUniform)
{
    constexpr uint kCells = 16, kDraws = 200000;
    const std::vector<double> wanted(kCells * kCells, double(kDraws) / (kCells * kCells));
    for (const uint which : {0u, 7u, 141u}) {
        std::array<std::vector<double>, 10> observed;
        for (auto& o : observed) o.assign(kCells * kCells, 0);
        for (uint seed = 0; seed < kDraws; ++seed) {
            const shared::LightNumbers n = shared::drawLightNumbers(shared::hashUint(seed), which);
            const float u[] = {n.cone.x, n.cone.y, n.bsdf.x, n.bsdf.y, n.lobe};
            size_t pair = 0;
            for (size_t a = 0; a < 5; ++a)
                for (size_t b = a + 1; b < 5; ++b) {
                    ASSERT_TRUE(u[a] >= 0 && u[a] < 1);
                    observed[pair++][uint(u[a] * kCells) * kCells + uint(u[b] * kCells)] += 1;
                }
        }
        for (const auto& o : observed) EXPECT_GT(chiSquareTest(o, wanted).p, kLevel);
    }
}

/// Directions of a cone fill it, whatever its angle.
TEST(ExtendedLight, DirectionsFillTheCone)
{
    constexpr uint kCells = 16, kDraws = 100000;
    const std::vector<double> wanted(kCells * kCells, double(kDraws) / (kCells * kCells));
    for (const uint shape : {kLightShapeSphere, kLightShapeDisc})
        for (const float distance : {0.05f, 0.2f, 1.0f, 30.0f}) {
            const float cone = shared::lightCone(shape, 0.1f, distance);
            std::vector<double> observed(kCells * kCells);
            for (uint seed = 0; seed < kDraws; ++seed) {
                const vec3 w = shared::sampleCone(
                    shared::drawLightNumbers(shared::hashUint(seed), 0).cone, cone);
                // Height and angle, which are uniform.
                const double height = 0.5 *
                                      (double(w.x) * double(w.x) + double(w.y) * double(w.y) +
                                       (1 - double(w.z)) * (1 - double(w.z))) /
                                      double(cone);
                const double angle = std::atan2(double(w.y), double(w.x)) / (2 * kPi) + 0.5;
                const auto cell = [](double x) { return std::min(uint(x * kCells), kCells - 1); };
                observed[cell(height) * kCells + cell(angle)] += 1;
            }
            EXPECT_GT(chiSquareTest(observed, wanted).p, kLevel) << shape << ", " << distance;
        }
}

/// Half the angle is that of a disc or of a sphere.
TEST(ExtendedLight, ConesAreThoseOfDiscsAndSpheres)
{
    for (const double ratio : {1e-3, 0.1, 0.5, 0.99}) {
        EXPECT_NEAR(double(shared::lightCone(kLightShapeDisc, float(ratio), 1)) /
                        (1 - std::cos(std::atan(ratio))),
                    1, 1e-4);
        EXPECT_NEAR(double(shared::lightCone(kLightShapeSphere, float(ratio), 1)) /
                        (1 - std::cos(std::asin(ratio))),
                    1, 1e-4);
    }
    EXPECT_EQ(shared::lightCone(kLightShapeDisc, 1, 0), 1.0f);
    EXPECT_EQ(shared::lightCone(kLightShapeSphere, 1, 0.5f), 2.0f);
}

TEST(LightRadii, AreTwiceTheDistanceToTheTenthNeighbour)
{
    std::mt19937 random(2);
    std::normal_distribution<float> u;
    std::vector<vec3> positions;
    for (int i = 0; i < 500; ++i) positions.emplace_back(u(random), u(random), u(random));
    for (int i = 0; i < 30; ++i) positions.push_back(positions[0]);  // one point
    std::vector<float> radii(positions.size());
    core::many_lights::lightRadii(positions, 7, radii);
    for (size_t i = 0; i < positions.size(); ++i) {
        std::vector<float> d;
        for (const vec3& p : positions)
            if (p != positions[i]) d.push_back(glm::length(p - positions[i]));
        std::ranges::nth_element(d, d.begin() + 9);
        ASSERT_NEAR(radii[i], 2 * d[9], 1e-5f * d[9]) << i;
    }
}

TEST(LightRadii, OfFewAndOfCoincidentLights)
{
    std::vector<float> radii(3);
    core::many_lights::lightRadii(std::vector{vec3(0), vec3(1, 0, 0), vec3(3, 0, 0)}, 7, radii);
    EXPECT_EQ(radii, (std::vector<float>{6, 4, 6}));
    core::many_lights::lightRadii(std::vector{vec3(2), vec3(2), vec3(2)}, 7, radii);
    EXPECT_EQ(radii, (std::vector<float>{7, 7, 7}));
    core::many_lights::lightRadii({}, 7, {});
}

}  // namespace
