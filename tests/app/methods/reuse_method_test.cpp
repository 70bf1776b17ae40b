// Path tracing that keeps its samples, on a camera that moves, on every device: the noise goes, and
// where nothing can be kept the picture is that of path tracing. What is left of bias is the
// subject of reuse_bias_test.cpp.
#include <algorithm>
#include <cmath>

#include "tests/support/methods/reuse_flights.h"
#include "tests/support/scenes/test_scenes.h"
#include "tests/support/statistics/compare_films.h"
#include "tests/support/statistics/stats.h"

namespace {

using namespace tests;

class ReuseMethod : public ReuseFlights {};

double meanSquare(const core::Image& a, const core::Image& b)
{
    double sum = 0;
    for (size_t i = 0; i < a.pixels.size(); ++i)
        sum += std::pow(double(a.pixels[i]) - double(b.pixels[i]), 2);
    return sum / double(a.pixels.size());
}

TEST_P(ReuseMethod, WithoutHistoryItIsPathTracing)
{
    begin("cornell-moderate", {40, 40});
    ReuseParams params = with(ReuseStrategy::discard, 5);
    params.jitter = PixelJitter::always;
    params.cap = 1024;  // or plain paths would go on by and by
    look(world_->cameras.at(0), params, core::Start::anew, 128);
    const core::Estimate reused = renderer_->read(core::Reading::everything);
    core::PathParams path;
    path.seed = 6;
    path.sampler = core::SamplerKind::independent;
    core::Renderer& tracer = sharedRenderer("path", GetParam());
    tracer.setWorld(world_, {});
    tracer.setView({world_->cameras.at(0), size_, path}, core::Start::anew);
    tracer.advance({.samples = 128}, {});
    const tests::FilmComparison c =
        tests::compareFilms(reused, tracer.read(core::Reading::everything));
    EXPECT_TRUE(c.agree()) << c.describe();
}

/// Mirrors and glass are looked through: the picture is that of path tracing, and what is seen
/// there keeps its samples.
TEST_P(ReuseMethod, MirrorsAndGlassAreLookedThrough)
{
    begin("glass", {48, 36});
    ReuseParams plain = with(ReuseStrategy::discard, 7);
    plain.jitter = PixelJitter::always;
    plain.cap = 1024;
    look(world_->cameras.at(0), plain, core::Start::anew, 256);
    const core::Estimate here = renderer_->read(core::Reading::everything);
    core::Renderer& tracer = sharedRenderer("path", GetParam());
    tracer.setWorld(world_, {});
    core::PathParams path;
    path.seed = 8;
    path.sampler = core::SamplerKind::independent;
    tracer.setView({world_->cameras.at(0), size_, path}, core::Start::anew);
    tracer.advance({.samples = 256}, {});
    const tests::FilmComparison c =
        tests::compareFilms(here, tracer.read(core::Reading::everything));
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

/// T-33. At rest two samples and one connection do as well as a store that holds all of them: what
/// does not fit is handed on as light, and the pictures are the same. Dropped it is noise.
TEST_P(ReuseMethod, AFewSamplesDoAsWellAsAllThatTheyStandFor)
{
    constexpr uint32_t kFrames = 16;
    begin("cornell-diffuse", {24, 24});
    const core::Image truth = reference(4096).mean;
    for (const ReuseStrategy strategy :
         {ReuseStrategy::ra, ReuseStrategy::mis, ReuseStrategy::reweighting}) {
        const auto picture = [&](uint32_t records, uint32_t lights,
                                 core::ReuseRemainder remainder) {
            ReuseParams params = with(strategy, 70);
            params.records = records;
            params.lights = lights;
            params.remainder = remainder;
            const core::Estimate e = fly(params, kFrames, 0);
            EXPECT_TRUE(e.counters.clean());
            return e.mean;
        };
        const core::Image all = picture(16, 16, core::ReuseRemainder::drop);
        const core::Image few = picture(2, 1, core::ReuseRemainder::keep);
        const core::Image dropped = picture(2, 1, core::ReuseRemainder::drop);
        const double noise = meanSquare(all, truth);
        EXPECT_LT(meanSquare(few, all), 3e-3 * noise) << core::enumName(strategy);
        EXPECT_GT(meanSquare(dropped, truth), 1.5 * noise) << core::enumName(strategy);
    }
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

/// New paths are told per pixel that had some, while a pass is under way, too.
TEST_P(ReuseMethod, NewPathsAreThoseOfThePixelsThatHadThem)
{
    begin("cornell-diffuse", {256, 192});
    renderer_->setView({swung(*world_, 0), size_, with(ReuseStrategy::ra, 4)}, core::Start::anew);
    renderer_->advance({.samples = 1, .seconds = 0}, {});
    ASSERT_GT(renderer_->progress().fraction, 0);
    ASSERT_LT(renderer_->progress().fraction, 0.9);
    EXPECT_NEAR(detail("n"), 1, 0.05);
    renderer_->advance({.samples = 1}, {});
    ASSERT_EQ(renderer_->progress().fraction, 0);
    EXPECT_NEAR(detail("n"), 1, 0.05);
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
    EXPECT_EQ(largestWeight(), 2) << "the same world in the same pose";
    renderer_->setWorld(asset("cornell-glossy"), {});
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
    const std::vector<core::Image> maps = renderer_->maps();
    look(swung(*world_, 0), with(ReuseStrategy::discard, 6), core::Start::anew);
    const core::Image discarded = renderer_->read(core::Reading::mean).mean;
    EXPECT_LT(meanSquare(grown.mean, truth), 0.3 * meanSquare(discarded, truth));
    EXPECT_NEAR(meanOf(grown.mean), meanOf(truth), 0.05 * meanOf(truth));
    const core::Image history = maps.at(0);  // N; the picture counts as less (weightAtRest)
    const auto remembering = std::ranges::count_if(history.pixels, [](float N) { return N > 15; });
    EXPECT_GT(size_t(remembering), history.pixels.size() / 2);
}

TEST_P(ReuseMethod, ASmallerPictureBeforeDoesNotMatter)
{
    begin("cornell-diffuse", {48, 40});
    const ReuseParams params = with(ReuseStrategy::ra, 2);
    const core::Camera camera = swung(*world_, 0);
    look(camera, params, core::Start::anew, 4);
    const core::Image expected = renderer_->read(core::Reading::mean).mean;
    const auto fresh = app::makeRenderer("reuse", {.device = GetParam()});
    renderer_ = fresh.get();
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
        renderer_ = &sharedRenderer("reuse", GetParam());
        begin("cornell-moderate", {40, 30});
        ReuseParams params = with(ReuseStrategy::ra, 12, rays);
        params.bias = bias;
        const core::Image here = fly(params, 14, 0.25).mean;
        renderer_ = &sharedRenderer("reuse", app::DeviceKind::cpu);
        renderer_->setWorld(world_, {});
        const core::Image there = fly(params, 14, 0.25).mean;
        // Rays that graze an edge may fall to either side of it, and places that slide are rounded
        // anew in every view: two per cent of the values.
        size_t off = 0;
        for (size_t i = 0; i < here.pixels.size(); ++i)
            off += std::abs(here.pixels[i] - there.pixels[i]) > 1e-3f * (there.pixels[i] + 0.01f);
        EXPECT_LT(off, here.pixels.size() / 40);
        EXPECT_NEAR(meanOf(here), meanOf(there), 1e-2 * meanOf(there));
    }
}

/// Where means are kept, too, and pixels take turns.
TEST_P(ReuseMethod, MapsAreThoseOfTheCpu)
{
    begin("cornell-moderate", {40, 30});
    for (const ReuseStrategy strategy :
         {ReuseStrategy::ra, ReuseStrategy::naive, ReuseStrategy::svgf}) {
        SCOPED_TRACE(core::enumName(strategy));
        const auto mapsOf = [&](app::DeviceKind device) {
            renderer_ = &sharedRenderer("reuse", device);
            renderer_->setWorld(world_, {});
            fly(with(strategy, 12, 0.25f), 14, 0.25);
            return renderer_->maps();
        };
        const std::vector<core::Image> here = mapsOf(GetParam()),
                                       there = mapsOf(app::DeviceKind::cpu);
        ASSERT_EQ(here.size(), there.size());
        for (size_t map = 0; map < here.size(); ++map) {
            size_t off = 0;
            for (size_t i = 0; i < here[map].pixels.size(); ++i) {
                const float a = here[map].pixels[i], b = there[map].pixels[i];
                off += std::abs(a - b) > 2e-4f * std::max(1.0f, b);
            }
            EXPECT_LT(off, here[map].pixels.size() / 40) << core::reuseMaps()[map].name;
        }
    }
}

/// A lamp so bright that some of what it brings is more than a float holds: such samples are
/// dropped from one picture, and are in no mean that the next ones go on with.
TEST_P(ReuseMethod, SamplesThatAreNoNumbersAreForgotten)
{
    SceneBuilder b;
    b.quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, b.material(lambert(glm::vec3(1))));
    b.quad({-0.1f, 0.05f, -0.1f}, {0.2f, 0, 0}, {0, 0, 0.2f},
           b.material(emitter(glm::vec3(3.3e38f))));
    b.camera({0, 0.04, 0.4}, {0, 0, 0}, 0.3);
    world_ = b.world();
    size_ = {32, 24};
    renderer_->setWorld(world_, {});
    for (const ReuseStrategy strategy : {ReuseStrategy::naive, ReuseStrategy::svgf}) {
        uint64_t dropped[10];
        for (uint64_t& count : dropped) {
            look(world_->cameras.at(0), with(strategy, 3),
                 &count == dropped ? core::Start::anew : core::Start::moved);
            const core::Estimate e = renderer_->read(core::Reading::everything);
            count = e.counters.nan + e.counters.inf;
        }
        EXPECT_GT(dropped[0], 20u) << core::enumName(strategy);
        EXPECT_LT(double(dropped[9]), 1.5 * double(dropped[0])) << core::enumName(strategy);
    }
}

INSTANTIATE_TEST_SUITE_P(Device, ReuseMethod,
                         testing::Values(app::DeviceKind::cpu, app::DeviceKind::vulkan),
                         DeviceName());

}  // namespace
