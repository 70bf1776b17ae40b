// The Sobol sampler: (0,2)-sequence property after shuffling and scrambling, unbiasedness over
// scrambles, rates of convergence, and its arithmetic against a direct construction.
#include "shared/sampler.h"
#include "tests/support/statistics/stats.h"

#include <array>
#include <bit>
#include <cmath>
#include <gtest/gtest.h>
#include <set>
#include <vector>

namespace tests {
namespace {

using shared::kSamplerIndependent;
using shared::kSamplerSobol;
using shared::makeStream;
using shared::uint;
using shared::uvec2;
using shared::vec2;

/// Number of elementary intervals of 2^k points from `first` on that do not hold exactly one.
int unevenIntervals(uint seed, uvec2 pixel, uint dimension, uint first, uint k)
{
    std::vector<vec2> points;
    for (uint i = 0; i < (1u << k); ++i) {
        points.push_back(shared::streamVec2(
            makeStream(kSamplerSobol, seed, pixel, first + i, shared::kPurposePath), dimension));
    }
    int wrong = 0;
    for (uint a = 0; a <= k; ++a) {
        std::vector<int> counts(points.size());
        for (vec2 p : points) {
            auto x = static_cast<std::size_t>(p.x * static_cast<float>(1u << a));
            auto y = static_cast<std::size_t>(p.y * static_cast<float>(1u << (k - a)));
            ++counts[(x << (k - a)) | y];
        }
        for (int c : counts) wrong += c != 1;
    }
    return wrong;
}

TEST(Sampler, everyElementaryIntervalHoldsOnePoint)
{
    for (uint seed : {0u, 77u}) {
        for (uint dimension : {0u, 1u, 6u, 1001u}) {
            for (uint k : {1u, 4u, 8u, 11u}) {
                for (uint block : {0u, 1u, 5u}) {
                    EXPECT_EQ(unevenIntervals(seed, uvec2(31, 9), dimension, block << k, k), 0);
                }
            }
        }
    }
    EXPECT_EQ(unevenIntervals(3, uvec2(0, 0), 2, 0xffffffffu - 1023u, 10),
              0);  // the last block of the counter
    EXPECT_EQ(unevenIntervals(3, uvec2(65535, 65535), 2, 0x80000000u - 1024u, 10), 0);
}

TEST(Sampler, theCheckOfIntervalsCanFail)
{
    EXPECT_GT(unevenIntervals(3, uvec2(1, 1), 2, 7, 8), 0);  // not aligned to a block: no net
}

TEST(Sampler, pascalParityIsTheGeneratorMatrixOfSobol)
{
    // Direction numbers of the second dimension by its recurrence v' = v ^ (v >> 1) on reversed
    // bits.
    for (uint index : {1u, 2u, 3u, 0xdeadbeefu, 0x80000001u, 0xffffffffu, 123456u}) {
        uint v = 1u << 31;
        uint result = 0;
        for (uint bits = index; bits != 0; bits >>= 1) {
            if ((bits & 1u) != 0) result ^= v;
            v ^= v >> 1;
        }
        uint reversed = 0;
        uint parity = shared::pascalParity(index);
        for (uint b = 0; b < 32; ++b) reversed |= ((parity >> b) & 1u) << (31 - b);
        EXPECT_EQ(reversed, result) << index;
    }
}

TEST(Sampler, laineKarrasIsNested)
{
    // Bit b of the result depends on bits 0..b only, on bit b bijectively; half of the seeds flip
    // it.
    for (uint b = 0; b < 32; ++b) {
        int flipsOfNext = 0;
        for (uint seed = 0; seed < 4096; ++seed) {
            uint s = shared::hashUint(seed);
            uint x = shared::hashUint(seed + 77777u);
            uint change = shared::laineKarras(x, s) ^ shared::laineKarras(x ^ (1u << b), s);
            ASSERT_EQ(change & ((2u << b) - 1u), 1u << b);
            if (b < 31) flipsOfNext += static_cast<int>((change >> (b + 1)) & 1u);
        }
        // Lowest bits propagate by constants; from there on one in two, z-tested.
        if (b >= 4 && b < 31) {
            EXPECT_NEAR(flipsOfNext, 2048, 4.21 * 32 * 4) << b;
        }
    }
}

double smooth(vec2 p)
{
    double x = static_cast<double>(p.x);
    double y = static_cast<double>(p.y);
    return std::exp(-2 * x) * std::sin(3 * y) + x * y;
}

double smoothIntegral()
{
    return (1 - std::exp(-2.0)) / 2 * (1 - std::cos(3.0)) / 3 + 0.25;
}

/// Variance over `replicates` scrambles of the mean of n values, and the mean of the means.
Moments meansOf(uint kind, uint n, uint replicates, double (*f)(vec2))
{
    Moments result;
    for (uint r = 0; r < replicates; ++r) {
        double sum = 0;
        for (uint i = 0; i < n; ++i) {
            sum += f(shared::streamVec2(
                makeStream(kind, 11, uvec2(r & 63u, r >> 6u), i, shared::kPurposePath), 2));
        }
        result.add(sum / n);
    }
    return result;
}

TEST(Sampler, convergesFasterThanIndependentAndIsUnbiased)
{
    for (uint n : {16u, 64u, 256u, 1024u}) {
        Moments sobol = meansOf(kSamplerSobol, n, 1024, smooth);
        Moments independent = meansOf(kSamplerIndependent, n, 1024, smooth);
        EXPECT_LT(std::abs(againstExact(sobol, smoothIntegral()).z), kScore) << n;
        EXPECT_LT(std::abs(againstExact(independent, smoothIntegral()).z), kScore) << n;
        // Owen: variance of order n^-3 for smooth integrands, against n^-1.
        EXPECT_LT(sobol.variance() * n, independent.variance()) << n;
        EXPECT_LT(againstExact(sobol, smoothIntegral()).detectable, 0.005);
    }
    double ratio = meansOf(kSamplerSobol, 64, 512, smooth).variance() /
                   meansOf(kSamplerSobol, 1024, 512, smooth).variance();
    EXPECT_GT(ratio, std::pow(16.0, 2.5));
}

TEST(Sampler, discontinuousIntegrandsGainToo)
{
    auto disk = [](vec2 p) { return p.x * p.x + p.y * p.y < 1.0f ? 1.0 : 0.0; };
    Moments sobol = meansOf(kSamplerSobol, 1024, 1024, disk);
    Moments independent = meansOf(kSamplerIndependent, 1024, 256, disk);
    EXPECT_LT(sobol.variance() * 8, independent.variance());
    Comparison c = againstExact(sobol, std::acos(-1.0) / 4);
    EXPECT_LT(std::abs(c.z), kScore);
    EXPECT_LT(c.detectable, 0.005);
}

TEST(Sampler, scramblesAreUnbiasedPointByPoint)
{
    // Over scrambles, each single point is uniform: the fifth and the 2^24th sample on 16 x 16
    // cells.
    for (uint index : {5u, 1u << 24}) {
        std::vector<double> cells(256);
        constexpr uint kCount = 200'000;
        for (uint r = 0; r < kCount; ++r) {
            vec2 p = shared::streamVec2(makeStream(kSamplerSobol, r >> 16,
                                                   uvec2(r & 255u, (r >> 8) & 255u), index,
                                                   shared::kPurposePath),
                                        4);
            cells[static_cast<std::size_t>(p.x * 16) * 16 + static_cast<std::size_t>(p.y * 16)] +=
                1;
        }
        std::vector<double> expected(256, kCount / 256.0);
        EXPECT_GT(chiSquareTest(cells, expected).p, kLevel);
    }
}

TEST(Sampler, paddedDimensionsDoNotConspire)
{
    // Product of two patterns: without independent shuffles of the index its error would not fall.
    auto estimate = [](uint seed, uint a, uint b) {
        double sum = 0;
        for (uint i = 0; i < 256; ++i) {
            auto stream = makeStream(kSamplerSobol, seed, uvec2(4, 2), i, shared::kPurposePath);
            sum += (static_cast<double>(shared::streamFloat(stream, a)) - 0.5) *
                   (static_cast<double>(shared::streamFloat(stream, b)) - 0.5);
        }
        return sum / 256;
    };
    for (uint b : {3u, 4u, 6u, 10u, 66u}) {
        Moments m;
        Moments squares;
        for (uint seed = 0; seed < 2000; ++seed) {
            double e = estimate(seed, 2, b);
            m.add(e);
            squares.add(e * e);
        }
        EXPECT_LT(std::abs(m.mean()) / std::sqrt(m.varianceOfMean()), kScore);
        // Independent numbers have 1/144/256. Shuffles that keep aligned blocks together are
        // automorphisms of a binary tree, and give a little less than twice that; unshuffled
        // patterns would give up to 256 times.
        EXPECT_LT(squares.mean(), 2.0 / 144 / 256) << b;
    }
}

TEST(Sampler, streamsAreFunctionsOfTheirArguments)
{
    auto stream = makeStream(kSamplerSobol, 3, uvec2(8, 9), 10, shared::kPurposePath);
    vec2 first = shared::streamVec2(stream, 5);
    shared::streamVec2(stream, 6);
    EXPECT_EQ(first, shared::streamVec2(
                         makeStream(kSamplerSobol, 3, uvec2(8, 9), 10, shared::kPurposePath), 5));
    EXPECT_EQ(first.x, shared::streamFloat(stream, 5));
    EXPECT_NE(first, shared::streamVec2(
                         makeStream(kSamplerSobol, 3, uvec2(9, 8), 10, shared::kPurposePath), 5));
    EXPECT_NE(first, shared::streamVec2(
                         makeStream(kSamplerSobol, 4, uvec2(8, 9), 10, shared::kPurposePath), 5));
}

TEST(Sampler, thePurposeOfPathsLeavesTheSeedAsItIs)
{
    EXPECT_EQ(makeStream(kSamplerSobol, 77, uvec2(8, 9), 10, shared::kPurposePath).seed, 77u);
    // Seeds below 2^28 of two purposes never meet: the upper four bits of what is mixed in differ.
    std::set<uint> upper;
    for (uint purpose = 0; purpose < shared::kPurposeCount; ++purpose) {
        const uint seed = makeStream(kSamplerSobol, 0, uvec2(8, 9), 10, purpose).seed;
        EXPECT_TRUE(upper.insert(seed >> 28u).second) << purpose;
    }
}

/// Chi-square of pairs of numbers on `side` x `side` cells over pixels and samples: the same
/// pattern drawn for two purposes.
double independenceP(uint kind, uint a, uint b, uint dimension, uint side)
{
    std::vector<double> cells(std::size_t(side) * side);
    constexpr uint kPixels = 64, kSamples = 8;
    for (uint i = 0; i < kPixels * kPixels * kSamples; ++i) {
        const uvec2 pixel(i % kPixels, i / kPixels % kPixels);
        const uint index = 4099u * (i / (kPixels * kPixels));
        const float x = shared::streamFloat(makeStream(kind, 5, pixel, index, a), dimension);
        const float y = shared::streamFloat(makeStream(kind, 5, pixel, index, b), dimension);
        cells[static_cast<std::size_t>(x * static_cast<float>(side)) * side +
              static_cast<std::size_t>(y * static_cast<float>(side))] += 1;
    }
    const std::vector<double> expected(cells.size(), double(kPixels) * kPixels * kSamples /
                                                         static_cast<double>(cells.size()));
    return chiSquareTest(cells, expected).p;
}

TEST(Sampler, streamsOfDifferentPurposesAreIndependent)
{
    for (const uint kind : {kSamplerSobol, kSamplerIndependent}) {
        for (uint a = 0; a < shared::kPurposeCount; ++a) {
            for (uint b = a + 1; b < shared::kPurposeCount; ++b) {
                for (const uint dimension : {0u, 2u, 5u, 34u}) {
                    // Halves see what leading bits have in common, sixteenths the finer ones.
                    for (const uint side : {2u, 16u}) {
                        EXPECT_GT(independenceP(kind, a, b, dimension, side), kLevel)
                            << "kind " << kind << ", purposes " << a << " and " << b
                            << ", dimension " << dimension << ", side " << side;
                    }
                }
            }
        }
    }
    // Streams that are the same would be seen.
    EXPECT_LT(independenceP(kSamplerSobol, 1, 1, 2, 2), kLevel);
}

}  // namespace
}  // namespace tests
