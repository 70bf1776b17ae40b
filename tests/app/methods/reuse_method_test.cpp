// Path tracing that keeps its samples, on a camera that moves, on every device: what is kept may
// change the noise and nothing else.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "app/methods/methods.h"
#include "core/gltf/gltf.h"
#include "tests/support/compare_films.h"
#include "tests/support/stats.h"

namespace {

using core::ReuseParams, core::ReuseStrategy, core::PixelJitter;

std::shared_ptr<const core::World> asset(const std::string& name)
{
    return core::makeWorld(
        core::loadGltf(std::string(REKINDLE_SOURCE_DIR "/assets/") + name + ".gltf"));
}

/// The scene's camera, swung about what it looks at.
core::Camera swung(const core::World& world, double degrees)
{
    core::Camera camera = world.cameras.at(0);
    const double angle = degrees * std::numbers::pi / 180;
    const glm::dvec3 target = camera.position + 3.7 * camera.forward;
    const glm::dvec3 back = camera.position - target;
    const glm::dvec3 turned(back.x * std::cos(angle) + back.z * std::sin(angle), back.y,
                            back.z * std::cos(angle) - back.x * std::sin(angle));
    return core::lookAt(target + turned, target, {0, 1, 0}, camera.yfov);
}

ReuseParams with(ReuseStrategy reuse, uint32_t seed, float rays = 1)
{
    ReuseParams params;
    params.rays = rays;
    params.reuse = reuse;
    params.seed = seed;
    params.sampler = core::SamplerKind::independent;
    params.jitter = PixelJitter::never;
    return params;
}

class ReuseMethod : public testing::TestWithParam<app::DeviceKind> {
protected:
    void SetUp() override
    {
        const std::string why = app::whyNot("reuse", GetParam());
        if (!why.empty()) GTEST_SKIP() << why;
        renderer_ = app::makeRenderer("reuse", {.device = GetParam()});
    }

    void begin(const std::string& scene, glm::uvec2 size)
    {
        world_ = asset(scene);
        renderer_->setWorld(world_, {});
        size_ = size;
    }

    /// The picture after a swing of `frames` views, `step` degrees apart, that ends at the scene's
    /// own camera.
    core::Estimate fly(const ReuseParams& params, uint32_t frames, double step)
    {
        for (uint32_t i = 0; i < frames; ++i)
            look(swung(*world_, -step * (frames - 1 - i)), params,
                 i == 0 ? core::Start::anew : core::Start::moved);
        return renderer_->read(core::Reading::everything);
    }

    void look(const core::Camera& camera, const ReuseParams& params, core::Start start,
              uint32_t samples = 1)
    {
        renderer_->setView({camera, size_, params}, start);
        renderer_->advance({.samples = samples}, {});
    }

    core::Estimate reference(uint32_t samples)
    {
        look(swung(*world_, 0), with(ReuseStrategy::discard, 991), core::Start::anew, samples);
        return renderer_->read(core::Reading::everything);
    }

    /// Of each pixel, whether its centre shows a flat pane of glass. (Curved glass bends what is
    /// behind it, and seldom finds a history.)
    std::vector<bool> seenThroughPane() const
    {
        const core::Aovs aovs = renderer_->aovs();
        std::vector<bool> found(size_t(size_.x) * size_.y);
        for (size_t i = 0; i < found.size(); ++i) {
            const int material = static_cast<int>(aovs.ids.pixels[3 * i + 1]);
            if (material < 0) continue;
            const std::string& name = world_->scene->materials.at(size_t(material)).name;
            found[i] = name == "pane";
        }
        return found;
    }

    /// A figure that the renderer tells of the last view.
    double detail(const std::string& name) const
    {
        for (const core::StatsDetail& d : renderer_->stats().details)
            if (d.name == name) return std::get<double>(d.value);
        ADD_FAILURE() << name << " is not told";
        return 0;
    }

