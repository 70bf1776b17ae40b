// M15. Clusters of columns: partitions, exact where columns are multiples of a few, and
// representatives whose weights make them unbiased, with a planted bias that is seen.
#include "core/many_lights/column_clusters.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/statistics/stats.h"

namespace core::many_lights {
namespace {

constexpr uint32_t kReceivers = 21;

ReducedMatrix filled(uint32_t columns, const std::function<float(uint32_t, uint32_t)>& entry)
{
    ReducedMatrix m(kReceivers, columns);
    for (uint32_t j = 0; j < columns; ++j) {
        for (uint32_t i = 0; i < kReceivers; ++i) m.column(j)[i] = entry(i, j);
        m.updateNorm(j);
    }
    return m;
}

/// Columns of lights of very different brightness, with a shadow each; some are zero.
ReducedMatrix someColumns(uint32_t columns, uint32_t seed)
{
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> uniform;
    std::vector<float> strength(columns), place(columns);
    for (uint32_t j = 0; j < columns; ++j) {
        strength[j] = std::pow(10.0f, -2 * uniform(random));
        place[j] = uniform(random);
    }
    return filled(columns, [&](uint32_t i, uint32_t j) {
        const float x = float(i) / kReceivers - place[j];
        return j % 17 == 3 || std::sin(20 * x) > 0.8f ? 0.0f : strength[j] / (0.05f + x * x);
    });
}

/// Columns that are multiples of `directions` different ones.
ReducedMatrix multiples(uint32_t columns, uint32_t directions)
{
    return filled(columns, [=](uint32_t i, uint32_t j) {
        const uint32_t d = j % directions;
        return float(1 + j / directions) *
               (i % directions == d ? 2.0f : 0.5f + 0.1f * float(i * (d + 1) % 5));
    });
}

std::vector<VirtualLight> lightsFor(const ReducedMatrix& matrix)
{
    std::vector<VirtualLight> lights(matrix.columns());
    for (uint32_t j = 0; j < matrix.columns(); ++j) lights[j].importance = 1 + float(j % 5);
    return lights;
}

void expectPartition(const ColumnClusters& clusters, const ReducedMatrix& matrix)
{
    std::vector<int> times(matrix.columns(), 0);
    uint32_t at = 0;
    for (const core::IndexRange& range : clusters.ranges) {
        EXPECT_EQ(range.begin, at);
        EXPECT_GT(range.size(), 0u);
        at = range.end;
        for (const uint32_t j : clusters.of(range)) ++times[j];
    }
    EXPECT_EQ(at, clusters.members.size());
    for (uint32_t j = 0; j < matrix.columns(); ++j)
        EXPECT_EQ(times[j], matrix.norm(j) > 0 ? 1 : 0) << j;
}

TEST(ColumnClusters, HoldEveryColumnThatIsNotZeroOnce)
{
    const ReducedMatrix matrix = someColumns(500, 1);
    for (const uint32_t count : {1u, 2u, 20u, 499u}) {
        Pcg32 random(count);
        ColumnClusters clusters = sampleClusters(matrix, count, random);
        expectPartition(clusters, matrix);
        EXPECT_LE(clusters.ranges.size(), count);
        EXPECT_GE(clusters.ranges.size(), count / 3);
        splitClusters(matrix, count + 30, clusters);
        expectPartition(clusters, matrix);
        // Of the last few columns some are as good as parallel.
        EXPECT_LE(clusters.ranges.size(), count + 30);
        EXPECT_GE(clusters.ranges.size(), std::min(count + 30, 400u));
    }
}

/// What is parallel is never told apart, and everything else is.
TEST(ColumnClusters, EndWithTheDirectionsThatThereAre)
{
    const ReducedMatrix matrix = multiples(700, 7);
    Pcg32 random(1);
    ColumnClusters clusters = sampleClusters(matrix, 3, random);
    splitClusters(matrix, 100, clusters);
    // Two centres may have been multiples of each other.
    EXPECT_GE(clusters.ranges.size(), 7u);
    EXPECT_LE(clusters.ranges.size(), 14u);
    for (const core::IndexRange& range : clusters.ranges)
        for (const uint32_t j : clusters.of(range))
            EXPECT_EQ(j % 7, clusters.members[range.begin] % 7);
}

TEST(ColumnClusters, ThereAreNoneOfNothing)
{
    const ReducedMatrix dark(kReceivers, 10);
    Pcg32 random(1);
    ColumnClusters clusters = sampleClusters(dark, 5, random);
    EXPECT_TRUE(clusters.ranges.empty());
    splitClusters(dark, 5, clusters);
    EXPECT_TRUE(clusters.ranges.empty());
    const UnseenLights unseen = unseenLights(dark, 64);
    EXPECT_EQ(unseen.lights.size(), 10u);
    EXPECT_EQ(unseen.clusters, 2u);
}

TEST(ColumnClusters, EqualColumnsAreOneCluster)
{
    const ReducedMatrix matrix = filled(50, [](uint32_t, uint32_t) { return 2.0f; });
    Pcg32 random(1);
    ColumnClusters clusters = sampleClusters(matrix, 5, random);
    splitClusters(matrix, 5, clusters);
    EXPECT_EQ(clusters.ranges.size(), 1u);
}

/// A column whose probability is its length stands for its multiples without error.
TEST(ColumnClusters, RepresentativesOfMultiplesAreExact)
{
    const ReducedMatrix matrix = multiples(700, 7);
    Pcg32 random(1);
    ColumnClusters clusters = sampleClusters(matrix, 3, random);
    splitClusters(matrix, 100, clusters);
    std::vector<float> lengths;
    for (uint32_t j = 0; j < 700; ++j) lengths.push_back(matrix.norm(j));
    std::vector<LightCluster> drawn;
    drawRepresentatives(clusters, lengths, random, drawn);
    ASSERT_LE(drawn.size(), 14u);
    for (uint32_t i = 0; i < kReceivers; ++i) {
        double sum = 0, exact = 0;
        for (const LightCluster& c : drawn)
            sum += double(c.scale) * double(matrix.column(c.light)[i]);
        for (uint32_t j = 0; j < 700; ++j) exact += double(matrix.column(j)[i]);
        EXPECT_NEAR(sum, exact, 1e-5 * exact);
    }
}

/// How far the mean over draws is from the sum over all lights of what each brings to some points,
/// which have not been sampled, in standard errors. `wrong`: scaled by brightness over brightness,
/// though drawn by length.
double largestClusterScore(bool wrong)
{
    const uint32_t lights = 400;
    const ReducedMatrix matrix = someColumns(lights, 2);
    const std::vector<VirtualLight> all = lightsFor(matrix);
    const std::vector<float> weights = representativeWeights(matrix, all);
    const UnseenLights unseen = unseenLights(matrix, 64);
    // What they bring elsewhere, in several channels: of no relation to the matrix.
    std::mt19937 engine(5);
    std::uniform_real_distribution<double> uniform;
    constexpr size_t kPoints = 12;
    std::vector<std::array<double, kPoints>> brings(lights);
    std::array<double, kPoints> exact{};
    for (uint32_t j = 0; j < lights; ++j)
        for (size_t i = 0; i < kPoints; ++i)
            exact[i] += brings[j][i] = uniform(engine) * (0.02 + double(weights[j]));
    std::array<tests::Moments, kPoints> sums;
    for (uint32_t seed = 0; seed < 2000; ++seed) {
        Pcg32 random(seed);
        ColumnClusters clusters = sampleClusters(matrix, 20, random);
        splitClusters(matrix, 62, clusters);
        std::vector<LightCluster> drawn;
        drawRepresentatives(clusters, weights, random, drawn);
        const size_t seen = drawn.size();
        drawSystematic(unseen.lights, weights, unseen.clusters, random, drawn);
        if (wrong)
            for (size_t k = 0; k < seen; ++k) {
                float sum = 0;
                for (const uint32_t j : clusters.of(clusters.ranges[k])) sum += all[j].importance;
                drawn[k].scale = sum / all[drawn[k].light].importance;
            }
        for (size_t i = 0; i < kPoints; ++i) {
            double sum = 0;
            for (const LightCluster& c : drawn) sum += double(c.scale) * brings[c.light][i];
            sums[i].add(sum);
        }
    }
    double largest = 0, error = 0;
    for (size_t i = 0; i < kPoints; ++i) {
        const double deviation = std::sqrt(sums[i].varianceOfMean());
        largest = std::max(largest, std::abs(sums[i].mean() - exact[i]) / deviation);
        error = std::max(error, deviation / exact[i]);
    }
    EXPECT_LT((tests::kScore + 2.33) * error, 0.07) << "underpowered";
    return largest;
}

TEST(ColumnClusters, RepresentativesAreUnbiased)
{
    EXPECT_LT(largestClusterScore(false), tests::kScore);
    EXPECT_GT(largestClusterScore(true), tests::kScore) << "a planted bias was not seen";
}

/// So many as asked for, each light of weight above a step at least once.
TEST(ColumnClusters, SystematicDrawsAreAsManyAsAskedFor)
{
    std::vector<uint32_t> members;
    std::vector<float> weights;
    for (uint32_t j = 0; j < 100; ++j) {
        members.push_back(j);
        weights.push_back(j == 50 ? 1000.0f : 1.0f);
    }
    for (uint32_t seed = 0; seed < 20; ++seed) {
        Pcg32 random(seed);
        std::vector<LightCluster> drawn;
        drawSystematic(members, weights, 10, random, drawn);
        ASSERT_EQ(drawn.size(), 10u);
        double heavy = 0;
        for (const LightCluster& c : drawn)
            if (c.light == 50) heavy += double(c.scale);
        EXPECT_NEAR(heavy, 1, 0.11);
        drawn.clear();
        drawSystematic(members, weights, 100, random, drawn);
        EXPECT_EQ(drawn.size(), 100u);
        for (const LightCluster& c : drawn) EXPECT_EQ(c.scale, 1);
    }
}

}  // namespace
}  // namespace core::many_lights
