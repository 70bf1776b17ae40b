// Guided path tracing on every device: what the guide has learnt changes no mean, is kept when the
// camera moves and forgotten with the scene, and lowers the variance where light is hard to find.
#include <array>
#include <cmath>
#include <memory>

#include "tests/support/methods/guided_renders.h"
#include "tests/support/statistics/image_mean.h"
#include "tests/support/statistics/stats.h"

namespace {

using namespace tests;

using core::GuidedParams, core::GuidedRoulette;
using GuidedMethod = GuidedRenders;

/// Of the mean over all pixels, as if they were independent.
double varianceOfMean(const core::Estimate& e)
{
    double sum = 0;
    for (const float v : e.variance.pixels) sum += double(v);
    return sum / std::pow(double(e.variance.pixels.size()), 2);
}

double squaredDistance(const core::Image& a, const core::Image& b)
{
    double sum = 0;
    for (size_t i = 0; i < a.pixels.size(); ++i) {
        const double d = double(a.pixels[i]) - double(b.pixels[i]);
        sum += d * d;
    }
    return sum / double(a.pixels.size());
}

TEST_P(GuidedMethod, WithoutTrainingIsThePathTracerToTheBit)
{
    for (const char* scene : {"cbox-up", "textured-box", "glass"}) {
        begin(scene, {40, 30});
        const core::Estimate guided = render(GuidedParams{.training = 0}, 5);
        const core::Estimate expected = plain({}, 5);
        EXPECT_EQ(guided.mean.pixels, expected.mean.pixels) << scene;
        EXPECT_EQ(guided.variance.pixels, expected.variance.pixels) << scene;
    }
}

/// Independent pictures, each with a guide of its own that learns all the while: their mean is that
/// of the path tracer, whatever the surfaces, the roulette and the sampler.
TEST_P(GuidedMethod, TheMeanIsThePathTracers)
{
    constexpr uint32_t kPictures = 40, kSamples = 12;
    struct Case {
        const char* scene;
        GuidedRoulette roulette;
        core::SamplerKind sampler;
        core::GuideUse use = core::GuideUse::always;
    };
    for (const auto& [scene, roulette, sampler, use] :
         {Case{"cbox-up", GuidedRoulette::both, core::SamplerKind::independent},
          Case{"cbox-up", GuidedRoulette::light, core::SamplerKind::sobol},
          Case{"cbox-up", GuidedRoulette::both, core::SamplerKind::sobol, core::GuideUse::pays},
          Case{"cornell-glossy", GuidedRoulette::both, core::SamplerKind::sobol},
          Case{"glass", GuidedRoulette::both, core::SamplerKind::independent}}) {
        begin(scene, {24, 24});
        const core::PathParams path{.seed = 991, .sampler = core::SamplerKind::independent};
        const core::Estimate truth = plain(path, 4096);
        const double noise = varianceOfMean(truth);
        tests::Moments means;
        for (uint32_t seed = 1; seed <= kPictures; ++seed) {
            const core::Estimate e = render({.use = core::GuideUse::always,
                                             .gate = 1,
                                             .roulette = roulette,
                                             .seed = seed,
                                             .sampler = sampler},
                                            kSamples);
            EXPECT_TRUE(e.counters.clean());
            means.add(meanOf(e.mean));
        }
        EXPECT_GT(detail("guided_share"), 0.2) << scene << ": nothing was guided";
        const double expected = meanOf(truth.mean);
        // Channels of a pixel go together: their variances add up to at most three times as much.
        const double error = std::sqrt(means.varianceOfMean() + 3 * noise);
        EXPECT_LT(std::abs(means.mean() - expected), tests::kScore * error) << scene;
        EXPECT_LT(error, 0.008 * expected) << scene << " is underpowered";
    }
}

/// Presets as their papers have them and every switch, alone or with what it goes with: other
/// variances, the same mean.
TEST_P(GuidedMethod, SwitchesKeepTheMean)
{
    using namespace core;
    constexpr uint32_t kPictures = 40, kSamples = 31;
    struct Case {
        const char* name;
        GuidedParams params;
        double power;  // relative standard error that is wanted
    };
    const auto preset = [](std::string_view name) {
        for (const MethodPreset& p : methodNamed("guided").presets)
            if (p.name == name) {
                GuidedParams params = p.params.as<GuidedParams>();
                params.training = 15;
                params.recordsPerLeaf /= 8;  // of so few pixels
                return params;
            }
        ADD_FAILURE() << name;
        return GuidedParams{};
    };
    const GuidedParams doubling{.guide = GuideKind::tree,
                                .use = GuideUse::always,
                                .schedule = GuideSchedule::doubling,
                                .training = 15,
                                .recordOneIn = 1,
                                .recordsPerLeaf = 250,
                                .share = 0.5f,
                                .combine = Combine::samples};
    const auto with = [&doubling](auto change) {
        GuidedParams params = doubling;
        change(params);
        return params;
    };
    const Case cases[] = {
        {"ppg", preset("ppg"), 0.04},
        {"ppg-production", preset("ppg-production"), 0.01},
        {"balance", with([](auto& p) { p.memory = GuideMemory::balance; }), 0.008},
        {"residual", with([](auto& p) { p.memory = GuideMemory::residual; }), 0.008},
        {"second-moment", with([](auto& p) { p.target = GuideTarget::secondMoment; }), 0.008},
        {"mixture", with([](auto& p) { p.nee = GuidedNee::mixture; }), 0.008},
        {"last", with([](auto& p) { p.combineLast = 1; }), 0.008},
        {"inverse-variance", with([](auto& p) { p.combine = Combine::inverseVariance; }), 0.008},
        {"crossed", with([](auto& p) {
             p.combine = Combine::inverseVariance;
             p.combineOver = CombineOver::pixel;
             p.combineFrom = CombineFrom::crossed;
         }),
         0.012},
    };
    begin("cbox-up", {24, 24});
    const Estimate truth = plain({.seed = 991, .sampler = SamplerKind::independent}, 8192);
    const double expected = meanOf(truth.mean), noise = varianceOfMean(truth);
    for (const auto& [name, params, power] : cases) {
        tests::Moments means;
        double told = 0;  // by the estimate itself, of the mean over the picture
        for (uint32_t seed = 1; seed <= kPictures; ++seed) {
            GuidedParams own = params;
            own.seed = seed;
            own.sampler = SamplerKind::independent;
            const Estimate e = render(own, kSamples);
            EXPECT_TRUE(e.counters.clean());
            means.add(meanOf(e.mean));
            told += varianceOfMean(e) / kPictures;
        }
        EXPECT_GT(detail("guided_share"), 0.2) << name << ": nothing was guided";
        const double error = std::sqrt(means.varianceOfMean() + 3 * noise);
        EXPECT_LT(std::abs(means.mean() - expected), tests::kScore * error) << name;
        EXPECT_LT(error, power * expected) << name << " is underpowered";
        // Of one picture: channels of a pixel go together, hence up to three times as much. The
        // factor of two is for forty pictures, whose brightest decide.
        const double found = means.varianceOfMean() * kPictures;
        EXPECT_GT(found, told / 2) << name;
        EXPECT_LT(found, 2 * 3 * told) << name;
    }
}

/// Few pixels: in larger pictures, where there is more to learn from, it is a sixth.
TEST_P(GuidedMethod, IndirectLightHasHalfOfTheVariance)
{
    begin("cbox-up", {64, 64});
    const core::Estimate truth = render({.seed = 77}, 1024);
    const double plainError = squaredDistance(plain({.seed = 3}, 32).mean, truth.mean);
    const double guidedError = squaredDistance(render({.seed = 3}, 32).mean, truth.mean);
    EXPECT_LT(guidedError, plainError / 2);
    EXPECT_GT(detail("guided_share"), 0.7);
    EXPECT_GT(detail("guide_leaves"), 20);
}

TEST_P(GuidedMethod, TheGuideOutlivesAMoveButNotTheScene)
{
    begin("cbox-up", {96, 96});
    const core::Image truth = render({.use = core::GuideUse::always, .seed = 77}, 512).mean;
    render({.seed = 5}, 16);
    EXPECT_EQ(guiding(), "pays");
    const double leaves = detail("guide_leaves");
    const auto errorOfFirst = [&](core::Start start) {
        return squaredDistance(render({.seed = 5}, 1, start).mean, truth);
    };
    const double kept = errorOfFirst(core::Start::moved);
    EXPECT_GE(detail("guide_leaves"), leaves);
    const core::Image again = render({.seed = 5}, 3, core::Start::anew).mean;
    EXPECT_LT(detail("guide_leaves"), leaves);
    const double fresh = errorOfFirst(core::Start::anew);
    EXPECT_LT(kept, fresh / 2);

    guided_->setWorld(world_, {});
    const core::Image afterwards = render({.seed = 5}, 3, core::Start::moved).mean;
    EXPECT_EQ(afterwards.pixels, again.pixels) << "the guide of before is still there";
}

/// While the camera moves, views have one sample each, and nothing is known of a pixel when its
/// path begins. The guide is tried and followed all the same, and it is what roulette asks.
TEST_P(GuidedMethod, LearnsInAFlightOfSingleSamples)
{
    begin("cbox-up", {64, 64});
    const core::Image truth = render({.use = core::GuideUse::always, .seed = 77}, 1024).mean;
    core::Image last = render({.seed = 5}, 1).mean;
    for (int frame = 1; frame < 32; ++frame) last = render({.seed = 5}, 1, core::Start::moved).mean;
    EXPECT_EQ(guiding(), "pays");
    const double plainError = squaredDistance(plain({.seed = 5}, 1).mean, truth);
    EXPECT_LT(squaredDistance(last, truth), plainError / 2.5);  // measured: 3.0 and 3.2
}

/// In the first sample of a view roulette has nothing to compare with but what the guide knows of
/// the surface that a pixel shows: more paths live than by their throughput, and no mean changes.
TEST_P(GuidedMethod, TheGuideKnowsWhatAPixelIsWorth)
{
    constexpr uint32_t kFlights = 100, kViews = 6;
    begin("cbox-up", {24, 24});
    const core::PathParams path{.seed = 991, .sampler = core::SamplerKind::independent};
    const core::Estimate truth = plain(path, 4096);
    tests::Moments means;
    std::array<uint64_t, 2> rays{};  // of the last views, by throughput and by both
    for (uint32_t seed = 1; seed <= kFlights; ++seed)
        for (const auto roulette : {GuidedRoulette::albedo, GuidedRoulette::both}) {
            const bool both = roulette == GuidedRoulette::both;
            if (!both && seed > 4) continue;
            const GuidedParams params{.use = core::GuideUse::always,
                                      .gate = 1,
                                      .roulette = roulette,
                                      .seed = seed,
                                      .sampler = core::SamplerKind::independent};
            for (uint32_t k = 0; k + 1 < kViews; ++k)
                render(params, 1, k == 0 ? core::Start::anew : core::Start::moved);
            const core::Estimate last = render(params, 1, core::Start::moved);
            if (seed <= 4) rays[both] += guided_->stats().rays;
            if (both) means.add(meanOf(last.mean));
        }
    EXPECT_GT(rays[1], rays[0] + rays[0] / 50);
    const double expected = meanOf(truth.mean);
    const double error = std::sqrt(means.varianceOfMean() + 3 * varianceOfMean(truth));
    EXPECT_LT(std::abs(means.mean() - expected), tests::kScore * error);
    EXPECT_LT(error, 0.02 * expected) << "underpowered";
}

/// The lamp of cbox-up shines at the ceiling: seen from the floor, light comes from there, not from
/// the sides.
TEST_P(GuidedMethod, ShowsWhichDirectionsItKnowsAtAPlace)
{
    begin("cbox-up", {48, 48});
    render({.seed = 5}, 16);
    const auto probe = guided_->probe();
    ASSERT_NE(probe, nullptr);
    EXPECT_FALSE(probe->at({48, 0}));
    const auto place = probe->at({24, 46});
    ASSERT_TRUE(place);
    EXPECT_NE(place->caption.find("% of the directions"), std::string::npos) << place->caption;
    const core::Image& image = place->image;
    // A pixel of the disk stands for its area over the cosine.
    double all = 0, upwards = 0;
    for (uint32_t y = 0; y < image.height; ++y) {
        for (uint32_t x = 0; x < image.width; ++x) {
            const double px = (x + 0.5) * 2 / image.width - 1,
                         py = (y + 0.5) * 2 / image.height - 1;
            const double cosine = std::sqrt(std::max(1 - px * px - py * py, 0.0));
            const double value = double(*image.at(x, y));
            EXPECT_EQ(value<0, px * px + py * py> 1);
            if (!(cosine > 0)) continue;
            const double mass = value * 4 / (image.width * image.height * cosine);
            all += mass;
            if (cosine > 0.5) upwards += mass;
        }
    }
    EXPECT_LT(all, 1.15);
    EXPECT_GT(all, 0.8);
    EXPECT_GT(upwards, 0.6 * all);
    render({.training = 0}, 1);
    EXPECT_EQ(guided_->probe(), nullptr);
}

TEST_P(GuidedMethod, TrainingEndsWhereItIsToldTo)
{
    begin("cbox-up", {32, 32});
    render({.use = core::GuideUse::always, .training = 4, .seed = 2}, 4);
    const double records = detail("guide_records");
    EXPECT_GT(records, 0);
    guided_->advance({.samples = 8}, {});
    EXPECT_EQ(detail("guide_records"), records);
    render({.use = core::GuideUse::always, .training = 4, .recordOneIn = 4, .seed = 2}, 4);
    EXPECT_NEAR(detail("guide_records") / records, 0.25, 0.05);
}

INSTANTIATE_TEST_SUITE_P(Devices, GuidedMethod,
                         testing::Values(app::DeviceKind::cpu, app::DeviceKind::vulkan),
                         [](const testing::TestParamInfo<app::DeviceKind>& where) {
                             return std::string(core::enumName(where.param));
                         });

}  // namespace
