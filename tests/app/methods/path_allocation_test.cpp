// New paths given to pixels in proportion to their deviation, on every device: as many on the whole
// as without, more where it is noisy, and the mean stays.
#include <algorithm>
#include <cmath>

#include "core/methods/reuse_figures.h"
#include "tests/support/methods/reuse_flights.h"
#include "tests/support/statistics/stats.h"

namespace {

using namespace tests;
using core::PathAllocation;

ReuseParams byDeviation(ReuseStrategy strategy, uint32_t seed, float rays = 4)
{
    ReuseParams params = with(strategy, seed, rays);
    params.allocation = PathAllocation::deviation;
    return params;
}

TEST(PathAllocation, DeviationsAreCountedToAQuarterOfAnOctave)
{
    EXPECT_EQ(shared::deviationBin(0), 0u);
    EXPECT_EQ(shared::deviationOfBin(0), 0);
    for (float deviation = 3e-5f; deviation < 5e4f; deviation *= 1.07f) {
        const float counted = shared::deviationOfBin(shared::deviationBin(deviation));
        EXPECT_LE(std::abs(std::log2(counted / deviation)), 0.2501f) << deviation;
    }
    EXPECT_EQ(shared::deviationBin(1e30f), shared::kDeviationBins - 1);
}

/// Whatever the deviations are, the parts of all pixels have a mean of one, none is below one path
/// or above the bound.
TEST(PathAllocation, PartsHaveAMeanOfOne)
{
    const ReuseParams params = byDeviation(ReuseStrategy::ra, 1);
    shared::ReuseSettings settings = core::reuseSettings(params);
    settings.flags = core::reuseFlags(params, 0, false);
    for (const uint32_t spread : {1u, 3u, 8u, 20u}) {
        core::ReuseFigures found;
        for (uint32_t bin = 30 - spread; bin <= 30 + spread; ++bin)
            found.deviations[bin] = 1 + (bin * 7919u) % 13;
        const float scale = core::partPerDeviation(params, 0, found);
        double sum = 0, count = 0;
        for (uint32_t bin = 0; bin < shared::kDeviationBins; ++bin) {
            const float part = shared::allocatedPart(settings, scale, shared::deviationOfBin(bin));
            EXPECT_GE(part, 0.25f);
            EXPECT_LE(part, shared::kReuseMostPart);
            sum += found.deviations[bin] * double(part);
            count += found.deviations[bin];
        }
        EXPECT_NEAR(sum / count, 1, 1e-4) << spread;
    }
    EXPECT_EQ(core::partPerDeviation(params, 3, {}), 3) << "nothing was told";
    core::ReuseFigures quiet;
    quiet.deviations[0] = 100;
    EXPECT_EQ(core::partPerDeviation(params, 3, quiet), 0) << "as many to each";
    EXPECT_EQ(shared::allocatedPart(settings, 0, 1), 1);
    EXPECT_EQ(shared::allocatedPart(settings, 1, shared::kNoDeviation), 1);
    for (const ReuseStrategy mean : {ReuseStrategy::naive, ReuseStrategy::svgf})
        EXPECT_FALSE(core::allocatesPaths(byDeviation(mean, 1)));
    EXPECT_FALSE(core::allocatesPaths(byDeviation(ReuseStrategy::ra, 1, 1.5f)));
}

class PathAllocationFlights : public ReuseFlights {};

/// The deviation of single paths, as it is known after a flight, against that of many.
TEST_P(PathAllocationFlights, NoisyPixelsGetMoreAndAllOfThemAsMany)
{
    begin("cornell-moderate", {32, 32});
    for (const ReuseStrategy strategy : {ReuseStrategy::ra, ReuseStrategy::discard}) {
        SCOPED_TRACE(core::enumName(strategy));
        const core::Estimate truth = reference(1024);
        std::vector<float> rays;
        double scatter = 0;
        for (uint32_t view = 0; view < 12; ++view) {
            look(swung(*world_, 0), byDeviation(strategy, 5),
                 view == 0 ? core::Start::anew : core::Start::moved);
            const std::vector<core::Image> maps = renderer_->maps();
            rays = maps[5].pixels;
            double sum = 0;
            scatter = 0;
            for (size_t i = 0; i < rays.size(); ++i) {
                if (maps[0].pixels[i] == 0) continue;
                ++scatter;
                sum += double(rays[i]);
                ASSERT_GE(rays[i], 1);
                ASSERT_LE(rays[i], 32);
                if (view < 2) {
                    ASSERT_EQ(rays[i], 4) << "nothing is known yet";
                }
            }
            // In the third view by two times four paths, which tell little.
            EXPECT_NEAR(sum / scatter, 4, view == 2 ? 0.8 : 0.3) << view;
        }
        std::vector<std::pair<float, float>> pixels;  // variance of single paths, new paths
        for (size_t i = 0; i < rays.size(); ++i)
            if (rays[i] > 0)
                pixels.emplace_back(truth.variance.pixels[3 * i] + truth.variance.pixels[3 * i + 1],
                                    rays[i]);
        std::ranges::sort(pixels);
        const size_t quarter = pixels.size() / 4;
        double quiet = 0, noisy = 0;
        for (size_t i = 0; i < quarter; ++i) {
            quiet += double(pixels[i].second);
            noisy += double(pixels[pixels.size() - 1 - i].second);
        }
        EXPECT_GT(noisy, 2 * quiet);
    }
}

/// How many paths a pixel takes is learnt from its own samples, among others, and must not change
/// what old ones count: with c = N / (N + n) of the number it takes, bright samples would lead to a
/// smaller c, and count less (.16 % too dark here, 4.5 standard errors). At rest, where nothing
/// else can be wrong. Half a per cent would be seen by far.
TEST_P(PathAllocationFlights, TheMeanStaysAsItIs)
{
    constexpr uint32_t kFlights = 100, kViews = 8;
    begin("cornell-diffuse", {24, 24});
    const double expected = meanOf(reference(8192).mean);
    tests::Moments means;
    for (uint32_t flight = 0; flight < kFlights; ++flight)
        means.add(meanOf(fly(byDeviation(ReuseStrategy::ra, 9000 + flight), kViews, 0).mean));
    const double error = std::sqrt(means.varianceOfMean());
    EXPECT_LT(std::abs(means.mean() - expected), tests::kScore * error) << means.mean() / expected;
    EXPECT_LT((tests::kScore + 2.33) * error, 0.005 * expected) << "underpowered";
}

TEST_P(PathAllocationFlights, ItIsWhatTheCpuFinds)
{
    for (const ReuseStrategy strategy :
         {ReuseStrategy::ra, ReuseStrategy::discard, ReuseStrategy::full}) {
        SCOPED_TRACE(core::enumName(strategy));
        core::Image found[2], rays[2];
        for (const bool cpu : {false, true}) {
            renderer_ = &sharedRenderer("reuse", cpu ? app::DeviceKind::cpu : GetParam());
            begin("cornell-moderate", {32, 24});
            found[cpu] = fly(byDeviation(strategy, 12, 2), 7, 0.25).mean;
            rays[cpu] = renderer_->maps()[5];
        }
        // Where a few pixels differ, all that depends on the picture's mean deviation may round to
        // another number of paths.
        size_t off = 0;
        for (size_t i = 0; i < rays[0].pixels.size(); ++i)
            off += rays[0].pixels[i] != rays[1].pixels[i];
        EXPECT_LT(off, rays[0].pixels.size() / 20);
        EXPECT_NEAR(meanOf(rays[0]), meanOf(rays[1]), 0.02 * meanOf(rays[1]));
        EXPECT_NEAR(meanOf(found[0]), meanOf(found[1]), 2e-2 * meanOf(found[1]));
    }
}

/// Indices of samples that nothing was made of would leave holes in a sequence: every fourth point
/// lies in the same quarter of its domain, and the picture at rest would come to a mean over that.
TEST_P(PathAllocationFlights, PassesThatFollowLeaveNoSampleOut)
{
    begin("cornell-diffuse", {20, 20});
    const core::Image truth = reference(8192).mean;
    double errors[2] = {0, 0};
    for (const float rays : {1.0f, 4.0f}) {
        ReuseParams params = with(ReuseStrategy::discard, 6, rays);
        params.sampler = core::SamplerKind::sobol;
        look(swung(*world_, 0), params, core::Start::anew, 253);
        const core::Image found = renderer_->read(core::Reading::mean).mean;
        for (size_t i = 0; i < truth.pixels.size(); ++i)
            errors[rays > 1] += std::pow(double(found.pixels[i]) - double(truth.pixels[i]), 2);
    }
    EXPECT_LT(errors[1], 1.5 * errors[0]);
}

INSTANTIATE_TEST_SUITE_P(Device, PathAllocationFlights,
                         testing::Values(app::DeviceKind::cpu, app::DeviceKind::vulkan),
                         DeviceName());

}  // namespace
