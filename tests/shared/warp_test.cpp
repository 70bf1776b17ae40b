// T2: every map from the unit square against its stated density (chi-square on equal-area cells of
// its target), inverses, frames and packed directions.
#include "shared/sampler.h"
#include "shared/warp.h"
#include "tests/support/statistics/stats.h"

#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

namespace tests {
namespace {

using shared::uint;
using shared::uvec2;
using shared::vec2;
using shared::vec3;
using std::numbers::pi;

vec2 pointOfMap(uint i, uint dimension = 0)
{
    return shared::streamVec2(
        shared::makeStream(shared::kSamplerIndependent, 5, uvec2(1, 2), i, shared::kPurposePath),
        dimension);
}

std::size_t cell(double x, std::size_t n)
{
    return std::min(n - 1, static_cast<std::size_t>(std::max(x, 0.0) * static_cast<double>(n)));
}

/// Fraction of a turn of (x, y), in [0,1).
double turn(double x, double y)
{
    double t = std::atan2(y, x) / (2 * pi);
    return t < 0 ? t + 1 : t;
}

/// Chi-square of `count` samples on 16 x 32 cells: `cellOf` gives two coordinates in [0,1],
/// `expected` the probability of the cell [r0,r1] of the first coordinate (the second is always
/// uniform).
void expectDensity(uint count, const std::function<vec2(uint)>& cellOf,
                   const std::function<double(double, double)>& expected)
{
    std::vector<double> observed(512);
    std::vector<double> wanted(512);
    for (uint i = 0; i < count; ++i) {
        vec2 c = cellOf(i);
        observed[cell(static_cast<double>(c.x), 16) * 32 + cell(static_cast<double>(c.y), 32)] += 1;
    }
    for (std::size_t i = 0; i < 512; ++i) {
        double r = static_cast<double>(i / 32) / 16;
        wanted[i] = count * expected(r, r + 1.0 / 16) / 32;
    }
    ChiSquare r = chiSquareTest(observed, wanted);
    EXPECT_GT(r.p, kLevel) << r.statistic << " for " << r.degreesOfFreedom;
    EXPECT_EQ(r.outside, 0);
}

vec2 polar(double height, double x, double y)
{
    return vec2(static_cast<float>(height), static_cast<float>(turn(x, y)));
}

/// Tests a map to directions with density `pdf` that depends on 1 - z only: cells are equal in `1 -
/// z` up to `deep`.
void expectDirections(uint count, double deep, const std::function<vec3(vec2)>& draw,
                      const std::function<double(double)>& pdf)
{
    expectDensity(
        count,
        [&](uint i) {
            vec3 w = draw(pointOfMap(i));
            double x = static_cast<double>(w.x);
            double y = static_cast<double>(w.y);
            double z = static_cast<double>(w.z);
            // 1 - z from the sine where that is the more precise one.
            double below = z > 0.9
                               ? (x * x + y * y) / (1 + std::sqrt(std::max(0.0, 1 - x * x - y * y)))
                               : 1 - z;
            return polar(below / deep, x, y);
        },
        [&](double a, double b) {
            double sum = 0;  // midpoint rule: the densities are polynomials of degree one at most
            for (int k = 0; k < 16; ++k) sum += pdf(1 - deep * (a + (b - a) * (k + 0.5) / 16)) / 16;
            return sum * 2 * pi * deep * (b - a);
        });
}

void expectMaps(uint count)
{
    expectDensity(
        count,
        [](uint i) {
            vec2 p = shared::sampleDisk(pointOfMap(i));
            double x = static_cast<double>(p.x);
            double y = static_cast<double>(p.y);
            EXPECT_LE(x * x + y * y, 1 + 1e-6);
            return polar(x * x + y * y, x, y);
        },
        [](double a, double b) { return (b - a) * pi * static_cast<double>(shared::pdfDisk()); });
    expectDirections(count, 1, shared::sampleCosineHemisphere, [](double z) {
        return static_cast<double>(shared::pdfCosineHemisphere(vec3(0, 0, static_cast<float>(z))));
    });
    expectDirections(count, 1, shared::sampleUniformHemisphere,
                     [](double) { return static_cast<double>(shared::pdfUniformHemisphere()); });
    expectDirections(count, 2, shared::sampleSphere,
                     [](double) { return static_cast<double>(shared::pdfSphere()); });
    for (float narrow : {1.7f, 0.3f, 1e-5f, 1e-10f}) {
        expectDirections(
            count / 4, static_cast<double>(narrow),
            [=](vec2 u) { return shared::sampleCone(u, narrow); },
            [=](double) { return static_cast<double>(shared::pdfCone(narrow)); });
    }
    // Equal-area coordinates of a triangle: 1 - (1 - b1)^2 and b2 / (1 - b1).
    expectDensity(
        count,
        [](uint i) {
            vec2 b = shared::sampleTriangle(pointOfMap(i));
            EXPECT_TRUE(b.x >= 0 && b.y >= 0 && b.x + b.y <= 1);
            float rest = 1 - b.x;
            return vec2(1 - rest * rest, rest > 0 ? b.y / rest : 0.0f);
        },
        [](double a, double b) { return b - a; });
}

TEST(Warp, mapsHaveTheirDensities)
{
    expectMaps(1'000'000);
    EXPECT_FLOAT_EQ(shared::pdfTriangle(4.0f), 0.25f);
}

TEST(Warp, SlowMapsHaveTheirDensities)
{
    expectMaps(16'000'000);
}

TEST(Warp, theChiSquareSeesAMissingSquareRoot)
{
    std::vector<double> observed(512);
    std::vector<double> wanted(512, 100'000 / 512.0);
    for (uint i = 0; i < 100'000; ++i) {
        vec2 u = pointOfMap(i);
        double r = static_cast<double>(u.x);  // should be its square root
        observed[cell(r * r, 16) * 32 + cell(static_cast<double>(u.y), 32)] += 1;
    }
    EXPECT_LT(chiSquareTest(observed, wanted).p, 1e-100);
}

TEST(Warp, inversesGoBack)
{
    auto expectBack = [](vec2 u, vec2 back) {
        EXPECT_NEAR(shared::length(u - back), 0, 1e-3) << u.x << ' ' << u.y;
    };
    for (uint i = 0; i < 10'000; ++i) {
        vec2 u = pointOfMap(i);
        expectBack(u, shared::inverseDisk(shared::sampleDisk(u)));
        expectBack(u, shared::inverseCosineHemisphere(shared::sampleCosineHemisphere(u)));
        expectBack(u, shared::inverseUniformHemisphere(shared::sampleUniformHemisphere(u)));
        vec3 w = shared::sampleSphere(u);
        if (w.z > -0.9999f)
            expectBack(u, shared::inverseSphere(w));  // at the far pole azimuth is lost
        expectBack(u, shared::inverseCone(shared::sampleCone(u, 1e-5f), 1e-5f));
        expectBack(u, shared::inverseTriangle(shared::sampleTriangle(u)));
    }
}

TEST(Warp, cornersOfTheSquareStayFinite)
{
    for (float x : {0.0f, 0.5f, shared::kOneMinusEpsilon}) {
        for (float y : {0.0f, 0.5f, shared::kOneMinusEpsilon}) {
            vec2 u(x, y);
            EXPECT_LE(shared::length(shared::sampleDisk(u)), 1.000001f);
            for (vec3 w : {shared::sampleCosineHemisphere(u), shared::sampleUniformHemisphere(u),
                           shared::sampleSphere(u), shared::sampleCone(u, 1e-6f)}) {
                EXPECT_NEAR(shared::length(w), 1.0f, 1e-6f) << x << ' ' << y;
            }
            vec2 b = shared::sampleTriangle(u);
            EXPECT_TRUE(b.x >= 0 && b.y >= 0 && b.x + b.y <= 1);
        }
    }
}

TEST(Warp, octantPolynomialsAreGood)
{
    for (int i = -1000; i <= 1000; ++i) {
        float t = static_cast<float>(i) / 1000;
        vec2 cs = shared::octantCosSin(t);
        EXPECT_NEAR(static_cast<double>(cs.x), std::cos(static_cast<double>(t) * pi / 4), 1.2e-7);
        EXPECT_NEAR(static_cast<double>(cs.y), std::sin(static_cast<double>(t) * pi / 4), 1.2e-7);
    }
}

TEST(Warp, framesAreOrthonormalAndRightHanded)
{
    std::vector<vec3> normals = {vec3(0, 0, 1), vec3(0, 0, -1), vec3(1, 0, 0), vec3(0, -1, 0)};
    normals.push_back(shared::normalize(vec3(1e-5f, 0, -1)));
    normals.push_back(shared::normalize(vec3(1, 1, -1e-6f)));
    for (uint i = 0; i < 10'000; ++i) normals.push_back(shared::sampleSphere(pointOfMap(i)));
    for (vec3 n : normals) {
        shared::mat3 f = shared::makeFrame(n);
        EXPECT_EQ(f[2], n);
        EXPECT_NEAR(shared::dot(f[0], f[1]), 0, 1e-6);
        EXPECT_NEAR(shared::dot(f[0], n), 0, 1e-6);
        EXPECT_NEAR(shared::dot(f[1], n), 0, 1e-6);
        EXPECT_NEAR(shared::length(f[0]), 1, 1e-6);
        EXPECT_NEAR(shared::length(shared::cross(f[0], f[1]) - n), 0, 1e-6);
        vec3 v(0.3f, -0.2f, 0.9f);
        EXPECT_NEAR(shared::length(shared::toLocal(f, shared::toWorld(f, v)) - v), 0, 1e-6);
    }
}

TEST(Warp, packedDirectionsComeBack)
{
    double worst = 0;
    double worstTangent = 0;
    auto chord = [](vec3 a, vec3 b) { return static_cast<double>(shared::length(a - b)); };
    for (uint i = 0; i < 100'000; ++i) {
        vec3 d = shared::sampleSphere(pointOfMap(i));
        EXPECT_NEAR(chord(shared::octDecode(shared::octEncode(d)), d), 0, 5e-7);
        worst = std::max(worst, chord(shared::unpackOct(shared::packOct(d)), d));
        float hand = i % 2 == 0 ? 1.0f : -1.0f;
        shared::vec4 t = shared::unpackTangent(shared::packTangent(d, hand));
        EXPECT_EQ(t.w, hand);
        worstTangent = std::max(worstTangent, chord(shared::xyz(t), d));
    }
    EXPECT_LT(worst, 7e-5);
    EXPECT_LT(worstTangent, 1.4e-4);
    // Axes are exact, so that flat floors stay flat.
    for (int axis = 0; axis < 3; ++axis) {
        for (float sign : {1.0f, -1.0f}) {
            vec3 d(0.0f);
            d[axis] = sign;
            EXPECT_EQ(shared::unpackOct(shared::packOct(d)), d);
            EXPECT_EQ(shared::xyz(shared::unpackTangent(shared::packTangent(d, -1))), d);
        }
    }
}

}  // namespace
}  // namespace tests
