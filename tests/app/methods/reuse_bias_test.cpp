// Path tracing that keeps its samples, on a camera that moves, on every device: what is kept
// changes no mean, or as little as was allowed.
#include <algorithm>
#include <cmath>

#include "tests/support/compare_films.h"
#include "tests/support/reuse_flights.h"
#include "tests/support/stats.h"

namespace {

using namespace tests;

class ReuseBias : public ReuseFlights {};

/// Every strategy that claims it, over independent flights: the mean over the picture stays within
/// half a per cent, which the flights could tell. Visibility of old samples is not asked for again,
/// so that it could be off.
TEST_P(ReuseBias, AMoveLeavesTheMeanAsItIs)
{
    constexpr uint32_t kFlights = 48, kFrames = 8;
    constexpr double kBound = 0.005;
    begin("cornell-moderate", {24, 24});
    const double expected = meanOf(reference(2048).mean);
    struct Case {
        ReuseStrategy strategy;
        float rays;
    };
    for (const auto [strategy, rays] :
         {Case{ReuseStrategy::ra, 1}, Case{ReuseStrategy::mis, 1},
          Case{ReuseStrategy::reweighting, 1}, Case{ReuseStrategy::ra, 2.5f},
          Case{ReuseStrategy::rejectionAugmentation, 1}, Case{ReuseStrategy::restirGi, 1}}) {
        tests::Moments means;
        for (uint32_t flight = 0; flight < kFlights; ++flight) {
            const core::Estimate e = fly(with(strategy, 100 + flight, rays), kFrames, 1.5);
            EXPECT_TRUE(e.counters.clean());
            means.add(meanOf(e.mean));
        }
        const double error = std::sqrt(means.varianceOfMean());
        EXPECT_LT(std::abs(means.mean() - expected), kBound * expected + tests::kScore * error)
            << core::enumName(strategy) << ", rays " << rays;
        EXPECT_LT(error, 0.01 * expected) << core::enumName(strategy) << " is underpowered";
    }
}

/// How far the mean of independent flights is from the truth, in its standard errors, over squares
/// of 2 x 2 pixels: 1 without bias.
double meanSquareScore(std::span<const core::Image> flights, const core::Image& truth)
{
    double sum = 0;
    size_t count = 0;
    for (uint32_t y = 0; y + 1 < truth.height; y += 2) {
        for (uint32_t x = 0; x + 1 < truth.width; x += 2, ++count) {
            const auto brightness = [&](const core::Image& image) {
                double all = 0;
                for (uint32_t k = 0; k < 4; ++k)
                    for (uint32_t c = 0; c < 3; ++c)
                        all += double(image.at(x + k % 2, y + k / 2)[c]);
                return all;
            };
            tests::Moments found;
            for (const core::Image& flight : flights) found.add(brightness(flight));
            sum += std::pow(found.mean() - brightness(truth), 2) / found.varianceOfMean();
        }
    }
    return sum / double(count);
}

/// Where old samples are asked for visibility, and new ones whether the view before could have had
/// them, nothing is wrong in any part of the picture. The same flights without asking are far off,
/// which shows that this test would tell.
TEST_P(ReuseBias, AskingForVisibilityTakesTheBiasAway)
{
    constexpr uint32_t kFrames = 5, kFlights = 96;
    begin("cornell-diffuse", {24, 24});
    const core::Image truth = reference(8192).mean;
    const auto scoreOf = [&](core::ReuseBias bias) {
        std::vector<core::Image> flights;
        for (uint32_t flight = 0; flight < kFlights; ++flight) {
            ReuseParams params = with(ReuseStrategy::ra, 4000 + flight);
            params.bias = bias;
            flights.push_back(fly(params, kFrames, 6).mean);
        }
        return meanSquareScore(flights, truth);
    };
    EXPECT_LT(scoreOf(core::ReuseBias::unbiased), 1.5);  // of 144 squares: 1.05 +- .13
    EXPECT_GT(scoreOf(core::ReuseBias::fast), 4);
}

/// A bound is kept by asking as often as it takes, and no more often.
TEST_P(ReuseBias, ABoundOfTheBiasIsKept)
{
    constexpr uint32_t kFlights = 48, kFrames = 12;
    begin("cornell-diffuse", {24, 24});
    const double expected = meanOf(reference(8192).mean);
    double asked[2];
    for (const float bound : {0.002f, 0.1f}) {
        tests::Moments means;
        for (uint32_t flight = 0; flight < kFlights; ++flight) {
            ReuseParams params = with(ReuseStrategy::ra, 5000 + flight);
            params.bias = core::ReuseBias::bounded;
            params.bound = bound;
            means.add(meanOf(fly(params, kFrames, 6).mean));
        }
        const double error = std::sqrt(means.varianceOfMean());
        EXPECT_LT(std::abs(means.mean() - expected),
                  double(bound) * expected + tests::kScore * error);
        EXPECT_LT(error, 0.002 * expected);
        asked[bound < 0.01f ? 0 : 1] = detail("visibility");
    }
    EXPECT_GT(asked[0], 0.3);
    EXPECT_LT(asked[1], 0.1);
}

/// Below one path per pixel, those with a good history take turns: the mean stays, too, and so many
/// are really spared.
TEST_P(ReuseBias, FewPathsLeaveTheMeanAsItIs)
{
    constexpr uint32_t kFlights = 24, kFrames = 24;
    begin("cornell-diffuse", {24, 24});
    const double expected = meanOf(reference(2048).mean);
    uint64_t paths[2];
    for (const bool few : {false, true}) {
        tests::Moments means;
        for (uint32_t flight = 0; flight < kFlights; ++flight) {
            fly(with(ReuseStrategy::ra, 300 + flight, few ? 0.25f : 1), kFrames, 0.25);
            means.add(meanOf(renderer_->read(core::Reading::mean).mean));
        }
        paths[few ? 1 : 0] = renderer_->stats().paths;
        const double error = std::sqrt(means.varianceOfMean());
        EXPECT_LT(std::abs(means.mean() - expected), 0.005 * expected + tests::kScore * error);
        EXPECT_LT(error, 0.01 * expected);
    }
    EXPECT_LT(double(paths[1]), 0.7 * double(paths[0]));
}

INSTANTIATE_TEST_SUITE_P(Device, ReuseBias,
                         testing::Values(app::DeviceKind::cpu, app::DeviceKind::vulkan),
                         DeviceName());

}  // namespace
