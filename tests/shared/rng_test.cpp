// T1: the streams of (pixel, sample index, dimension) look independent where they should, for both
// samplers and the hash beneath them, also at the far end of the sample counter.
#include "shared/path_state.h"
#include "shared/rng.h"
#include "shared/sampler.h"
#include "tests/support/statistics/stats.h"

#include <gtest/gtest.h>
#include <vector>

namespace tests {
namespace {

using shared::kSamplerIndependent;
using shared::kSamplerSobol;
using shared::makeStream;
using shared::uint;
using shared::uvec2;
using shared::vec2;

/// Which coordinate of the stream's address runs in a series.
enum class Along { index, pixelX, pixelY, dimension, seed };

vec2 draw(uint kind, Along along, uint i, uint offset)
{
    uint index = 5 + offset;
    uint seed = 1;
    uint dimension = 3;
    uvec2 pixel(117, 230);
    switch (along) {
    case Along::index:
        index += i;
        break;
    case Along::pixelX:
        pixel = uvec2(i & 0x7fffu, i >> 15u);
        break;
    case Along::pixelY:
        pixel = uvec2(i >> 15u, i & 0x7fffu);
        break;
    case Along::dimension:
        dimension += i;
        break;
    case Along::seed:
        seed += i;
        break;
    }
    return shared::streamVec2(makeStream(kind, seed, pixel, index, shared::kPurposePath),
                              dimension);
}

constexpr Along kAll[] = {Along::index, Along::pixelX, Along::pixelY, Along::dimension,
                          Along::seed};

/// Chi-square of 256 bins, of pairs on 64 x 64 (successive values) and correlation of neighbours.
void expectRandom(uint kind, Along along, uint offset, uint n, bool independent)
{
    std::vector<double> bins(256);
    std::vector<double> pairs(64 * 64);
    std::vector<double> both(64 * 64);
    std::vector<float> xs(n);
    for (uint i = 0; i < n; ++i) {
        vec2 v = draw(kind, along, i, offset);
        xs[i] = v.x;
        bins[static_cast<std::size_t>(v.x * 256)] += 1;
        both[static_cast<std::size_t>(v.x * 64) * 64 + static_cast<std::size_t>(v.y * 64)] += 1;
        if (i % 2 == 1) {
            pairs[static_cast<std::size_t>(xs[i - 1] * 64) * 64 +
                  static_cast<std::size_t>(v.x * 64)] += 1;
        }
    }
    // A stratified series passes the one-sided tests by being too even: that is its purpose.
    std::vector<double> expected(256, n / 256.0);
    EXPECT_GT(chiSquareTest(bins, expected).p, kLevel) << "bins, along " << static_cast<int>(along);
    std::vector<double> expectedPairs(64 * 64, (n / 2) / 4096.0);
    std::vector<double> expectedBoth(64 * 64, n / 4096.0);
    EXPECT_GT(chiSquareTest(both, expectedBoth).p, kLevel)
        << "x and y, along " << static_cast<int>(along);
    if (!independent) return;
    EXPECT_GT(chiSquareTest(pairs, expectedPairs).p, kLevel)
        << "pairs, along " << static_cast<int>(along);
    for (uint lag : {1u, 2u, 32u}) {
        double r = correlation(std::span(xs).first(n - lag), std::span(xs).subspan(lag));
        EXPECT_LT(std::abs(r), std::max(1.5e-3, kScore / std::sqrt(static_cast<double>(n))))
            << "lag " << lag << ", along " << static_cast<int>(along);
    }
}

void expectRandomEverywhere(uint n)
{
    for (Along along : kAll) {
        for (uint kind : {kSamplerSobol, kSamplerIndependent}) {
            // Successive Sobol points of one pixel are stratified, hence dependent.
            expectRandom(kind, along, 0, n, kind == kSamplerIndependent || along != Along::index);
        }
    }
}

TEST(Rng, streamsAreUniformAndUncorrelated)
{
    expectRandomEverywhere(2'000'000);
}

TEST(Rng, SlowStreamsAreUniformAndUncorrelated)
{
    expectRandomEverywhere(10'000'000);
}

TEST(Rng, coordinatesOfOnePatternAreUncorrelated)
{
    for (uint kind : {kSamplerSobol, kSamplerIndependent}) {
        constexpr uint kCount = 1u << 20;
        std::vector<float> x(kCount);
        std::vector<float> y(kCount);
        std::vector<float> otherDimension(kCount);
        std::vector<float> nextFrame(kCount);
        for (uint i = 0; i < kCount; ++i) {
            uvec2 pixel(i & 1023u, i >> 10u);
            auto stream = makeStream(kind, 9, pixel, 40, shared::kPurposePath);
            vec2 v = shared::streamVec2(stream, 2);
            x[i] = v.x;
            y[i] = v.y;
            otherDimension[i] = shared::streamFloat(stream, 3);
            nextFrame[i] =
                shared::streamFloat(makeStream(kind, 9, pixel, 42, shared::kPurposePath), 2);
        }
        double bound = kScore / 1024;
        EXPECT_LT(std::abs(correlation(x, y)), bound);
        EXPECT_LT(std::abs(correlation(x, otherDimension)), bound);
        if (kind == kSamplerIndependent) {
            EXPECT_LT(std::abs(correlation(x, nextFrame)), bound);
        }
    }
}

// N14: a counter that a float would have frozen at 2^24, and the sign bit and the wrap of 32 bits.
TEST(Rng, sampleCounterHasNoSeams)
{
    for (uint kind : {kSamplerSobol, kSamplerIndependent}) {
        for (uint start : {(1u << 24) - 2048u, (1u << 31) - 2048u, 0u - 4096u}) {
            expectRandom(kind, Along::index, start, 4096 * 5, false);
            std::vector<float> seen;
            for (uint i = 0; i < 4; ++i) {
                seen.push_back(draw(kind, Along::index, i, start + 2046u - 5u).x);
            }
            std::sort(seen.begin(), seen.end());
            EXPECT_EQ(std::adjacent_find(seen.begin(), seen.end()), seen.end())
                << "a value repeats";
        }
    }
}

/// Largest deviation from one in two, in standard deviations, with which flips of input bits reach
/// output bits.
template <typename Hash> double worstAvalanche(uint inputBits, uint firstOutputBit, Hash hash)
{
    constexpr uint kCount = 1u << 14;
    double worst = 0;
    for (uint bit = 0; bit < inputBits; ++bit) {
        std::vector<double> flips(32);
        for (uint i = 0; i < kCount; ++i) {
            uint x = i * 2654435761u;
            uint change = hash(x, i) ^ hash(x ^ (1u << bit), i);
            for (uint o = 0; o < 32; ++o) flips[o] += (change >> o) & 1u;
        }
        for (uint o = firstOutputBit; o < 32; ++o) {
            worst = std::max(worst, std::abs(flips[o] - kCount * 0.5) / std::sqrt(kCount * 0.25));
        }
    }
    return worst;
}

TEST(Rng, hashesAvalanche)
{
    // Of pcg4d the upper 24 bits are used, and its words hold counters below 2^20 or so: its
    // highest input bits do not reach its lowest output bits.
    for (int out = 0; out < 4; ++out) {
        for (int in = 0; in < 4; ++in) {
            auto hash = [=](uint x, uint i) {
                shared::uvec4 v(i, 3, i ^ 0x1234567u, 9);
                v[in] = x;
                return shared::pcg4d(v)[out];
            };
            EXPECT_LT(worstAvalanche(20, 8, hash), 5.0) << in << " to " << out;
        }
    }
    EXPECT_LT(worstAvalanche(32, 0, [](uint x, uint) { return shared::hashUint(x); }), 60);
    EXPECT_GT(worstAvalanche(32, 0, [](uint x, uint) { return x * 747796405u; }),
              100);  // it can fail
}

/// What decides about a blended triangle, for the ray of a path's vertex or its connection.
struct AlphaAddress {
    uint seed = 1, index = 0, depth = 0, shadow = 0;

