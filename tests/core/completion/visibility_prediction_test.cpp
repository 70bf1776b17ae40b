// M20. Prediction of visibility from few traced rows: each way where it is right, which of them is
// kept, and what that takes.
#include "core/completion/visibility_prediction.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/methods/visibility_matrices.h"

namespace core::many_lights {
namespace {

using glm::vec3;
using tests::bitError;
using tests::MatrixOracle;

/// Points in a square, seen or not as `visible` says, some of them traced.
struct Floor {
    std::vector<vec3> places;
    Words all, truth, traced, seen, untraced;
    std::vector<NearTraced> near;

    Floor(uint32_t count, double rate, uint64_t seed, const auto& visible)
    {
        Pcg32 random(seed);
        const uint32_t words = wordsFor(count);
        for (Words* w : {&all, &truth, &traced, &seen, &untraced}) w->assign(words, 0);
        for (uint32_t i = 0; i < count; ++i) {
            const auto x = static_cast<float>(2 * random() - 1),
                       y = static_cast<float>(2 * random() - 1);
            places.emplace_back(5 + x, 2, y);
            setBit(all, i);
            if (visible(x, y, random)) setBit(truth, i);
            if (!(random() < rate)) {
                setBit(untraced, i);
                continue;
            }
            setBit(traced, i);
            if (getBit(truth, i)) setBit(seen, i);
        }
        const NearRows rows(places);
        for (uint32_t i = 0; i < count; ++i) near.push_back(rows.find(i, traced));
    }
    KnownColumn known() const { return {traced, seen}; }

    // Which part of the untraced rows each way has wrong.
    double linear() const
    {
        return error([&](Words& p) { predictLinear(places, known(), untraced, p); });
    }
    double vote() const
    {
        return error([&](Words& p) { predictByVote(near, known(), untraced, p); });
    }
    double bayes(std::span<const SimilarColumn> similar) const
    {
        return error([&](Words& p) { predictByBayes(near, known(), similar, untraced, p); });
    }

private:
    double error(const auto& predict) const
    {
        Words predicted(truth.size(), ~uint64_t(0));
        predict(predicted);
        uint32_t wrong = 0;
        for (size_t w = 0; w < truth.size(); ++w) {
            EXPECT_EQ(predicted[w] & ~untraced[w], 0u) << "none but these were wanted";
            wrong += static_cast<uint32_t>(std::popcount((predicted[w] ^ truth[w]) & untraced[w]));
        }
        return double(wrong) / countBits(untraced);
    }
};

/// Of 20 floors.
template <class Of> double mean(double rate, const auto& visible, Of&& of)
{
    double sum = 0;
    for (uint64_t seed = 0; seed < 20; ++seed) sum += of(Floor(800, rate, seed, visible)) / 20;
    return sum;
}

TEST(Predictors, StraightEdgeIsForThePlane)
{
    const auto visible = [](float x, float y, Pcg32&) { return x + 0.5f * y > 0.1f; };
    const double linear = mean(0.05, visible, [](const Floor& f) { return f.linear(); });
    const double vote = mean(0.05, visible, [](const Floor& f) { return f.vote(); });
    EXPECT_LT(linear, 0.05);
    EXPECT_LT(linear, vote);
}

TEST(Predictors, SmoothBlobsAreForTheNeighbours)
{
    const auto visible = [](float x, float y, Pcg32&) {
        return std::sin(5 * x) * std::sin(5 * y) > 0;
    };
    const double linear = mean(0.25, visible, [](const Floor& f) { return f.linear(); });
    const double vote = mean(0.25, visible, [](const Floor& f) { return f.vote(); });
    EXPECT_LT(vote, 0.17);
    EXPECT_GT(linear, 0.35);
}

/// Where places tell nothing, but one of three other columns is the opposite.
TEST(Predictors, SimilarColumnsAreForBayes)
{
    const auto visible = [](float, float, Pcg32& random) { return random() < 0.5; };
    Pcg32 random(9);
    double bayes = 0, vote = 0, noise = 0;
    for (uint64_t seed = 0; seed < 20; ++seed) {
        const Floor floor(800, 0.1, seed, visible);
        Words opposite = floor.truth, other(opposite.size());
        for (uint64_t& w : opposite) w = ~w;
        for (uint64_t& w : other) w = uint64_t(random.bits()) << 32 | random.bits();
        const std::array<SimilarColumn, 3> similar{
            {{floor.all, other}, {floor.all, opposite}, {floor.all, other}}};
        bayes += floor.bayes(similar) / 20;
        noise += floor.bayes({similar.data(), 1}) / 20;
        vote += floor.vote() / 20;
    }
    EXPECT_LT(bayes, 0.02);
    EXPECT_NEAR(noise, 0.5, 0.03);
    EXPECT_NEAR(vote, 0.5, 0.03);
}

/// Against a search of all traced rows; few of them lie in the lists.
TEST(Predictors, NearRowsAreTheNearest)
{
    for (const double rate : {0.004, 0.02, 0.3}) {
        const Floor f(500, rate, 3, [](float, float, Pcg32&) { return true; });
        for (uint32_t i = 0; i < 500; ++i) {
            std::vector<std::pair<float, uint32_t>> all;
            forEachBit(f.traced, [&](uint32_t k) {
                const vec3 d = f.places[k] - f.places[i];
                if (k != i) all.emplace_back(glm::dot(d, d), k);
            });
            std::ranges::sort(all);
            ASSERT_EQ(f.near[i].count, std::min<size_t>(3, all.size()));
            for (uint32_t k = 0; k < f.near[i].count; ++k)
                ASSERT_EQ(f.near[i].row[k], all[k].second);
        }
    }
}

/// Rows in a square, lights in a line above it.
struct Places {
    std::vector<vec3> rows, columns;

