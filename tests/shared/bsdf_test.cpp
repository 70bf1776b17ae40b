// The surface model's values: reciprocity (T6), agreement of samples with evaluation (T4), textbook
// formulas, the switch to delta lobes (N9) and arbitrary input.
#include "tests/support/methods/bsdf_cases.h"

#include <gtest/gtest.h>
#include <limits>
#include <vector>

namespace tests {
namespace {

// --- N9

TEST(Bsdf, noStepAtTheSwitchToDeltaLobes)
{
    auto with = [](BsdfInputs m, float alpha) {
        m.roughness = std::sqrt(alpha);
        return shared::makeBsdf(m);
    };
    for (const BsdfInputs& m : {plastic(), metal(1), glass(1, Wall::thin), glass(1, Wall::outside),
                                glass(1, Wall::inside)}) {
        for (double angle : {0.0, 30.0, 60.0, 80.0, 88.0}) {
            vec3 wo = directionAt(angle);
            double smooth = sampledAlbedo(with(m, 0), wo, 1024).mean();
            for (float alpha : {1e-6f, 1e-4f, 9e-4f, 1.1e-3f, 1e-2f}) {
                Bsdf b = with(m, alpha);
                EXPECT_EQ(b.alpha == 0, alpha < shared::kDeltaAlpha);
                Moments a = sampledAlbedo(b, wo, 1024);
                double allowed = alpha > 5e-3f ? (angle > 85 ? 0.1 : 0.02) : 0.01;
                EXPECT_NEAR(a.mean(), smooth, allowed + kScore * std::sqrt(a.varianceOfMean()))
                    << describe(m) << " alpha " << alpha << " at " << angle;
            }
        }
    }
}

TEST(Bsdf, deltaLobesHaveNoDensity)
{
    vec3 wo = directionAt(50);
    for (const BsdfInputs& m :
         {metal(0), glass(0, Wall::thin), glass(0, Wall::outside), glass(0, Wall::inside)}) {
        Bsdf b = shared::makeBsdf(m);
        EXPECT_TRUE(shared::isDelta(b));
        for (uint i = 0; i < 200; ++i) {
            BsdfSample s;
            ASSERT_TRUE(drawBsdf(b, wo, i, s));
            EXPECT_EQ(s.pdf, 0.0f);
            EXPECT_TRUE((s.flags & shared::kLobeDelta) != 0 &&
                        (s.flags & shared::kLobeSpecular) != 0);
            EXPECT_EQ((s.flags & shared::kLobeTransmission) != 0, s.wi.z < 0);
            EXPECT_EQ(shared::pdfBsdf(b, wo, s.wi), 0.0f);
            EXPECT_EQ(shared::evalBsdf(b, wo, s.wi), vec3(0));
        }
    }
    // A smooth coat or varnish over diffuse: mixed, so light sampling is worth it.
    EXPECT_FALSE(shared::isDelta(shared::makeBsdf(plastic(0))));
}

TEST(Bsdf, smoothGlassReflectsByFresnelAndRefractsBySnell)
{
    for (Wall wall : {Wall::outside, Wall::inside}) {
        Bsdf b = shared::makeBsdf(glass(0, wall));
        double eta = wall == Wall::outside ? 1.5 : 1 / 1.5;
        for (double angle : {0.0, 20.0, 41.0, 43.0, 70.0, 89.0}) {
            vec3 wo = directionAt(angle);
            double reflected = 0;
            constexpr uint kCount = 20000;
            for (uint i = 0; i < kCount; ++i) {
                BsdfSample s;
                ASSERT_TRUE(drawBsdf(b, wo, i, s));
                if (s.wi.z > 0) {
                    reflected += 1;
                    EXPECT_NEAR(shared::length(s.wi - vec3(-wo.x, -wo.y, wo.z)), 0, 1e-6);
                    EXPECT_NEAR(s.weight.x, 1, 1e-5);
                } else {
                    EXPECT_NEAR(static_cast<double>(s.wi.x) * eta, -static_cast<double>(wo.x),
                                1e-6);
                    EXPECT_NEAR(static_cast<double>(s.wi.y) * eta, -static_cast<double>(wo.y),
                                1e-6);
                    EXPECT_NEAR(shared::length(s.wi), 1, 1e-6);
                    EXPECT_NEAR(static_cast<double>(s.weight.x) * eta * eta, 1, 1e-5);  // radiance
                }
            }
            double f = fresnel(static_cast<double>(wo.z), eta);
            EXPECT_NEAR(reflected / kCount, f, kScore * std::sqrt(f * (1 - f) / kCount) + 1e-6)
                << angle;
        }
    }
}

// --- values

TEST(Bsdf, fresnelIsExact)
{
    for (double eta : {1.0, 1.0001, 1.1, 1.5, 2.4, 100.0, 1 / 1.1, 1 / 1.5}) {
        for (int i = 1; i <= 200; ++i) {
            double c = i / 200.0;
            double wanted = fresnel(c, static_cast<double>(static_cast<float>(eta)));
            double got = static_cast<double>(
                shared::fresnelDielectric(static_cast<float>(c), static_cast<float>(eta)));
            bool critical = eta < 1 && std::abs(eta * eta - 1 + c * c) < 1e-3;
            EXPECT_NEAR(got, wanted, critical ? 0.02 : 2e-6 + 1e-4 * wanted) << eta << ' ' << c;
        }
    }
}

TEST(Bsdf, metalAndGlassMatchTheTextbook)
{
    for (double alpha : {0.05, 0.2, 0.5, 1.0}) {
        Bsdf mirror = shared::makeBsdf(metal(static_cast<float>(alpha)));
        for (Wall wall : {Wall::outside, Wall::inside, Wall::thin}) {
            Bsdf b = shared::makeBsdf(glass(static_cast<float>(alpha), wall));
            double eta = wall == Wall::inside ? 1 / 1.5 : 1.5;
            double a = static_cast<double>(b.alpha);
            for (uint i = 0; i < 3000; ++i) {
                vec3 wo = directionAt(2.0 + 0.028 * i, i);
                BsdfSample s;
                if (!drawBsdf(b, wo, i, s)) continue;
                dvec3 o(wo);
                dvec3 w(s.wi);
                bool up = w.z > 0;
                bool refracted = !up && wall != Wall::thin;
                dvec3 mirrored(w.x, w.y, std::abs(w.z));
                dvec3 h = refracted ? normalize(o + eta * w) : normalize(o + mirrored);
                if (h.z < 0) h = -h;
                double oh = dot(o, h);
                double ih = std::abs(dot(w, h));
                double f = fresnel(oh, eta);
                double g = 1 / (1 + lambda(o.z, a) + lambda(std::abs(w.z), a));
                double value = ggx(h, a) * g / (4 * o.z * std::abs(w.z));
                double pdf = visible(o, h, a) / (4 * oh);
                // Where nothing refracts, the cap of normals is bounded: G1's denominator shrinks.
                double root2 = std::sqrt(a * a + (1 - a * a) * o.z * o.z);
                auto bounded = [&](bool all) {
                    double depth =
                        static_cast<double>(shared::capDepth(wo.z, b.alpha * b.alpha, all));
                    return (o.z + root2) / (depth * o.z + root2);
                };
                pdf *= bounded(wall != Wall::thin);
                if (refracted) {
                    double root = oh - eta * ih;
                    value = ggx(h, a) * g * oh * ih / (o.z * std::abs(w.z) * root * root);
                    pdf = visible(o, h, a) * eta * eta * ih / (root * root);
                }
                vec3 got;
                float gotPdf;
                shared::evalPdfBsdf(b, wo, s.wi, got, gotPdf);
                double share = up ? f : 1 - f;
                double slack = 1e-3 + 2e-6 / (alpha * o.z);  // fp32 half vectors at grazing angles
                EXPECT_NEAR(static_cast<double>(got.x) / (share * value), 1, slack)
                    << alpha << ' ' << o.z;
                EXPECT_NEAR(static_cast<double>(gotPdf) / (share * pdf), 1, slack)
                    << alpha << ' ' << o.z;
                if (up) {
                    EXPECT_NEAR(static_cast<double>(shared::evalBsdf(mirror, wo, s.wi).x) / value,
                                1, slack);
                }
            }
        }
    }
}

// T4
TEST(Bsdf, samplesAgreeWithEvaluation)
{
    for (const BsdfInputs& m : everyMaterial()) {
        Bsdf b = shared::makeBsdf(m);
        for (double angle : kAngles) {
            vec3 wo = directionAt(angle);
            for (uint i = 0; i < 60; ++i) {
                BsdfSample s;
                if (!drawBsdf(b, wo, i, s)) continue;
                EXPECT_NEAR(shared::length(s.wi), 1, 2e-6);
                if ((s.flags & shared::kLobeDelta) != 0) continue;
                vec3 f;
                float pdf;
                shared::evalPdfBsdf(b, wo, s.wi, f, pdf);
                EXPECT_NEAR(s.pdf / pdf, 1, 1e-3);
                vec3 weight = f * (std::abs(s.wi.z) / pdf);
                EXPECT_LE(shared::length(s.weight - weight), 1e-3f * shared::length(weight));
                EXPECT_EQ(pdf, shared::pdfBsdf(b, wo, s.wi));
                EXPECT_EQ(f, shared::evalBsdf(b, wo, s.wi));
            }
        }
    }
}

// T6
TEST(Bsdf, isReciprocal)
{
    std::size_t compared = 0;
    for (BsdfInputs m : everyMaterial()) {
        if (m.roughness < 0.2f) continue;
        m.baseColor = vec3(0.9f, 0.4f, 0.2f);
        Bsdf b = shared::makeBsdf(m);
        BsdfInputs turned = m;
        turned.backFace = 1 - m.backFace;
        Bsdf other = shared::makeBsdf(turned);
        bool solid = (b.parts & shared::kBsdfSolid) != 0;
        for (uint i = 0; i < 400; ++i) {
            auto stream = shared::makeStream(shared::kSamplerIndependent, 4, uvec2(9, 9), i,
                                             shared::kPurposePath);
            vec3 wo = shared::sampleUniformHemisphere(shared::streamVec2(stream, 0));
            vec3 wi = shared::sampleSphere(shared::streamVec2(stream, 1));
            if (i % 2 == 1) {  // random pairs miss narrow lobes
                BsdfSample s;
                if (!drawBsdf(b, wo, i, s)) continue;
                wi = s.wi;
            }
            vec3 f = shared::evalBsdf(b, wo, wi);
            vec3 back;
            if (wi.z > 0) {
                back = shared::evalBsdf(b, wi, wo);
            } else {
                vec3 flip(1, 1, -1);
                // Seen from the other side; radiance scales with the squared index of the medium it
                // is in.
                back = shared::evalBsdf(solid ? other : b, wi * flip, wo * flip);
                if (solid) back = back / (b.eta * b.eta);
            }
            if (!(f.x > 1e-6f)) continue;
            ++compared;
            double slack = 1e-4 + 1e-5 / static_cast<double>(std::min(std::abs(wi.z), wo.z));
            if (wi.z < 0 && solid) {
                // Past this cosine on the outer side 1 - F vanishes, and inside it is a root of a
                // difference.
                dvec3 h = normalize(dvec3(wo) + static_cast<double>(b.eta) * dvec3(wi));
                double outer = dot(dvec3(m.backFace != 0 ? wi : wo), h);
                slack += 1e-6 / (outer * outer);
            }
            for (int k = 0; k < 3; ++k) {
                EXPECT_NEAR(back[k] / f[k], 1, slack) << describe(m) << ' ' << wo.z << ' ' << wi.z;
            }
        }
    }
    EXPECT_GT(compared, 50'000u);
}

TEST(Bsdf, opaqueSurfacesSendNothingBelow)
{
    for (const BsdfInputs& m : everyMaterial()) {
        if (m.transmission > 0) continue;
        Bsdf b = shared::makeBsdf(m);
        for (uint i = 0; i < 50; ++i) {
            vec3 wi = shared::sampleUniformHemisphere(shared::streamVec2(
                shared::makeStream(1, 0, uvec2(0, 0), i, shared::kPurposePath), 0));
            EXPECT_EQ(shared::evalBsdf(b, directionAt(40), vec3(wi.x, wi.y, -wi.z)), vec3(0));
            EXPECT_EQ(shared::pdfBsdf(b, directionAt(40), vec3(wi.x, wi.y, -wi.z)), 0.0f);
            EXPECT_EQ(shared::pdfBsdf(b, vec3(wi.x, wi.y, -wi.z), wi), 0.0f);
        }
    }
}

TEST(Bsdf, weightsAreBounded)
{
    // Bounded weights are what keeps fireflies away: single lobes never exceed one (times the eta
    // of entering).
    for (const BsdfInputs& m : everyMaterial()) {
        Bsdf b = shared::makeBsdf(m);
        for (double angle : kAngles) {
            for (uint i = 0; i < 100; ++i) {
                BsdfSample s;
                if (!drawBsdf(b, directionAt(angle), i, s)) continue;
                bool inside = (b.parts & shared::kBsdfInside) != 0;
                EXPECT_LT(shared::maxComponent(s.weight), inside ? 2.4f * 2.4f * 8 : 8.0f)
                    << describe(m) << angle;
            }
        }
    }
}

TEST(Bsdf, anyInputGivesFiniteResults)
{
    const float inf = std::numeric_limits<float>::infinity();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float odd[] = {0, 1, 1e-20f, 1e20f, -1, inf, nan, 0.5f, 1e-3f, 0.9999999f};
    uint counter = 0;
    auto word = [&] { return shared::hashUint(++counter); };
    auto value = [&] {
        uint w = word();
        return (w & 3u) == 0 ? odd[(w >> 8) % 10] : shared::unitFloat(word());
    };
    uint bad = 0;
    for (int i = 0; i < 200'000; ++i) {
        BsdfInputs m{vec3(value(), value(), value()),
                     value(),
                     value(),
                     3 * value(),
                     value(),
                     vec3(value(), value(), value()),
                     value(),
                     value(),
                     value(),
                     word() & shared::kMaterialVolume,
                     word() & 1u};
        Bsdf b = shared::makeBsdf(m);
        vec3 wo = shared::sampleSphere(vec2(shared::unitFloat(word()), shared::unitFloat(word())));
        if (i % 5 == 0)
            wo = directionAt(89.9 + 0.1 * static_cast<double>(shared::unitFloat(word())));
        BsdfSample s;
        if (shared::sampleBsdf(b, wo, shared::unitFloat(word()),
                               vec2(shared::unitFloat(word()), shared::unitFloat(word())), s)) {
            bool good = s.pdf >= 0 && s.pdf < inf && std::abs(shared::length(s.wi) - 1) < 1e-3f;
            for (int k = 0; k < 3; ++k) good = good && s.weight[k] >= 0 && s.weight[k] < inf;
            bad += good ? 0 : 1;
        }
        vec3 wi =
            i % 7 == 0
                ? -wo
                : shared::sampleSphere(vec2(shared::unitFloat(word()), shared::unitFloat(word())));
        vec3 f;
        float pdf;
        shared::evalPdfBsdf(b, wo, wi, f, pdf);
        bool good = pdf >= 0 && pdf < inf;
        for (int k = 0; k < 3; ++k) good = good && f[k] >= 0 && f[k] < inf;
        bad += good ? 0 : 1;
        if (bad == 1) ADD_FAILURE() << describe(m);
    }
    EXPECT_EQ(bad, 0u);
}

}  // namespace
}  // namespace tests