    float number(uint pixel) const
    {
        shared::SampleStream stream =
            makeStream(kSamplerSobol, seed, uvec2(pixel, 230), index, shared::kPurposePath);
        constexpr uint kTriangle = 7;
        return shared::unitFloat(shared::hashUint(shared::alphaSeed(stream, depth, shadow) ^
                                                  shared::hashUint(kTriangle)));
    }
};

/// Another seed, sample, vertex or purpose decides apart. As series run over samples, so do those
/// of which one is ahead of another: seeds must not be samples by other names.
TEST(Rng, decisionsAboutAlphaAreUncorrelated)
{
    constexpr uint kSamples = 1u << 13, kMostLag = 4;
    std::vector<float> first(kSamples), other(kSamples);
    const auto fill = [](AlphaAddress a, uint lag, std::vector<float>& series) {
        for (uint i = 0; i < kSamples; ++i) {
            a.index = kMostLag + i + lag;
            series[i] = a.number(117 + (i & 63u));
        }
    };
    fill({}, 0, first);
    size_t pairs = 0;
    double worst = 0;
    for (uint seed = 0; seed <= kMostLag; ++seed)
        for (uint depth = 0; depth <= kMostLag; ++depth)
            for (uint shadow = 0; shadow <= 1; ++shadow)
                for (uint index = 0; index <= 2 * kMostLag; ++index) {
                    const uint lag = index - kMostLag;
                    if (seed == 0 && depth == 0 && shadow == 0 && lag == 0) continue;
                    fill({1 + seed, 0, depth, shadow}, lag, other);
                    worst = std::max(worst, std::abs(correlation(first, other)));
                    ++pairs;
                }
    EXPECT_EQ(pairs, 449u);
    EXPECT_LT(worst, -normalQuantile(0.5 * sidak(kLevel, pairs)) / std::sqrt(double(kSamples)));
}

TEST(Rng, decisionsAboutAlphaAreUniform)
{
    for (int along = 0; along < 4; ++along) {
        constexpr uint kCount = 1u << 16;
        std::vector<double> bins(256), pairs(64 * 64);
        float before = 0;
        for (uint i = 0; i < kCount; ++i) {
            AlphaAddress a;
            a.seed += along == 0 ? i : 0;
            a.index += along == 1 ? i : 0;
            a.depth += along == 2 ? i / 2 : 0;
            a.shadow = along == 2 ? i % 2 : 0;
            const float x = a.number(along == 3 ? i & 0xffffu : 117);
            bins[static_cast<std::size_t>(x * 256)] += 1;
            if (i % 2 == 1)
                pairs[static_cast<std::size_t>(before * 64) * 64 +
                      static_cast<std::size_t>(x * 64)] += 1;
            before = x;
        }
        const std::vector<double> even(256, kCount / 256.0), evenPairs(64 * 64, kCount / 8192.0);
        EXPECT_GT(chiSquareTest(bins, even).p, kLevel) << along;
        EXPECT_GT(chiSquareTest(pairs, evenPairs).p, kLevel) << along;
    }
}

TEST(Rng, unitFloatStaysBelowOneAndIsExact)
{
    EXPECT_EQ(shared::unitFloat(0), 0.0f);
    EXPECT_LT(shared::unitFloat(0xffffffffu), 1.0f);
    EXPECT_EQ(shared::unitFloat(0x80000000u), 0.5f);
    EXPECT_EQ(shared::unitFloat(0xffffffffu), shared::kOneMinusEpsilon);
}

}  // namespace
}  // namespace tests
