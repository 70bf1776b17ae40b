// T-36. A view that rests, on every device: once its history has all that it can hold, plain paths
// go on and leave it alone.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/methods/reuse_settings.h"
#include "tests/support/methods/reuse_flights.h"
#include "tests/support/statistics/stats.h"

namespace {

using namespace tests;

class ReuseRest : public ReuseFlights {
protected:
    /// Full after eight passes.
    static ReuseParams quicklyFull(ReuseStrategy reuse = ReuseStrategy::ra)
    {
        ReuseParams params = with(reuse, 12);
        params.cap = 4;
        params.jitter = PixelJitter::settled;
        return params;
    }

    core::Estimate plain(uint32_t samples) const
    {
        core::Renderer& tracer = sharedRenderer("path", GetParam());
        tracer.setWorld(world_, {});
        const core::PathParams path = core::plainPaths(quicklyFull());
        tracer.setView({world_->cameras.at(0), size_, path}, core::Start::anew);
        tracer.advance({.samples = samples}, {});
        return tracer.read(core::Reading::everything);
    }
};

/// Sums over the samples that one picture took after another.
void expectSameSums(const core::Estimate& late, const core::Estimate& early,
                    const core::Estimate& lateToo, const core::Estimate& earlyToo)
{
    for (size_t i = 0; i < late.mean.pixels.size(); ++i) {
        const auto sum = [i](const core::Estimate& a, const core::Estimate& b) {
            return double(a.weight.pixels[i / 3]) * double(a.mean.pixels[i]) -
                   double(b.weight.pixels[i / 3]) * double(b.mean.pixels[i]);
        };
        const double expected = sum(lateToo, earlyToo);
        ASSERT_NEAR(sum(late, early), expected, 1e-4 * (expected + 1)) << i;
    }
}

/// Sample for sample: those that plain path tracing takes after as many passes.
TEST_P(ReuseRest, PlainPathsGoOn)
{
    begin("cornell-glossy", {40, 24});
    ASSERT_EQ(core::passesOfHistory(quicklyFull()), 8u);
    look(world_->cameras.at(0), quicklyFull(), core::Start::anew, 8);
    const core::Estimate full = renderer_->read(core::Reading::everything);
    EXPECT_EQ(detail("plain"), 0);
    EXPECT_EQ(renderer_->stats().paths, 8u * 40 * 24);
    const std::vector<core::Image> maps = renderer_->maps();
    renderer_->advance({.samples = 16}, {});
    const core::Estimate rested = renderer_->read(core::Reading::everything);
    EXPECT_EQ(rested.samples, 24u);
    EXPECT_EQ(detail("plain"), 16);
    EXPECT_NEAR(detail("n"), 1, 0.05);
    EXPECT_EQ(renderer_->stats().paths, 24u * 40 * 24);
    expectSameSums(rested, full, plain(24), plain(8));
    for (size_t i = 0; i < maps.size(); ++i)
        EXPECT_EQ(renderer_->maps().at(i).pixels, maps[i].pixels) << core::reuseMaps()[i].name;
    renderer_->setWorld(world_, {});
    EXPECT_LE(renderer_->stats().paths, 24u * 40 * 24) << "of a film that is gone";
}

/// However short the pieces are, and whatever they end in.
TEST_P(ReuseRest, InPiecesItIsTheSamePicture)
{
    begin("cornell-diffuse", {96, 64});
    look(world_->cameras.at(0), quicklyFull(), core::Start::anew, 20);
    const core::Image whole = renderer_->read(core::Reading::mean).mean;
    renderer_->setView({world_->cameras.at(0), size_, quicklyFull()}, core::Start::anew);
    for (int pieces = 0; renderer_->progress().samples < 20; ++pieces) {
        ASSERT_LT(pieces, 1000);
        renderer_->advance({.samples = 1, .seconds = 0}, {});
    }
    EXPECT_EQ(renderer_->read(core::Reading::mean).mean.pixels, whole.pixels);
    EXPECT_EQ(detail("plain"), 12);
}

/// Passes that follow in a view add what their new paths bring, as plain paths would: also where
/// lobes point elsewhere from one first hit of a pixel to the next, as on the spheres here, which
/// is where the first pass of a view draws candidates (with them 20 times this statistic).
TEST_P(ReuseRest, PassesThatFollowAreUnbiased)
{
    constexpr uint32_t kPictures = 16, kPasses = 24, kTile = 4;
    begin("glass", {32, 32});
    const core::Estimate truth = plain(1024);
    const size_t tilesPerRow = size_.x / kTile, tiles = tilesPerRow * size_.y / kTile;
    std::vector<Moments> means(tiles);
    std::vector<double> expected(tiles), noise(tiles);
    const auto tileOf = [&](size_t i) {
        return i / 3 / size_.x / kTile * tilesPerRow + i / 3 % size_.x / kTile;
    };
    constexpr double kValues = 3.0 * kTile * kTile;
    for (size_t i = 0; i < truth.mean.pixels.size(); ++i) {
        expected[tileOf(i)] += double(truth.mean.pixels[i]) / kValues;
        noise[tileOf(i)] += double(truth.variance.pixels[i]) / (kValues * kValues);
    }
    for (uint32_t seed = 1; seed <= kPictures; ++seed) {
        ReuseParams params = with(ReuseStrategy::ra, seed);
        params.cap = 16;
        params.jitter = PixelJitter::settled;
        look(world_->cameras.at(0), params, core::Start::anew);
        const core::Estimate first = renderer_->read(core::Reading::everything);
        renderer_->advance({.samples = kPasses}, {});
        const core::Estimate all = renderer_->read(core::Reading::everything);
        ASSERT_EQ(detail("plain"), 0);
        std::vector<double> sums(tiles);
        for (size_t i = 0; i < all.mean.pixels.size(); ++i) {
            const auto sum = [i](const core::Estimate& e) {
                return double(e.weight.pixels[i / 3]) * double(e.mean.pixels[i]);
            };
            sums[tileOf(i)] += (sum(all) - sum(first)) / (kPasses * kValues);
        }
        for (size_t tile = 0; tile < tiles; ++tile) means[tile].add(sums[tile]);
    }
    double squares = 0;
    for (size_t tile = 0; tile < tiles; ++tile) {
        // The colours of a pixel vary together: at most three times the variance.
        const double error = std::sqrt(means[tile].varianceOfMean() + 3 * noise[tile]);
        const double z = (means[tile].mean() - expected[tile]) / error;
        EXPECT_LT(std::abs(z), 7) << "tile " << tile << ", " << means[tile].mean() << " for "
                                  << expected[tile];
        squares += z * z;
    }
    EXPECT_GT(chiSquareP(squares, double(tiles)), kLevel) << squares;
}

/// What was kept is there when the camera moves on, and numbers go on after those of plain paths.
TEST_P(ReuseRest, TheHistoryWaits)
{
    begin("cornell-diffuse", {40, 40});
    look(swung(*world_, 0), quicklyFull(), core::Start::anew, 20);
    look(swung(*world_, -0.5), quicklyFull(), core::Start::moved);
    const core::Estimate moved = renderer_->read(core::Reading::everything);
    size_t remember = 0;
    for (const float weight : moved.weight.pixels) remember += weight == 5;
    EXPECT_GT(remember, moved.weight.pixels.size() * 9 / 10);
    EXPECT_EQ(detail("plain"), 0);

    const auto discarded = [&](float cap) {
        ReuseParams params = quicklyFull(ReuseStrategy::discard);
        params.cap = cap;
        look(swung(*world_, 0), params, core::Start::anew, 20);
        EXPECT_EQ(detail("plain"), cap > 4 ? 0 : 12);
        renderer_->setWorld(world_, {});
        look(swung(*world_, -0.5), params, core::Start::moved);
        return renderer_->read(core::Reading::mean).mean.pixels;
    };
    EXPECT_EQ(discarded(4), discarded(1000));
}

/// Plain paths are spread over their pixels: not where first hits stay at the centres.
TEST_P(ReuseRest, FirstHitsAtTheCentresStayThere)
{
    begin("cornell-diffuse", {24, 16});
    ReuseParams params = quicklyFull();
    params.jitter = PixelJitter::never;
    look(world_->cameras.at(0), params, core::Start::anew, 20);
    EXPECT_EQ(detail("plain"), 0);
}

/// Mean square error of the means of blocks of k x k pixels, in what can be shown.
double blockError(const core::Image& mean, const core::Image& truth, uint32_t k)
{
    const auto sum = [k](const core::Image& image, uint32_t x0, uint32_t y0, int c) {
        double shown = 0;
        for (uint32_t y = y0; y < y0 + k; ++y)
            for (uint32_t x = x0; x < x0 + k; ++x)
                shown += double(std::clamp(image.at(x, y)[c], 0.0f, 1.0f));
        return shown / (k * k);
    };
    double squares = 0;
    for (uint32_t y = 0; y + k <= truth.height; y += k)
        for (uint32_t x = 0; x + k <= truth.width; x += k)
            for (int c = 0; c < 3; ++c)
                squares += std::pow(sum(mean, x, y, c) - sum(truth, x, y, c), 2);
    return squares * k * k / (3.0 * truth.width * truth.height);
}

/// A camera that stops is shown at once what small pictures have left, and soon nothing of it:
/// pixels that have inherited the same samples err alike, and each block of them would be seen.
TEST_P(ReuseRest, SmallPicturesLeaveNoBlotches)
{
    constexpr glm::uvec2 kFull{96, 96};
    begin("cornell-diffuse", kFull);
    ReuseParams params = with(ReuseStrategy::ra, 3);
    params.jitter = PixelJitter::settled;
    params.sampler = core::SamplerKind::sobol;
    const auto flight = [&](ReuseStrategy reuse, uint32_t seed) {
        params.reuse = reuse;
        params.seed = seed;
        size_ = kFull / 4u;
        for (int i = 20; i > 0; --i)
            look(swung(*world_, -i), params, i == 20 ? core::Start::anew : core::Start::moved);
        size_ = kFull;
        look(swung(*world_, 0), params, core::Start::moved);
    };
    const auto mean = [&] { return renderer_->read(core::Reading::mean).mean; };
    flight(ReuseStrategy::discard, 991);
    renderer_->advance({.samples = 255}, {});
    const core::Image truth = mean();
    // Of pixels at first; of blocks of 4x4 and 8x8 after 24 samples: by `ra` and by `discard`.
    std::array<std::array<double, 2>, 3> error{};
    for (const uint32_t which : {0u, 1u})
        for (uint32_t seed = 1; seed <= 3; ++seed) {
            flight(which == 0 ? ReuseStrategy::ra : ReuseStrategy::discard, seed);
            error[0][which] += blockError(mean(), truth, 1);
            renderer_->advance({.samples = 23}, {});
            error[1][which] += blockError(mean(), truth, 4);
            error[2][which] += blockError(mean(), truth, 8);
        }
    EXPECT_LE(error[0][0], error[0][1] / 6);
    EXPECT_LE(error[1][0], error[1][1] * 1.8);
    EXPECT_LE(error[2][0], error[2][1] * 3);
}

/// Pixels at the border of a larger picture of the same view were in the smaller one: all have a
/// history where something was hit.
TEST_P(ReuseRest, LargerPicturesHaveHistoriesUpToTheirBorders)
{
    begin("cornell-diffuse", {12, 12});
    ReuseParams params = with(ReuseStrategy::ra, 3);
    params.jitter = PixelJitter::settled;
    look(world_->cameras.at(0), params, core::Start::anew, 4);
    size_ = {96, 96};
    look(world_->cameras.at(0), params, core::Start::moved, 1);
    const core::Image history = renderer_->maps().at(0);
    ASSERT_STREQ(core::reuseMaps()[0].name, "history");
    size_t border = 0, without = 0;
    for (uint32_t y = 0; y < 96; ++y)
        for (uint32_t x = 0; x < 96; ++x) {
            if (std::min({x, y, 95 - x, 95 - y}) >= 4) continue;
            ++border;
            without += !(*history.at(x, y) > 1.5f);
        }
    EXPECT_LT(double(without), 0.03 * double(border));
}

INSTANTIATE_TEST_SUITE_P(Device, ReuseRest,
                         testing::Values(app::DeviceKind::cpu, app::DeviceKind::vulkan),
                         DeviceName());

}  // namespace