    std::unique_ptr<core::Renderer> renderer_;
    std::shared_ptr<const core::World> world_;
    glm::uvec2 size_{};
};

double meanSquare(const core::Image& a, const core::Image& b)
{
    double sum = 0;
    for (size_t i = 0; i < a.pixels.size(); ++i)
        sum += std::pow(double(a.pixels[i]) - double(b.pixels[i]), 2);
    return sum / double(a.pixels.size());
}

double meanOf(const core::Image& image)
{
    double sum = 0;
    for (const float x : image.pixels) sum += double(x);
    return sum / double(image.pixels.size());
}

TEST_P(ReuseMethod, WithoutHistoryItIsPathTracing)
{
    begin("cornell-moderate", {40, 40});
    ReuseParams params = with(ReuseStrategy::discard, 5);
    params.jitter = PixelJitter::always;
    look(world_->cameras.at(0), params, core::Start::anew, 128);
    const core::Estimate reused = renderer_->read(core::Reading::everything);
    core::PathParams path;
    path.seed = 6;
    path.sampler = core::SamplerKind::independent;
    const auto tracer = app::makeRenderer("path", {.device = GetParam()});
    tracer->setWorld(world_, {});
    tracer->setView({world_->cameras.at(0), size_, path}, core::Start::anew);
    tracer->advance({.samples = 128}, {});
    const tests::FilmComparison c =
        tests::compareFilms(reused, tracer->read(core::Reading::everything));
    EXPECT_TRUE(c.agree()) << c.describe();
}

/// Every strategy that claims it, over independent flights: the mean over the picture stays within
/// half a per cent, which the flights could tell. Visibility of old samples is not asked for again,
/// so that it could be off.
TEST_P(ReuseMethod, AMoveLeavesTheMeanAsItIs)
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
TEST_P(ReuseMethod, AskingForVisibilityTakesTheBiasAway)
{
    constexpr uint32_t kFrames = 5;
    const uint32_t count = GetParam() == app::DeviceKind::cpu ? 96 : 32;
    begin("cornell-diffuse", {24, 24});
    const core::Image truth = reference(8192).mean;
    const auto scoreOf = [&](core::ReuseBias bias) {
        std::vector<core::Image> flights;
        for (uint32_t flight = 0; flight < count; ++flight) {
            ReuseParams params = with(ReuseStrategy::ra, 4000 + flight);
            params.bias = bias;
            flights.push_back(fly(params, kFrames, 6).mean);
        }
        return meanSquareScore(flights, truth);
    };
    EXPECT_LT(scoreOf(core::ReuseBias::unbiased), 1.6);  // of 144 squares: 1.05 +- .13
    EXPECT_GT(scoreOf(core::ReuseBias::fast), 3);
}

/// A bound is kept by asking as often as it takes, and no more often. How often is decided in one
/// place for all devices, so that one is enough.
TEST_P(ReuseMethod, ABoundOfTheBiasIsKept)
{
    if (GetParam() != app::DeviceKind::cpu) GTEST_SKIP() << "the CPU tells";
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
TEST_P(ReuseMethod, FewPathsLeaveTheMeanAsItIs)
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

/// Mirrors and glass are looked through: the picture is that of path tracing, and what is seen
/// there keeps its samples.
TEST_P(ReuseMethod, MirrorsAndGlassAreLookedThrough)
{
    begin("glass", {48, 36});
    ReuseParams plain = with(ReuseStrategy::discard, 7);
    plain.jitter = PixelJitter::always;
    look(world_->cameras.at(0), plain, core::Start::anew, 256);
    const core::Estimate here = renderer_->read(core::Reading::everything);
    const auto tracer = app::makeRenderer("path", {.device = GetParam()});
    tracer->setWorld(world_, {});
    core::PathParams path;
    path.seed = 8;
    path.sampler = core::SamplerKind::independent;
    tracer->setView({world_->cameras.at(0), size_, path}, core::Start::anew);
    tracer->advance({.samples = 256}, {});
    const tests::FilmComparison c =
        tests::compareFilms(here, tracer->read(core::Reading::everything));
    EXPECT_TRUE(c.agree()) << c.describe();

    const std::vector<bool> chained = seenThroughPane();
    ASSERT_GT(std::ranges::count(chained, true), 100);
    // Up to what scatters behind the pane: light that glass bends to a point further on is noise of
    // a kind of its own, and there is little of it in so few flights.
    const auto params = [](ReuseStrategy strategy, uint32_t seed) {
        ReuseParams p = with(strategy, seed);
        p.maxDepth = 2;
        return p;
    };
    look(swung(*world_, 0), params(ReuseStrategy::discard, 991), core::Start::anew, 2048);
    const core::Image truth = renderer_->read(core::Reading::mean).mean;
    // The median over pixels: those where a narrow coat shows the lamp need more flights than this.
    double medians[2];
    for (const ReuseStrategy strategy : {ReuseStrategy::discard, ReuseStrategy::ra}) {
        std::vector<double> errors(chained.size(), 0);
        for (uint32_t flight = 0; flight < 8; ++flight) {
            const core::Image found = fly(params(strategy, 60 + flight), 16, 0.5).mean;
            for (size_t i = 0; i < chained.size(); ++i)
                for (size_t k = 3 * i; chained[i] && k < 3 * i + 3; ++k)
                    errors[i] += std::pow(found.pixels[k] - truth.pixels[k], 2);
        }
        std::erase(errors, 0);
        std::ranges::nth_element(errors, errors.begin() + ptrdiff_t(errors.size() / 2));
        medians[strategy == ReuseStrategy::ra] = errors[errors.size() / 2];
    }
    EXPECT_LT(medians[1], 0.2 * medians[0]);
}

TEST_P(ReuseMethod, OldSamplesTakeTheNoiseAway)
{
    begin("cornell-diffuse", {48, 48});
    const core::Image truth = reference(2048).mean;
    const auto error = [&](ReuseStrategy strategy) {
        return meanSquare(fly(with(strategy, 3), 24, 1).mean, truth);
    };
    const double discard = error(ReuseStrategy::discard);
    // Pixels that come into view have no history and most of the error: 0.11 is found.
    EXPECT_LT(error(ReuseStrategy::ra), 0.15 * discard);
    EXPECT_LT(error(ReuseStrategy::mis), 0.15 * discard);
    EXPECT_LT(error(ReuseStrategy::naive), 0.15 * discard);
    EXPECT_LT(error(ReuseStrategy::rejectionAugmentation), 0.2 * discard);
    EXPECT_LT(error(ReuseStrategy::svgf), 0.35 * discard);  // forgets after five
    EXPECT_LT(error(ReuseStrategy::restirGi), 0.5 * discard);
}

/// Where nothing of before can be seen, the picture is that of Discard, to the bit.
TEST_P(ReuseMethod, ATeleportIsDiscard)
{
    begin("cornell-glossy", {32, 24});
    const core::Camera here = swung(*world_, 0);
    core::Camera behind = here;
    behind.forward = -here.forward;
    behind.position = {0, 0, -0.5};
    const auto picture = [&](ReuseStrategy strategy) {
        look(here, with(strategy, 4), core::Start::anew);
        look(behind, with(strategy, 4), core::Start::moved);
        return renderer_->read(core::Reading::everything);
    };
    const core::Estimate discarded = picture(ReuseStrategy::discard);
    EXPECT_GT(meanOf(discarded.mean), 0);
    const core::Estimate reused = picture(ReuseStrategy::ra);
    size_t alone = 0;
    for (size_t i = 0; i < reused.weight.pixels.size(); ++i) {
        if (reused.weight.pixels[i] != 1) continue;
        ++alone;
        for (size_t c = 0; c < 3; ++c)
            ASSERT_EQ(reused.mean.pixels[3 * i + c], discarded.mean.pixels[3 * i + c]) << i;
    }
    EXPECT_GT(alone, reused.weight.pixels.size() / 2);
}

/// A wall without thickness has two sides at the same place: what lights one says nothing of the
/// other.
TEST_P(ReuseMethod, TheOtherSideOfAWallHasAHistoryOfItsOwn)
{
    begin("cornell-diffuse", {24, 24});
    const double yfov = world_->cameras.at(0).yfov;
    const core::Camera outside = core::lookAt({-3, 0, 0}, {-1, 0, 0}, {0, 1, 0}, yfov);
    const core::Camera inside = core::lookAt({0.5, 0, 0}, {-1, 0, 0}, {0, 1, 0}, yfov);
    const ReuseParams params = with(ReuseStrategy::ra, 4);
    const auto withHistory = [&](const core::Camera& from, const core::Camera& to) {
        look(from, params, core::Start::anew);
        look(to, params, core::Start::moved);
        const core::Estimate e = renderer_->read(core::Reading::everything);
        return std::ranges::count_if(e.weight.pixels, [](float w) { return w > 1; });
    };
    EXPECT_EQ(withHistory(outside, inside), 0);
    EXPECT_EQ(withHistory(inside, outside), 0);
    EXPECT_GT(withHistory(outside, outside), 100);
    EXPECT_GT(withHistory(inside, inside), 100);
}

/// What the maps say of a flight fits together, and with the picture's weights.
TEST_P(ReuseMethod, MapsTellWhatWasReused)
{
    begin("cornell-diffuse", {24, 20});
    for (const ReuseStrategy strategy : {ReuseStrategy::ra, ReuseStrategy::naive}) {
        const core::Estimate e = fly(with(strategy, 4), 4, 0.5);
        const std::vector<core::Image> maps = renderer_->maps();
        ASSERT_EQ(maps.size(), core::reuseMaps().size());
        const auto at = [&](size_t map, size_t pixel) { return maps[map].pixels.at(pixel); };
        size_t remember = 0;
        for (size_t i = 0; i < e.weight.pixels.size(); ++i) {
            const float history = at(0, i), alpha = at(1, i), c = at(2, i);
            if (history > 0) {
                EXPECT_NEAR(history, e.weight.pixels[i], 1e-3);
            }
            EXPECT_NEAR(c, 1 - 1 / e.weight.pixels[i], 1e-3);
            EXPECT_NEAR(at(3, i), 1 - alpha, 1e-6);
            if (history <= 1) {
                EXPECT_EQ(alpha, 0);
            }
            EXPECT_EQ(at(5, i), history > 0 ? 1 : 0);
            remember += history == 4;
        }
        EXPECT_GT(remember, e.weight.pixels.size() / 2);
    }
}

TEST_P(ReuseMethod, OtherParametersAndScenesBeginAnew)
{
    begin("cornell-glossy", {32, 24});
    const core::Camera camera = swung(*world_, 0);
    ReuseParams params = with(ReuseStrategy::ra, 4);
    const auto largestWeight = [&] {
        const core::Estimate e = renderer_->read(core::Reading::everything);
        return *std::ranges::max_element(e.weight.pixels);
    };
    look(camera, params, core::Start::anew);
    EXPECT_EQ(largestWeight(), 1);
    look(swung(*world_, 0.5), params, core::Start::moved);
    EXPECT_EQ(largestWeight(), 2);
    params.maxDepth = 3;
    look(camera, params, core::Start::moved);
    EXPECT_EQ(largestWeight(), 1);
    look(camera, params, core::Start::anew);
    EXPECT_EQ(largestWeight(), 1);
    renderer_->setWorld(world_, {});
    look(camera, params, core::Start::moved);
    EXPECT_EQ(largestWeight(), 1);
}

/// The window's resolution follows the speed of the machine: what was found at one serves another.
TEST_P(ReuseMethod, HistorySurvivesAChangeOfSize)
{
    begin("cornell-diffuse", {48, 48});
    const core::Image truth = reference(1024).mean;
    const ReuseParams params = with(ReuseStrategy::ra, 6);
    size_ = {24, 24};
    fly(params, 16, 1);
    size_ = {48, 48};
    look(swung(*world_, 0.5), params, core::Start::moved);
    look(swung(*world_, 0), params, core::Start::moved);
    const core::Estimate grown = renderer_->read(core::Reading::everything);
    look(swung(*world_, 0), with(ReuseStrategy::discard, 6), core::Start::anew);
    const core::Image discarded = renderer_->read(core::Reading::mean).mean;
    EXPECT_LT(meanSquare(grown.mean, truth), 0.3 * meanSquare(discarded, truth));
    EXPECT_NEAR(meanOf(grown.mean), meanOf(truth), 0.05 * meanOf(truth));
    const auto remembering =
        std::ranges::count_if(grown.weight.pixels, [](float w) { return w > 15; });
    EXPECT_GT(size_t(remembering), grown.weight.pixels.size() / 2);
}

TEST_P(ReuseMethod, ASmallerPictureBeforeDoesNotMatter)
{
    begin("cornell-diffuse", {48, 40});
    const ReuseParams params = with(ReuseStrategy::ra, 2);
    const core::Camera camera = swung(*world_, 0);
    look(camera, params, core::Start::anew, 4);
    const core::Image expected = renderer_->read(core::Reading::mean).mean;
    renderer_ = app::makeRenderer("reuse", {.device = GetParam()});
    renderer_->setWorld(world_, {});
    size_ = {16, 12};
    look(camera, params, core::Start::anew, 3);
    size_ = {48, 40};
    look(camera, params, core::Start::anew, 4);
    EXPECT_EQ(renderer_->read(core::Reading::mean).mean.pixels, expected.pixels);
}

/// A camera that comes to rest goes on to the picture that path tracing makes, from what is there.
TEST_P(ReuseMethod, AStopGoesOnToThePlainPicture)
{
    begin("cornell-moderate", {32, 32});
    const core::Image truth = reference(1024).mean;
    const ReuseParams params = with(ReuseStrategy::ra, 8);
    fly(params, 12, 1);
    const core::Estimate moving = renderer_->read(core::Reading::everything);
    renderer_->advance({.samples = 240}, {});
    const core::Estimate still = renderer_->read(core::Reading::everything);
    EXPECT_EQ(still.samples, 241u);
    for (size_t i = 0; i < still.weight.pixels.size(); ++i)
        ASSERT_EQ(still.weight.pixels[i], moving.weight.pixels[i] + 240);
    EXPECT_LT(meanSquare(still.mean, truth), 0.3 * meanSquare(moving.mean, truth));
    EXPECT_NEAR(meanOf(still.mean), meanOf(truth), 0.02 * meanOf(truth));
}

TEST_P(ReuseMethod, ItIsWhatTheCpuFinds)
{
    struct Case {
        float rays;
        core::ReuseBias bias = core::ReuseBias::fast;
    };
    for (const auto [rays, bias] :
         {Case{1}, Case{0.3f}, Case{2.5f}, Case{1, core::ReuseBias::bounded},
          Case{1, core::ReuseBias::unbiased}}) {
        SCOPED_TRACE(std::string(core::enumName(bias)).append(", rays " + std::to_string(rays)));
        renderer_ = app::makeRenderer("reuse", {.device = GetParam()});
        begin("cornell-moderate", {40, 30});
        ReuseParams params = with(ReuseStrategy::ra, 12, rays);
        params.bias = bias;
        const core::Image here = fly(params, 14, 0.25).mean;
        renderer_ = app::makeRenderer("reuse", {.device = app::DeviceKind::cpu});
        renderer_->setWorld(world_, {});
        const core::Image there = fly(params, 14, 0.25).mean;
        // Rays that graze an edge may fall to either side of it.
        size_t off = 0;
        for (size_t i = 0; i < here.pixels.size(); ++i)
            off += std::abs(here.pixels[i] - there.pixels[i]) > 1e-3f * (there.pixels[i] + 0.01f);
        EXPECT_LT(off, here.pixels.size() / 50);
        EXPECT_NEAR(meanOf(here), meanOf(there), 1e-2 * meanOf(there));
    }
}

INSTANTIATE_TEST_SUITE_P(Device, ReuseMethod,
                         testing::Values(app::DeviceKind::cpu, app::DeviceKind::vulkan),
                         [](const auto& where) {
                             return std::string(core::enumName(where.param));
                         });

}  // namespace