    Places(uint32_t side, uint32_t count)
    {
        for (uint32_t i = 0; i < side * side; ++i) rows.emplace_back(i % side, i / side, 0);
        for (uint32_t j = 0; j < count; ++j) columns.emplace_back(j, 0, 10);
    }
    CompletedSlice predicted(MatrixOracle& oracle, const PredictionSettings& settings,
                             uint64_t seed = 1) const
    {
        CompletedSlice out;
        EXPECT_TRUE(predictVisibility(oracle, {rows, columns}, settings, seed, {}, out));
        EXPECT_EQ(out.stats.rays, oracle.rays());
        EXPECT_EQ(out.stats.entries, rows.size() * columns.size());
        EXPECT_EQ(out.stats.columns,
                  out.stats.inactive + out.stats.full + out.stats.matched + out.stats.repaired);
        return out;
    }
};

TEST(Prediction, TwoRoundsAreEnoughWhereAllAgree)
{
    const Places places(20, 30);
    BitMatrix truth(400, 30);
    for (uint32_t j = 0; j < 30; j += 2)
        for (uint32_t i = 0; i < 400; ++i) truth.set(i, j, true);
    MatrixOracle oracle(truth);
    const CompletedSlice out = places.predicted(oracle, {});
    EXPECT_EQ(out.visible, truth);
    EXPECT_EQ(out.stats.rays, 30u * 2 * 20);
    EXPECT_EQ(out.stats.matched, 30u);
    EXPECT_NEAR(out.stats.meanRate(), 2 * 20 / 400.0, 1e-9);
}

TEST(Prediction, NoiseTakesAllRounds)
{
    const Places places(20, 30);
    Pcg32 random(5);
    const BitMatrix truth = tests::randomMatrix(400, 30, 0.5, random);
    MatrixOracle oracle(truth);
    const CompletedSlice out = places.predicted(oracle, {});
    EXPECT_EQ(out.stats.rays, 30u * 11 * 20);
    EXPECT_EQ(out.stats.repaired, 30u);
    EXPECT_NEAR(bitError(truth, out.visible), 0.45 * 0.5, 0.03);
    for (uint32_t j = 0; j < 30; ++j)
        forEachBit(oracle.asked().column(j),
                   [&](uint32_t i) { ASSERT_EQ(out.visible.get(i, j), truth.get(i, j)); });
}

TEST(Prediction, IsTheTruthWhereAllIsTraced)
{
    const Places places(20, 30);
    Pcg32 random(6);
    const BitMatrix truth = tests::randomMatrix(400, 30, 0.5, random),
                    matters = tests::facingMask(400, 30, 0.6, random);
    MatrixOracle oracle(truth, matters);
    PredictionSettings settings;
    settings.rate = 1;
    const CompletedSlice out = places.predicted(oracle, settings);
    EXPECT_EQ(bitError(truth, out.visible, &matters), 0);
    EXPECT_EQ(out.stats.rays, countBits(matters.words()));
    EXPECT_EQ(out.stats.full + out.stats.inactive, 30u);
}

/// Shadows of spheres: fewer errors are allowed, more rays are taken and fewer errors made.
TEST(Prediction, ErrorsFollowWhatIsAllowed)
{
    const Places places(24, 60);
    Pcg32 random(7);
    const BitMatrix truth = tests::spheresMatrix(24, 60, 12, 0.12, 0.5, random);
    double last = 1;
    uint64_t rays = 0;
    for (const double allowed : {0.2, 0.05, 0.01}) {
        MatrixOracle oracle(truth), again(truth);
        PredictionSettings settings;
        settings.error = allowed;
        const CompletedSlice out = places.predicted(oracle, settings);
        const double error = bitError(truth, out.visible);
        // None wrong of the 29 rows of a round is no proof of fewer than one in thirty.
        EXPECT_LT(error, allowed + 0.05);
        EXPECT_LT(error, last);
        EXPECT_GT(out.stats.rays, rays);
        EXPECT_EQ(places.predicted(again, settings).visible, out.visible);
        last = error;
        rays = out.stats.rays;
    }
}

TEST(Prediction, ObeysStopsAndHasNoTroubleWithNothing)
{
    BitMatrix none(9, 4), empty(9, 0);
    MatrixOracle dark(none, none), nothing(empty);
    EXPECT_EQ(Places(3, 4).predicted(dark, {}).stats.inactive, 4u);
    EXPECT_EQ(Places(3, 0).predicted(nothing, {}).stats.rays, 0u);
    std::stop_source stop;
    stop.request_stop();
    MatrixOracle oracle(none);
    const Places places(3, 4);
    CompletedSlice out;
    EXPECT_FALSE(
        predictVisibility(oracle, {places.rows, places.columns}, {}, 1, stop.get_token(), out));
    EXPECT_EQ(oracle.calls(), 0u) << "columns nearby are looked for no longer";
}

}  // namespace
}  // namespace core::many_lights
