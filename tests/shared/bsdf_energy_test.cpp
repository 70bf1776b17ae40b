// How much light surfaces send back: never more than comes (T7), exactly so much in furnaces (T8),
// whatever their index of refraction (N10).
#include "tests/support/methods/bsdf_cases.h"

#include <gtest/gtest.h>

namespace tests {
namespace {

/// `power`: the excess that must be visible, beside the allowed one of 1e-3.
void expectEnergyAtMostOne(const BsdfInputs& m, uint count, double power)
{
    Bsdf b = shared::makeBsdf(m);
    for (double angle : kAngles) {
        Moments a = sampledAlbedo(b, directionAt(angle), count);
        EXPECT_LE(a.mean(), 1 + 1e-3 + kScore * std::sqrt(a.varianceOfMean()))
            << describe(m) << " at " << angle;
        EXPECT_LT(kScore * std::sqrt(a.varianceOfMean()), power)
            << "underpowered: " << describe(m) << " at " << angle;
        EXPECT_GT(a.mean(), 0.2) << describe(m) << " at " << angle;
    }
}

TEST(BsdfEnergy, reflectsNoMoreThanItReceives)
{
    for (const BsdfInputs& m : everyMaterial()) expectEnergyAtMostOne(m, 1024, 0.03);
}

TEST(BsdfEnergy, SlowReflectsNoMoreThanItReceives)
{
    for (const BsdfInputs& m : everyMaterial()) expectEnergyAtMostOne(m, 16384, 0.008);
}

// N10, with the indices that glTF leaves open.
TEST(BsdfEnergy, strangeIndicesStayEnergyConserving)
{
    for (float ior : {0.0f, 1.0f, 1.0001f, 1 / 1.5f, 1.02f, 3.4f, 3.6f, 5.0f, 100.0f}) {
        for (float roughness : {0.0f, 0.2f, 0.5f, 1.0f}) {
            for (float transmission : {0.0f, 0.5f, 1.0f}) {
                for (Wall wall : {Wall::thin, Wall::outside, Wall::inside}) {
                    BsdfInputs m = glass(roughness * roughness, wall, ior);
                    m.transmission = transmission;
                    Bsdf b = shared::makeBsdf(m);
                    for (double angle : {0.0, 60.0, 85.0}) {
                        Moments a = sampledAlbedo(b, directionAt(angle), 512);
                        EXPECT_LE(a.mean(), 1 + 1e-3 + kScore * std::sqrt(a.varianceOfMean()))
                            << describe(m) << " at " << angle;
                        EXPECT_GT(a.mean(), 0.05) << describe(m) << " at " << angle;
                    }
                }
            }
        }
    }
    // Index one reflects nothing and lets everything straight through.
    Bsdf air = shared::makeBsdf(glass(0.25f, Wall::outside, 1.0f));
    vec3 wo = directionAt(60);
    for (uint i = 0; i < 1000; ++i) {
        BsdfSample s;
        ASSERT_TRUE(drawBsdf(air, wo, i, s));
        EXPECT_NEAR(shared::length(s.wi + wo), 0, 1e-6);
        EXPECT_NEAR(s.weight.x, 1, 1e-6);
    }
}

// --- T8

TEST(BsdfEnergy, specularZeroIsExactlyLambert)
{
    vec3 color(0.8f, 0.5f, 0.1f);
    Bsdf b = shared::makeBsdf(matte(color));
    EXPECT_TRUE(shared::isLambert(b));
    EXPECT_FALSE(shared::isDelta(b));
    for (double angle : kAngles) {
        vec3 wo = directionAt(angle);
        for (uint i = 0; i < 2000; ++i) {
            BsdfSample s;
            ASSERT_TRUE(drawBsdf(b, wo, i, s));
            EXPECT_EQ(s.weight, color);
            EXPECT_EQ(s.flags, 0u);
            vec3 f = shared::evalBsdf(b, wo, s.wi);
            EXPECT_NEAR(f.x, 0.8 / kPi, 1e-7);
            EXPECT_NEAR(s.pdf, static_cast<double>(s.wi.z) / kPi, 1e-7);
        }
    }
    EXPECT_EQ(shared::albedoBsdf(b, directionAt(40)), color);
}

void expectAlbedoTable(int alphas, int angles, uint count)
{
    for (int i = 0; i < alphas; ++i) {
        double alpha = std::pow((i + 1.0) / alphas, 2);
        for (int j = 0; j < angles; ++j) {
            double cosine = (j + 0.5) / angles;
            double wanted = albedoTable(cosine, alpha);
            vec3 wo = directionAt(std::acos(cosine) * 180 / kPi);
            Moments a =
                sampledAlbedo(shared::makeBsdf(metal(static_cast<float>(alpha))), wo, count);
            EXPECT_NEAR(a.mean() / wanted, 1, 5e-3) << alpha << ' ' << cosine;
            EXPECT_LT(std::sqrt(a.varianceOfMean()) * kScore, 5e-3 * wanted) << "underpowered";
        }
    }
}

TEST(BsdfEnergy, whiteMetalHasTheSingleScatteringAlbedo)
{
    expectAlbedoTable(4, 4, 4096);
}

TEST(BsdfEnergy, SlowWhiteMetalHasTheSingleScatteringAlbedo)
{
    expectAlbedoTable(8, 8, 16384);
}

TEST(BsdfEnergy, whitePlasticIsNearlyWhite)
{
    for (float ior : {1.1f, 1.33f, 1.5f, 1.8f}) {
        for (float roughness : {0.0f, 0.2f, 0.4f, 0.6f, 0.8f, 1.0f}) {
            BsdfInputs m = plastic(roughness);
            m.ior = ior;
            for (double angle : {0.0, 45.0, 75.0, 85.0}) {
                Moments a = sampledAlbedo(shared::makeBsdf(m), directionAt(angle), 2048);
                double error = kScore * std::sqrt(a.varianceOfMean());
                EXPECT_GT(a.mean() + error, roughness == 0 ? 0.996 : 0.945)
                    << ior << ' ' << roughness << ' ' << angle;
                EXPECT_LT(a.mean() - error, 1.001) << ior << ' ' << roughness << ' ' << angle;
            }
        }
    }
}

TEST(BsdfEnergy, whiteSmoothGlassAndMirrorLoseNothing)
{
    for (Wall wall : {Wall::thin, Wall::outside, Wall::inside}) {
        for (double angle : kAngles) {
            Moments a = sampledAlbedo(shared::makeBsdf(glass(0, wall)), directionAt(angle), 256);
            EXPECT_NEAR(a.mean(), 1, 1e-5) << angle;
            EXPECT_NEAR(sampledAlbedo(shared::makeBsdf(metal(0)), directionAt(angle), 64).mean(), 1,
                        1e-5);
        }
    }
}

TEST(BsdfEnergy, albedoEstimateIsNearTheAlbedo)
{
    for (const BsdfInputs& m : everyMaterial()) {
        if (m.ior != 1.5f || m.metallic > 0 || m.transmission > 0)
            continue;  // there single scattering loses much
        Bsdf b = shared::makeBsdf(m);
        vec3 wo = directionAt(45);
        EXPECT_NEAR(static_cast<double>(shared::maxComponent(shared::albedoBsdf(b, wo))),
                    sampledAlbedo(b, wo, 1024).mean(), 0.08)
            << describe(m);
    }
}

}  // namespace
}  // namespace tests
