// Emitters: triangle sampling against spherical-triangle sampling (T14) and closed forms, densities
// against samples, punctual lights against KHR_lights_punctual, the sun's disk, and the map of the
// environment.
#include "shared/emitter.h"
#include "shared/sampler.h"
#include "tests/support/statistics/stats.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

namespace tests {
namespace {

using shared::Emitter;
using shared::EmitterSample;
using shared::uint;
using shared::uvec2;
using shared::vec2;
using shared::vec3;
using std::numbers::pi;
using dvec3 = glm::dvec3;

vec2 pointOfEmitter(uint i, uint dimension = 0)
{
    return shared::streamVec2(
        shared::makeStream(shared::kSamplerIndependent, 2, uvec2(5, 6), i, shared::kPurposePath),
        dimension);
}

Emitter triangle(vec3 a, vec3 b, vec3 c, uint flags = 0)
{
    return Emitter{a, shared::kEmitterTriangle | flags, b, 7, c, 0, vec3(2, 3, 4), 0};
}

/// Solid angle of a triangle: Van Oosterom & Strackee 1983.
double solidAngle(dvec3 a, dvec3 b, dvec3 c)
{
    double la = length(a);
    double lb = length(b);
    double lc = length(c);
    double denominator = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
    return 2 * std::atan2(std::abs(dot(a, cross(b, c))), denominator);
}

/// Uniform in the solid angle of a triangle, in double: Arvo, "Stratified Sampling of Spherical
/// Triangles", 1995.
dvec3 sampleSpherical(dvec3 a, dvec3 b, dvec3 c, vec2 u)
{
    a = normalize(a);
    b = normalize(b);
    c = normalize(c);
    dvec3 ab = normalize(cross(a, b));
    dvec3 ac = normalize(cross(a, c));
    double angle = std::acos(std::clamp(dot(ab, ac), -1.0, 1.0));
    double cosine = std::cos(angle);
    double sine = std::sin(angle);
    double area = static_cast<double>(u.x) * solidAngle(a, b, c);
    double s = std::sin(area - angle);
    double t = std::cos(area - angle);
    double p = t - cosine;
    double q = s + sine * dot(a, b);
    double side = std::clamp(((q * t - p * s) * cosine - q) / ((q * s + p * t) * sine), -1.0, 1.0);
    dvec3 corner = side * a + std::sqrt(1 - side * side) * normalize(c - dot(c, a) * a);
    double z = 1 - static_cast<double>(u.y) * (1 - dot(corner, b));
    return z * b + std::sqrt(1 - z * z) * normalize(corner - dot(corner, b) * b);
}

/// The lamp of the Cornell box (one of its triangles, facing down) and points around it.
const vec3 kLamp[] = {vec3(213, 548.6f, 227), vec3(343, 548.6f, 227), vec3(343, 548.6f, 332)};

struct Receiver {
    vec3 position;
    vec3 normal;
};

const std::vector<Receiver> kReceivers = {
    {vec3(278, 0, 280), vec3(0, 1, 0)},   {vec3(100, 0, 100), vec3(0, 1, 0)},
    {vec3(278, 330, 280), vec3(0, 1, 0)}, {vec3(10, 300, 280), vec3(1, 0, 0)},
    {vec3(150, 500, 250), vec3(1, 0, 0)},
};

// T14
TEST(Emitter, areaAndSolidAngleSamplingAgree)
{
    for (const Receiver& r : kReceivers) {
        Emitter e = triangle(kLamp[0], kLamp[1], kLamp[2]);
        dvec3 p(r.position);
        double omega = solidAngle(dvec3(e.a) - p, dvec3(e.b) - p, dvec3(e.c) - p);
        Moments area;
        Moments angle;
        for (uint i = 0; i < 1'000'000; ++i) {
            EmitterSample s;
            double value = 0;
            if (shared::sampleTriangleEmitter(e, r.position, pointOfEmitter(i), s)) {
                value = std::max(0.0, static_cast<double>(shared::dot(s.wi, r.normal))) /
                        static_cast<double>(s.pdf);
            }
            area.add(value);
            if (i % 4 != 0) continue;
            dvec3 w = sampleSpherical(dvec3(e.a) - p, dvec3(e.b) - p, dvec3(e.c) - p,
                                      pointOfEmitter(i, 9));
            angle.add(std::max(0.0, dot(w, dvec3(r.normal))) * omega);
        }
        Comparison c = welch(area, angle);
        EXPECT_LT(std::abs(c.z), kScore) << r.position.y;
        EXPECT_LT(c.detectable, 0.01);
    }
}

TEST(Emitter, triangleDensityIntegratesToOne)
{
    // Mean of 1/pdf over samples is the solid angle; in fp32, near, far, large and tiny.
    for (float scale : {1e-3f, 1.0f, 1e3f}) {
        for (float distance : {0.05f, 1.0f, 50.0f}) {
            vec3 shift(0.2f, -0.1f, distance);
            vec3 p(0.3f, 0.4f, 0.1f);
            Emitter e = triangle(p + scale * (vec3(-1, -1, 0) + shift),
                                 p + scale * (vec3(0, 1, 0.3f) + shift),
                                 p + scale * (vec3(1, -0.5f, 0) + shift), shared::kEmitterTwoSided);
            Moments m;
            for (uint i = 0; i < 100'000; ++i) {
                EmitterSample s;
                ASSERT_TRUE(shared::sampleTriangleEmitter(e, p, pointOfEmitter(i), s));
                m.add(1 / static_cast<double>(s.pdf));
            }
            dvec3 o(p);
            Comparison c =
                againstExact(m, solidAngle(dvec3(e.a) - o, dvec3(e.b) - o, dvec3(e.c) - o));
            EXPECT_LT(std::abs(c.z), kScore) << scale << ' ' << distance;
            EXPECT_LT(c.detectable, 0.04);
        }
    }
}

TEST(Emitter, triangleSamplesAreWhatTheDensitySays)
{
    Emitter e = triangle(kLamp[0], kLamp[1], kLamp[2]);
    for (const Receiver& r : kReceivers) {
        for (uint i = 0; i < 1000; ++i) {
            EmitterSample s;
            ASSERT_TRUE(shared::sampleTriangleEmitter(e, r.position, pointOfEmitter(i), s));
            EXPECT_EQ(s.radiance, e.radiance);
            EXPECT_EQ(s.pdf,
                      shared::pdfTriangleEmitter(e.a, e.b, e.c, r.position, s.wi, s.distance));
            vec3 hit = e.a + s.barycentrics.x * (e.b - e.a) + s.barycentrics.y * (e.c - e.a);
            EXPECT_NEAR(shared::length(r.position + s.wi * s.distance - hit), 0, 1e-3);
            // As a ray that found the triangle by itself would state it: rounded otherwise.
            double pdf = static_cast<double>(shared::pdfTriangleEmitter(
                e.b, e.c, e.a, r.position, s.wi, s.distance * 1.0000002f));
            EXPECT_NEAR(pdf / static_cast<double>(s.pdf), 1, 1e-5);
        }
    }
}

TEST(Emitter, trianglesShineFromTheirFrontUnlessTwoSided)
{
    // cross(b - a, c - a) is +z.
    Emitter e = triangle(vec3(0), vec3(1, 0, 0), vec3(0, 1, 0));
    Emitter both = triangle(vec3(0), vec3(1, 0, 0), vec3(0, 1, 0), shared::kEmitterTwoSided);
    EmitterSample s;
    EXPECT_TRUE(shared::sampleTriangleEmitter(e, vec3(0.2f, 0.2f, 1), vec2(0.5f), s));
    EXPECT_FALSE(shared::sampleTriangleEmitter(e, vec3(0.2f, 0.2f, -1), vec2(0.5f), s));
    EXPECT_TRUE(shared::sampleTriangleEmitter(both, vec3(0.2f, 0.2f, -1), vec2(0.5f), s));
    // In its plane
    EXPECT_FALSE(shared::sampleTriangleEmitter(both, vec3(3, 3, 0), vec2(0.5f), s));
    EXPECT_EQ(s.pdf, 0.0f);
}

// N11
TEST(Emitter, degenerateTrianglesAreNeverSampled)
{
    EmitterSample s;
    vec3 a(0.3f, 0.1f, 2);
    for (const Emitter& e :
         {triangle(a, a, a), triangle(a, a + vec3(1, 0, 0), a + vec3(2, 0, 0)),
          triangle(a, a, a + vec3(0, 1, 0)), triangle(a, a + vec3(1e-30f, 0, 0), a)}) {
        for (uint i = 0; i < 100; ++i) {
            EXPECT_FALSE(shared::sampleTriangleEmitter(e, vec3(0), pointOfEmitter(i), s));
            EXPECT_EQ(s.pdf, 0.0f);
            EXPECT_EQ(shared::pdfTriangleEmitter(e.a, e.b, e.c, vec3(0), vec3(0, 0, 1), 2), 0.0f);
        }
    }
    // A light on the point itself, and an area of 1e-8.
    EXPECT_FALSE(shared::sampleTriangleEmitter(triangle(a, a, a), a, vec2(0.2f), s));
    Emitter tiny = triangle(a, a + vec3(0, 1e-4f, 0), a + vec3(1e-4f, 0, 0));
    ASSERT_TRUE(shared::sampleTriangleEmitter(tiny, vec3(0), vec2(0.2f), s));
    double omega = solidAngle(dvec3(tiny.a), dvec3(tiny.b), dvec3(tiny.c));
    EXPECT_NEAR(1 / static_cast<double>(s.pdf) / omega, 1, 2e-3);
}

TEST(Emitter, punctualLightsFollowTheirSpecification)
{
    vec3 p(1, 2, 3);
    EmitterSample s;
    Emitter point{vec3(1, 2, 7), shared::kEmitterPoint, vec3(0), 0, vec3(0), 0, vec3(32, 16, 8), 0};
    ASSERT_TRUE(shared::samplePunctual(point, p, s));
    EXPECT_EQ(s.pdf, 0.0f);
    EXPECT_NEAR(s.distance, 4, 1e-6);
    EXPECT_NEAR(shared::length(s.wi - vec3(0, 0, 1)), 0, 1e-6);
    EXPECT_NEAR(s.radiance.x, 2, 1e-6);  // 32 / 4^2
    EXPECT_FALSE(shared::samplePunctual(point, point.a, s));

    Emitter sky{vec3(0), shared::kEmitterDirectional, vec3(0, 1, 0), 0, vec3(0), 0, vec3(5), 0};
    ASSERT_TRUE(shared::samplePunctual(sky, p, s));
    EXPECT_EQ(s.wi, vec3(0, 1, 0));
    EXPECT_EQ(s.distance, shared::kDistant);
    EXPECT_EQ(s.radiance, vec3(5));

    double inner = 0.3;
    double outer = 0.6;
    double scale = 1 / std::max(0.001, std::cos(inner) - std::cos(outer));
    Emitter spot = point;
    spot.kind = shared::kEmitterSpot;
    spot.a = vec3(0, 0, 2);
    spot.b = vec3(0, 0, -1);
    spot.scale = static_cast<float>(scale);
    spot.offset = static_cast<float>(-std::cos(outer) * scale);
    for (double angle = 0; angle < 1.2; angle += 0.05) {
        dvec3 target(2 * std::tan(angle), 0, 0);
        bool lit = shared::samplePunctual(spot, vec3(target), s);
        double ramp = std::clamp((std::cos(angle) - std::cos(outer)) * scale, 0.0, 1.0);
        double d2 = dot(target - dvec3(0, 0, 2), target - dvec3(0, 0, 2));
        EXPECT_EQ(lit, ramp > 0) << angle;
        EXPECT_NEAR(s.radiance.x, 32 * ramp * ramp / d2, 2e-4) << angle;
    }
}

TEST(Emitter, sunDiskIsUniformAndItsDensityKnowsItsEdge)
{
    for (double radius : {0.2, 0.00465, 1e-4}) {
        Emitter sun{vec3(0),
                    shared::kEmitterSun,
                    shared::normalize(vec3(0.3f, 0.8f, -0.5f)),
                    0,
                    vec3(0),
                    static_cast<float>(2 * std::pow(std::sin(radius / 2), 2)),
                    vec3(1e5f),
                    0};
        double omega = 4 * pi * std::pow(std::sin(radius / 2), 2);
        constexpr uint kCount = 100'000;
        std::vector<double> rings(64);
        uint outside = 0;
        for (uint i = 0; i < kCount; ++i) {
            EmitterSample s;
            ASSERT_TRUE(shared::sampleSun(sun, pointOfEmitter(i), s));
            EXPECT_NEAR(static_cast<double>(s.pdf) * omega, 1, 1e-6);
            outside += shared::pdfSun(sun, s.wi) == 0 ? 1u : 0u;
            dvec3 chord = dvec3(s.wi) - dvec3(sun.b);
            double q = dot(chord, chord) / 2 / static_cast<double>(sun.scale);
            rings[std::min<std::size_t>(63, static_cast<std::size_t>(q * 64))] += 1;
        }
        EXPECT_GT(chiSquareTest(rings, std::vector<double>(64, kCount / 64.0)).p, kLevel) << radius;
        // Rounding of directions blurs the edge: by 1e-7 of a radius of 1e-4, that is 0.2 % of the
        // area.
        EXPECT_LE(outside, kCount * (1e-5 + 4e-7 / radius));
        vec3 across = shared::makeFrame(sun.b)[0];
        auto at = [&](double angle) {
            return vec3(std::cos(angle) * dvec3(sun.b) + std::sin(angle) * dvec3(across));
        };
        EXPECT_GT(shared::pdfSun(sun, at(radius * 0.99)), 0.0f);
        EXPECT_EQ(shared::pdfSun(sun, at(radius * 1.01)), 0.0f);
        EXPECT_EQ(shared::pdfSun(sun, -sun.b), 0.0f);
    }
    EmitterSample s;
    EXPECT_FALSE(shared::sampleSun(Emitter{}, vec2(0.5f), s));
}

TEST(Emitter, environmentMapGoesRound)
{
    // Convention of the scenes: u = 0 looks to -Z, 0.25 to +X; row 0 is +Y.
    auto expectUv = [](vec3 d, double u, double v) {
        vec2 uv = shared::environmentUv(d);
        EXPECT_NEAR(uv.x, u, 1e-6);
        EXPECT_NEAR(uv.y, v, 1e-6);
    };
    expectUv(vec3(0, 0, -1), 0, 0.5);
    expectUv(vec3(1, 0, 0), 0.25, 0.5);
    expectUv(vec3(0, 0, 1), 0.5, 0.5);
    expectUv(vec3(-1, 0, 0), 0.75, 0.5);
    EXPECT_NEAR(shared::environmentUv(vec3(0, 1, 0)).y, 0, 1e-6);
    EXPECT_NEAR(shared::environmentUv(vec3(0, -1, 0)).y, 1, 1e-6);
    for (uint i = 0; i < 100'000; ++i) {
        vec3 d = shared::sampleSphere(pointOfEmitter(i));
        if (i % 3 == 0) d = shared::normalize(vec3(d.x * 1e-4f, d.y, d.z * 1e-4f));  // poles
        if (i % 3 == 1)
            d = shared::normalize(vec3(d.x * 1e-6f, d.y, -std::abs(d.z) - 0.1f));  // seam
        vec2 uv = shared::environmentUv(d);
        EXPECT_TRUE(uv.x >= 0 && uv.x < 1 && uv.y >= 0 && uv.y < 1);
        EXPECT_NEAR(shared::length(shared::environmentDirection(uv) - d), 0, 2e-6);
    }
    for (uint i = 0; i < 10'000; ++i) {
        vec2 uv = pointOfEmitter(i);
        uv.y = 1e-3f + 0.998f * uv.y;
        vec2 back = shared::environmentUv(shared::environmentDirection(uv));
        EXPECT_NEAR(uv.y, back.y, 1e-6);
        EXPECT_NEAR((uv.x - back.x) * std::sin(static_cast<float>(pi) * uv.y), 0, 1e-6);
    }
}

}  // namespace
}  // namespace tests
