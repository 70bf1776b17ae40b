// T28: tone curves, exposure and the sRGB functions on 4096 values against double precision, and
// their bounds.
#include "shared/mis.h"
#include "shared/tonemap.h"

#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace tests {
namespace {

using shared::uint;
using shared::vec3;
using Color = std::array<double, 3>;
using Matrix = std::array<Color, 3>;  // rows

constexpr double kTolerance = 1.0 / 1024;

Color multiply(const Matrix& m, const Color& v)
{
    Color r{};
    for (std::size_t i = 0; i < 3; ++i) r[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
    return r;
}

double encodeDouble(double x)
{
    return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
}

Color aces(Color v)
{
    const Matrix in = {
        {{0.59719, 0.35458, 0.04823}, {0.07600, 0.90834, 0.01566}, {0.02840, 0.13383, 0.83777}}};
    const Matrix out = {{{1.60475, -0.53108, -0.07367},
                         {-0.10208, 1.10813, -0.00605},
                         {-0.00327, -0.07276, 1.07602}}};
    v = multiply(in, v);
    for (double& x : v)
        x = (x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.4329510) + 0.238081);
    return multiply(out, v);
}

Color agx(Color v)
{
    const Matrix in = {{{0.842479062253094, 0.0784335999999992, 0.0792237451477643},
                        {0.0423282422610123, 0.878468636469772, 0.0791661274605434},
                        {0.0423756549057051, 0.0784336, 0.879142973793104}}};
    const Matrix out = {{{1.19687900512017, -0.0980208811401368, -0.0990297440797205},
                         {-0.0528968517574562, 1.15190312990417, -0.0989611768448433},
                         {-0.0529716355144438, -0.0980434501171241, 1.15107367264116}}};
    v = multiply(in, v);
    for (double& x : v) {
        x = (std::log2(std::max(x, 1e-10)) + 12.47393) / (12.47393 + 4.026069);
        x = std::min(std::max(x, 0.0), 1.0);
        double sum = 0;
        for (double c : {15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232}) sum = sum * x + c;
        x = sum;
    }
    v = multiply(out, v);
    for (double& x : v) x = std::pow(std::min(std::max(x, 0.0), 1.0), 2.2);
    return v;
}

Color neutral(Color v)
{
    double low = std::min({v[0], v[1], v[2]});
    double offset = low < 0.08 ? low - 6.25 * low * low : 0.04;
    for (double& x : v) x -= offset;
    double peak = std::max({v[0], v[1], v[2]});
    if (peak < 0.76) return v;
    double newPeak = 1 - 0.24 * 0.24 / (peak + 0.24 - 0.76);
    double g = 1 - 1 / (0.15 * (peak - newPeak) + 1);
    for (double& x : v) x = x * newPeak / peak * (1 - g) + newPeak * g;
    return v;
}

Color reference(Color v, uint curve)
{
    if (curve == shared::kToneAces) v = aces(v);
    if (curve == shared::kToneAgx) v = agx(v);
    if (curve == shared::kToneNeutral) v = neutral(v);
    for (double& x : v) x = std::min(std::max(x, 0.0), 1.0);
    return v;
}

TEST(Tonemap, curvesAgreeWithDouble)
{
    for (uint curve = 0; curve < 4; ++curve) {
        for (int i = 0; i < 4096; ++i) {
            double stop = -14 + 22.0 * i / 4095;
            double x = std::exp2(stop);
            for (Color c : {Color{x, x, x}, Color{x, 0.3 * x, 0.02 * x}, Color{0, 0, x}}) {
                Color wanted = reference(c, curve);
                vec3 got = shared::toneMap(vec3(c[0], c[1], c[2]), curve);
                const vec3 encoded = shared::toneEncode(vec3(c[0], c[1], c[2]), curve);
                for (int k = 0; k < 3; ++k) {
                    // Compared as shown: after the transfer function.
                    double shown = static_cast<double>(shared::srgbEncode(got[k]));
                    const double expected = encodeDouble(wanted[static_cast<std::size_t>(k)]);
                    EXPECT_NEAR(shown, expected, kTolerance) << "curve " << curve << " at " << x;
                    EXPECT_NEAR(encoded[k], expected, kTolerance)
                        << "curve " << curve << " at " << x;
                }
            }
        }
    }
}

TEST(Tonemap, srgbAgreesWithDoubleAndInverts)
{
    for (int i = 0; i < 4096; ++i) {
        double x = i / 4095.0;
        EXPECT_NEAR(static_cast<double>(shared::srgbEncode(static_cast<float>(x))), encodeDouble(x),
                    1e-6);
        EXPECT_NEAR(shared::srgbDecode(shared::srgbEncode(static_cast<float>(x))), x, 2e-6);
    }
    EXPECT_NEAR(shared::srgbDecode(0.5f), 0.21404114048, 1e-6);
    EXPECT_EQ(shared::srgbEncode(0.0f), 0.0f);
    EXPECT_NEAR(shared::srgbEncode(1.0f), 1.0f, 1e-6);
    EXPECT_EQ(shared::srgbEncode(7.0f), shared::srgbEncode(1.0f));
}

TEST(Tonemap, exposureIsInStops)
{
    vec3 c = shared::expose(vec3(0.25f, 1, 3), 2);
    EXPECT_NEAR(c.x, 1, 1e-6);
    EXPECT_NEAR(c.z, 12, 1e-5);
    EXPECT_NEAR(shared::expose(vec3(1), -3).y, 0.125f, 1e-7);
}

TEST(Tonemap, greysRiseAndStayInRange)
{
    for (uint curve = 0; curve < 4; ++curve) {
        float last = 0;
        for (int i = 0; i < 2000; ++i) {
            float x = std::exp2(-12.0f + 24.0f * static_cast<float>(i) / 1999);
            vec3 c = shared::toneMap(vec3(x), curve);
            for (int k = 0; k < 3; ++k) EXPECT_TRUE(c[k] >= 0 && c[k] <= 1);
            EXPECT_GE(c.y, last - 2e-6f) << "curve " << curve << " at " << x;
            last = c.y;
        }
        EXPECT_GT(last, 0.97f) << curve;
    }
    // Khronos Neutral keeps base colours: below its shoulder it only takes off the 4 % of Fresnel.
    vec3 c = shared::toneMap(vec3(0.5f, 0.3f, 0.2f), shared::kToneNeutral);
    EXPECT_NEAR(c.x, 0.46f, 1e-6);
    EXPECT_NEAR(c.z, 0.16f, 1e-6);
}

TEST(Tonemap, survivesWhatIsNotANumber)
{
    float inf = std::numeric_limits<float>::infinity();
    float nan = std::numeric_limits<float>::quiet_NaN();
    for (uint curve = 0; curve < 4; ++curve) {
        for (vec3 c : {vec3(inf), vec3(nan), vec3(-1), vec3(1e30f, 0, -inf), vec3(3e38f, nan, 1)}) {
            for (const vec3 r : {shared::toneMap(c, curve), shared::toneEncode(c, curve)})
                for (int k = 0; k < 3; ++k)
                    EXPECT_TRUE(r[k] >= 0 && r[k] <= 1) << curve << ' ' << r[k];
        }
    }
}

TEST(Mis, powerHeuristicIsAPartitionOfUnity)
{
    for (float a : {1e-20f, 1e-3f, 1.0f, 5.0f, 1e12f, 1e30f}) {
        for (float b : {1e-20f, 1e-3f, 1.0f, 5.0f, 1e12f, 1e30f}) {
            float wa = shared::powerHeuristic(a, b);
            EXPECT_NEAR(wa + shared::powerHeuristic(b, a), 1.0f, 1e-6f);
            double exact = 1 / (1 + std::pow(static_cast<double>(b) / static_cast<double>(a), 2));
            EXPECT_NEAR(static_cast<double>(wa), exact, 1e-6 * exact + 1e-30);
        }
    }
}

TEST(Mis, powerHeuristicIsFiniteAtTheEnds)
{
    float inf = std::numeric_limits<float>::infinity();
    float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(shared::powerHeuristic(0.0f, 1.0f), 0.0f);
    EXPECT_EQ(shared::powerHeuristic(1.0f, 0.0f), 1.0f);
    EXPECT_EQ(shared::powerHeuristic(nan, 1.0f), 0.0f);
    EXPECT_EQ(shared::powerHeuristic(1.0f, nan), 1.0f);
    EXPECT_EQ(shared::powerHeuristic(inf, 1.0f), 1.0f);
    EXPECT_EQ(shared::powerHeuristic(1.0f, inf), 0.0f);
    EXPECT_EQ(shared::powerHeuristic(3e38f, 1e-38f), 1.0f);
}

}  // namespace
}  // namespace tests
