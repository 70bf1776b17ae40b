// Surfaces without a density: both ways of light are those between which sampling chooses, and a
// camera in a mirror sees what the mirror shows.
#include <gtest/gtest.h>

#include "shared/delta.h"
#include "shared/reuse_history.h"
#include "tests/support/methods/bsdf_cases.h"

namespace {

using namespace tests;

struct Sums {
    vec3 reflected{0}, through{0};
};

/// What all choices of the lobe bring together.
Sums sampled(const Bsdf& b, vec3 wo, const shared::DeltaWays& ways)
{
    constexpr int kStrata = 20000;
    Sums sums;
    for (int i = 0; i < kStrata; ++i) {
        BsdfSample s;
        const float u = (float(i) + 0.5f) / float(kStrata);
        if (!shared::sampleBsdf(b, wo, u, vec2(0.3f, 0.6f), s)) continue;
        const bool up = (s.flags & shared::kLobeTransmission) == 0u;
        (up ? sums.reflected : sums.through) += s.weight / float(kStrata);
        const vec3 expected = up ? ways.wiReflected : ways.wiThrough;
        EXPECT_NEAR(glm::length(s.wi - expected), 0, 1e-5) << u;
    }
    return sums;
}

TEST(Delta, BothWaysAreThoseThatSamplingChooses)
{
    BsdfInputs mirror = metal(0), coated = metal(0), tinted = glass(0, Wall::outside);
    mirror.baseColor = vec3(0.9f, 0.6f, 0.3f);
    coated.clearcoat = 0.7f;
    tinted.baseColor = vec3(0.2f, 0.8f, 0.5f);
    BsdfInputs lacquer = glass(0, Wall::inside);
    lacquer.clearcoat = 1;
    for (const BsdfInputs& inputs : {mirror, coated, tinted, lacquer, glass(0, Wall::thin),
                                     glass(0, Wall::inside), glass(0, Wall::outside, 1.0f)}) {
        const Bsdf b = shared::makeBsdf(inputs);
        ASSERT_TRUE(shared::isDelta(b));
        for (const double degrees : {0.0, 20.0, 40.0, 60.0, 85.0, 89.0}) {
            const vec3 wo = directionAt(degrees);
            const shared::DeltaWays ways = shared::deltaWays(b, wo);
            const Sums sums = sampled(b, wo, ways);
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(sums.reflected[c], ways.reflected[c], 2e-3) << degrees;
                EXPECT_NEAR(sums.through[c], ways.through[c], 2e-3) << degrees;
            }
        }
    }
}

TEST(Delta, NothingGoesThroughPastTheCriticalAngle)
{
    const Bsdf b = shared::makeBsdf(glass(0, Wall::inside));
    const shared::DeltaWays ways = shared::deltaWays(b, directionAt(45));
    EXPECT_EQ(ways.through, vec3(0));
    EXPECT_NEAR(ways.reflected.x, 1, 1e-6);
}

TEST(Delta, AMirroredCameraSeesWhatTheMirrorShows)
{
    shared::CameraData camera{};
    camera.position = {1, 2, 3};
    camera.tanHalfHeight = 0.4f;
    camera.aspect = 1.5f;
    camera.right = {1, 0, 0};
    camera.up = {0, 1, 0};
    camera.forward = {0, 0, -1};
    const vec3 onMirror(0.5f, 0.5f, -4), n = glm::normalize(vec3(0.3f, 0.2f, 1));
    const shared::CameraData image = shared::mirroredCamera(camera, onMirror, n);
    for (const vec3 x : {vec3(0, 1, 5), vec3(2, -1, 1), vec3(-3, 0, 4)}) {
        const vec3 shown = onMirror + shared::mirrored(x - onMirror, n);
        vec2 film, expected;
        shared::projectToFilm(image, vec2(300, 200), x, film);
        shared::projectToFilm(camera, vec2(300, 200), shown, expected);
        EXPECT_NEAR(film.x, expected.x, 1e-2);
        EXPECT_NEAR(film.y, expected.y, 1e-2);
        EXPECT_NEAR(glm::length(image.position - x), glm::length(camera.position - shown), 1e-5);
    }
}

}  // namespace
