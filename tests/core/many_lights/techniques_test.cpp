// M16, M17, M18, M20. Techniques of lighting a frame against the sum over all lights: exact
// where they are to be, unbiased where they say so, within their error where they have one.
#include "core/many_lights/technique.h"

#include <gtest/gtest.h>

#include <thread>

#include "core/many_lights/illumination_cut.h"
#include "core/many_lights/light_slice.h"
#include "core/many_lights/mat_sep.h"
#include "core/methods/method.h"
#include "tests/support/methods/light_stage.h"
#include "tests/support/scenes/asset.h"
#include "tests/support/scenes/test_scenes.h"
#include "tests/support/statistics/stats.h"

namespace core::many_lights {
namespace {

using namespace tests;
using glm::vec3;

constexpr std::array kAll{Technique::clusters,  Technique::lightslice,      Technique::rowColumn,
                          Technique::lightcuts, Technique::illuminationCut, Technique::matSep};

/// Of the sum of all pixels, what the sum of the differences is.
double difference(const core::Image& a, const core::Image& b)
{
    double sum = 0, total = 0;
    for (size_t i = 0; i < a.pixels.size(); ++i) {
        sum += std::abs(double(a.pixels[i]) - double(b.pixels[i]));
        total += double(b.pixels[i]);
    }
    return sum / total;
}

/// As many clusters as lights, or no error allowed.
TEST(Techniques, AreThePlainSumWhereNothingIsLeftToApproximate)
{
    for (const char* name : {"cornell-diffuse", "cornell-glossy", "sky", "lights"}) {
        const LightStage stage(asset(name), 20, 400);
        const core::Image all = stage.all();
        for (const Technique technique : kAll) {
            if (technique == Technique::matSep) continue;  // keeps no more than a low rank
            FrameStats stats;
            const core::Image found = stage.image(technique, 1u << 30, 0, 1, &stats);
            EXPECT_LT(difference(found, all), 2e-5) << name << ", " << core::enumName(technique);
            EXPECT_GT(stats.slices.completion.rays, 0u);
        }
    }
}

/// Means over seeds of the drawing, by pixel and channel and of the whole picture, in the worst
/// pixel's standard errors; `uncertainty` gets the largest of the picture's mean, relative.
double largestScore(const LightStage& stage, Technique technique, uint32_t clusters, uint32_t seeds,
                    double& uncertainty)
{
    const core::Image exact = stage.all();
    std::vector<Moments> pixels(exact.pixels.size());
    std::array<Moments, 3> sums;
    std::array<double, 3> exactSums{};
    for (size_t i = 0; i < exact.pixels.size(); ++i) exactSums[i % 3] += double(exact.pixels[i]);
    for (uint32_t seed = 0; seed < seeds; ++seed) {
        const core::Image image = stage.image(technique, clusters, 0, 1 + seed);
        std::array<double, 3> sum{};
        for (size_t i = 0; i < pixels.size(); ++i) {
            pixels[i].add(double(image.pixels[i]));
            sum[i % 3] += double(image.pixels[i]);
        }
        for (size_t c = 0; c < 3; ++c) sums[c].add(sum[c]);
    }
    double largest = 0;
    for (size_t i = 0; i < pixels.size(); ++i) {
        const double error =
            std::sqrt(pixels[i].varianceOfMean()) + 1e-5 * exactSums[i % 3] / double(pixels.size());
        largest = std::max(largest, std::abs(pixels[i].mean() - double(exact.pixels[i])) / error);
    }
    for (size_t c = 0; c < 3; ++c) {
        const double error = std::sqrt(sums[c].varianceOfMean());
        largest = std::max(largest, std::abs(sums[c].mean() - exactSums[c]) / error);
        uncertainty = std::max(uncertainty, error / exactSums[c]);
    }
    return largest;
}

/// Lights that no sampled point sees included.
TEST(Techniques, WeightsOfRepresentativesAreUnbiased)
{
    const LightStage stage(asset("cornell-diffuse"), 12, 250);
    for (const Technique technique : {Technique::lightslice, Technique::rowColumn}) {
        double uncertainty = 0;
        // One score of 435 is expected beyond 3; all are correlated. A pixel that few
        // representatives reach brightly has no normal distribution yet with a quarter of the seeds
        // (6.6).
        EXPECT_LT(largestScore(stage, technique, 40, 3200, uncertainty), 4.5)
            << core::enumName(technique);
        EXPECT_LT(uncertainty, 0.002) << core::enumName(technique) << " is underpowered";
    }
}

/// The camera looks into the middle of a square box: edges of its walls lie on the diagonals of the
/// picture, and so under the middles of pixels.
TEST(Techniques, PointsOnTheEdgesOfWallsSeeLight)
{
    const LightStage stage(asset("cornell-diffuse"), 128, 300);
    const core::Image image = stage.all();
    const auto at = [&](uint32_t x, uint32_t y) { return double(image.at(x, y)[1]); };
    uint32_t edges = 0;
    for (uint32_t i = 2; i < 20; ++i) {
        for (const uint32_t x : {i, 127 - i}) {
            for (const uint32_t y : {i, 127 - i}) {
                const double beside = std::min(at(x - 1, y), at(x + 1, y));
                EXPECT_GT(at(x, y), 0.2 * beside) << x << ", " << y;
                edges += beside > 0 ? 1 : 0;
            }
        }
    }
    EXPECT_EQ(edges, 72u);
}

/// What covers a lamp closely is met on the way to its lights, however far that is.
TEST(Techniques, ACoverCloseToALampIsSeen)
{
    for (const auto& [distance, gap] : {std::pair(20.0f, 0.0015f), std::pair(60.0f, 0.003f)}) {
        SceneBuilder b;
        b.quad({-3, 0, 3}, {6, 0, 0}, {0, 0, -6}, b.material(lambert(vec3(0.6f))));
        b.quad({-1, distance, -1}, {2, 0, 0}, {0, 0, 2}, b.material(emitter(vec3(10))));
        b.quad({-1.1f, distance - gap, -1.1f}, {2.2f, 0, 0}, {0, 0, 2.2f},
               b.material(lambert(vec3(0))));
        b.camera({0.3, 0.5, 0.4}, {0, 0, 0}, 0.002);
        const auto world = b.world();
        for (const Technique technique : kAll) {
            const core::ManyLightsParams params{
                .lights = 200, .technique = technique, .clusters = 50, .maxDepth = 1};
            EXPECT_EQ(estimate(render(world, 8, 8, 2, params)).mean, 0)
                << core::enumName(technique) << ", " << distance;
        }
    }
}

/// What the points of a few neighbours see says little of corners: there the error did not fall.
TEST(LightSlice, ErrsLessWithMoreClusters)
{
    LightStage stage(asset("cornell-diffuse"), 96, 1200);
    stage.settings.clamp = 0.1f;
    stage.settings.sliceSize = 60;
    const core::Image exact = stage.all();
    const auto error = [&](uint32_t clusters) {
        double sum = 0;
        for (uint32_t seed = 1; seed <= 4; ++seed) {
            const core::Image image = stage.image(Technique::lightslice, clusters, 0, seed);
            for (size_t i = 0; i < image.pixels.size(); ++i) {
                const double d =
                    std::min(double(image.pixels[i]), 1.0) - std::min(double(exact.pixels[i]), 1.0);
                sum += d * d;
            }
        }
        return std::sqrt(sum);
    };
    const double few = error(100);
    EXPECT_LT(error(400), 0.5 * few);
    EXPECT_LT(error(800), 0.25 * few);
}

/// Slices of many lights take long to cluster, which a stop does not wait for.
TEST(LightSlice, GivesUpASliceThatAStopFinds)
{
    LightStage stage(asset("cornell-diffuse"), 32, 150000);
    stage.settings.sliceSize = 300;
    StageRows r(stage);
    const auto points = makeFrameReceivers(stage.accel, stage.settings, 0, {});
    const TechniqueInput input{
        r.job, stage.lights->tree, points->receivers, points->slices, points->slicing, 2000, 0};
    uint64_t rays = 0;
    const auto columns = LightSlice::make(input, {}, rays);
    CutMemory memory;
    std::vector<LightCluster> chosen;
    const auto seconds = [&](const std::stop_token& stop) {
        const core::Clock::time_point start = core::Clock::now();
        columns->choose(r.rows, 0, memory, chosen, stop);
        return core::secondsSince(start);
    };
    seconds({});  // takes memory, which is kept
    const double whole = seconds({});
    EXPECT_GT(chosen.size(), 1000u);
    std::stop_source stop;
    stop.request_stop();
    EXPECT_LT(seconds(stop.get_token()), 0.3 * whole);
    EXPECT_TRUE(chosen.empty());
}

/// Of a matrix for 4 million lights and as many slices as points the machine is to hear nothing.
TEST(LightSlice, SaysWhatItsMatrixNeedsBeforeItTakesIt)
{
    LightStage stage(asset("cornell-diffuse"), 32, 400);
    StageRows r(stage);
    LightSet many;
    many.lights.resize(4'000'000);
    r.job.lights = &many;
    Slices slices;
    slices.order = r.chosen;
    slices.ranges.resize(1u << 20);
    const SliceSettings slicing;
    const TechniqueInput input{r.job, stage.lights->tree, r.receivers, slices, slicing, 1000, 0};
    uint64_t rays = 0;
    try {
        LightSlice::make(input, {}, rays);
        ADD_FAILURE() << "began a matrix of 16 TiB";
    } catch (const core::Error& error) {
        EXPECT_EQ(error.code(), core::ExitCode::commandLine);
        EXPECT_NE(std::string(error.what()).find("1048576 slices"), std::string::npos)
            << error.what();
        EXPECT_NE(std::string(error.what()).find("--slice-size"), std::string::npos)
            << error.what();
    }
}

/// With nothing in between, the error of the picture is that of the clusters, which is bounded.
TEST(Techniques, ErrorsFollowWhatIsAllowed)
{
    const LightStage stage(asset("cornell-diffuse"), 24, 1500);
    const core::Image all = stage.all();
    for (const Technique technique : {Technique::lightcuts, Technique::illuminationCut}) {
        double last = 1;
        uint64_t entries = 0;
        for (const float error : {0.1f, 0.02f, 0.004f}) {
            FrameStats stats;
            const double found =
                difference(stage.image(technique, 1u << 30, error, 1, &stats), all);
            EXPECT_LT(found, 2 * double(error)) << core::enumName(technique);
            EXPECT_LT(found, last) << core::enumName(technique);
            EXPECT_GT(stats.slices.completion.entries, entries);
            last = found;
            entries = stats.slices.completion.entries;
        }
    }
}

/// In an empty room all that is guessed of visibility is right: as exact as when all is traced, for
/// a part of the rays.
TEST(IlluminationCut, IsExactForFewRaysWhereAllIsVisible)
{
    SceneBuilder b;
    const int walls = b.material(lambert(vec3(0.6f, 0.5f, 0.4f)));
    b.box({-1, -1, -1}, {1, 1, 1}, walls, true);
    b.quad({-0.3f, 0.99f, -0.3f}, {0.6f, 0, 0}, {0, 0, 0.6f}, b.material(emitter(vec3(9))));
    b.camera({0, 0, 0.9}, {0, 0, -1}, 1.2);
    LightStage stage(b.world(), 48, 1500);
    stage.settings.sliceSize = 1000;
    FrameStats stats;
    const core::Image found = stage.image(Technique::illuminationCut, 0, 0.05f, 1, &stats);
    EXPECT_LT(stats.slices.completion.visibility(), 0.7);
    EXPECT_LT(difference(found, stage.all()), 0.03);
}

/// A closed room whose lamp is above its ceiling: no point sees any of the lights up there, and no
/// error is small beside nothing.
TEST(IlluminationCut, AsksForFewRaysWhereAllIsDark)
{
    SceneBuilder b;
    const int walls = b.material(lambert(vec3(0.6f, 0.5f, 0.4f)));
    b.box({-1, -1, -1}, {1, 1, 1}, walls, true);
    b.quad({-2, 1.2f, 2}, {4, 0, 0}, {0, 0, -4}, walls);
    b.quad({-0.3f, 2.9f, -0.3f}, {0.6f, 0, 0}, {0, 0, 0.6f}, b.material(emitter(vec3(9))));
    b.camera({0, 0, 0.9}, {0, 0, -1}, 1.2);
    LightStage stage(b.world(), 48, 3000);
    stage.settings.sliceSize = 1000;
    FrameStats stats;
    const core::Image found = stage.image(Technique::illuminationCut, 0, 0.05f, 1, &stats);
    for (const float value : found.pixels) EXPECT_EQ(value, 0);
    const double all = double(stats.slices.rows) * double(stats.lights);
    EXPECT_LT(double(stats.slices.completion.rays), 0.1 * all);
}

/// With all rows traced it is the sum over the same clusters, but for what the separation takes.
TEST(MatSep, IsThePlainSumWhereAllIsTraced)
{
    const LightStage stage(asset("cornell-diffuse"), 16, 600);
    StageRows r(stage);
    const auto cut = [&] {
        return std::make_unique<TreeCut>(stage.lights->tree, r.job.gather, 150);
    };
    const auto columns = cut();
    r.job.columns = columns.get();
    r.job.compensates = false;
    r.job.completion = stage.settings.completion;
    SliceWorker worker;
    ASSERT_TRUE(worker.run(r.job, r.receivers, r.chosen, 0, {}));
    MatSepSettings settings;
    settings.prediction.rate = 1;
    for (const bool separates : {false, true}) {
        settings.separates = separates;
        std::vector<vec3> radiance(r.chosen.size());
        SliceStats stats;
        ASSERT_TRUE(
            MatSep(cut(), settings).light(r.job, r.receivers, r.chosen, 0, {}, radiance, stats));
        EXPECT_EQ(stats.completion.rays, worker.stats().completion.rays);
        EXPECT_EQ(stats.clusters, 150u);
        double squares = 0, all = 0;
        for (size_t i = 0; i < radiance.size(); ++i) {
            const vec3 error = radiance[i] - worker.radiance()[i];
            squares += double(glm::dot(error, error));
            all += double(glm::dot(worker.radiance()[i], worker.radiance()[i]));
        }
        EXPECT_LT(std::sqrt(squares / all), separates ? 0.05 : 1e-6);
        EXPECT_GE(std::sqrt(squares / all), separates ? 1e-5 : 0);
    }
}

/// Clusters that are all traced, and all lights, are the references; part of the rays is traced.
TEST(MatSep, LightsAPictureForAPartOfTheRays)
{
    LightStage stage(asset("cornell-diffuse"), 24, 1000);
    stage.settings.sliceSize = 300;
    FrameStats full, found;
    const core::Image all = stage.all();
    const double clusters = difference(stage.image(Technique::clusters, 100, 0, 1, &full), all);
    const double error = difference(stage.image(Technique::matSep, 100, 0.02f, 1, &found), all);
    EXPECT_LT(error, clusters + 0.05);
    const CompletionStats& stats = found.slices.completion;
    EXPECT_EQ(stats.entries, full.slices.completion.entries);
    EXPECT_EQ(stats.active, full.slices.completion.active);
    EXPECT_LT(stats.rays, stats.active / 2);
    EXPECT_GT(stats.matched, 0u);
}

TEST(Techniques, DoNotDependOnThreads)
{
    const LightStage stage(asset("cornell-rough"), 32, 800);
    for (const Technique technique : kAll) {
        const core::Image many = stage.image(technique, 60, 0.05f);
        const core::ThreadLimit one(1);
        EXPECT_EQ(stage.image(technique, 60, 0.05f).pixels, many.pixels)
            << core::enumName(technique);
    }
}

/// Through the method: first samples near each other, and completion where there are columns.
TEST(Techniques, LightPicturesOfTheMethod)
{
    const auto world = asset("cornell-moderate");
    const auto renderer = core::makeRenderer("manylights");
    renderer->setWorld(world, {});
    core::ManyLightsParams params{.lights = 2000, .clusters = 2000, .clamp = 0.5f};
    const auto picture = [&] {
        renderer->setView({world->cameras.at(0), {40, 40}, params}, core::Start::anew);
        renderer->advance({.samples = 1}, {});
        EXPECT_EQ(renderer->progress().samples, 1u);
        return renderer->read(core::Reading::mean).mean;
    };
    params.clusters = 200000;
    const core::Image all = picture();
    params.clusters = 300;
    for (const Technique technique : kAll) {
        params.technique = technique;
        params.completion.method = CompletionMethod::full;
        const double full = difference(picture(), all);
        EXPECT_LT(full, 0.25) << core::enumName(technique);
        if (!choosesColumns(technique)) continue;
        params.completion.method = CompletionMethod::matching;
        EXPECT_LT(difference(picture(), all), 1.2 * full) << core::enumName(technique);
    }
}

/// Nothing is lit, and nothing is seen.
TEST(Techniques, EmptyPicturesAndDarkScenesAreNoTrouble)
{
    SceneBuilder dark;
    dark.box({-1, -1, -1}, {1, 1, 1}, dark.material(lambert(vec3(0.5f))), true);
    dark.camera({0, 0, 0.9}, {0, 0, -1}, 1.2);
    SceneBuilder away;
    away.quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, away.material(emitter(vec3(1), vec3(0.5f))));
    away.camera({0, 1, 5}, {0, 1, 9}, 1.2);
    for (const auto& world : {dark.world(), away.world()}) {
        const LightStage stage(world, 12, 100);
        for (const Technique technique : kAll)
            for (const float x : stage.image(technique, 10, 0.02f).pixels)
                EXPECT_EQ(x, 0) << core::enumName(technique);
    }
}

/// A stop is obeyed before the first slice and in the middle of one.
TEST(Techniques, ObeyStops)
{
    const LightStage stage(asset("cornell-diffuse"), 16, 400);
    std::stop_source stop;
    stop.request_stop();
    for (const Technique technique : kAll) {
        FrameSettings s = stage.settings;
        s.technique = technique;
        s.clusters = 50;
        const auto done = [](size_t, const vec3&) {};
        const auto points = makeFrameReceivers(stage.accel, s, 0, {});
        EXPECT_EQ(Frame::begin(stage.accel, s, stage.plan, stage.lights, points, 0,
                               stop.get_token(), done),
                  nullptr);
        const auto frame =
            Frame::begin(stage.accel, s, stage.plan, stage.lights, points, 0, {}, done);
        EXPECT_FALSE(frame->advance(core::Clock::now(), 1e9, stop.get_token(), done));
        EXPECT_EQ(frame->slicesDone(), 0u);
        EXPECT_TRUE(frame->advance(core::Clock::now(), 1e9, {}, done));
    }
}

/// Whenever a slice is given up, the next one on that thread knows nothing of it.
TEST(IlluminationCut, ASliceThatIsGivenUpLeavesNothingToTheNext)
{
    const LightStage stage(asset("cornell-diffuse"), 40, 2000);
    const StageRows r(stage);
    const IlluminationCut cut(stage.lights->tree, 0.02f);
    const std::span<const uint32_t> all(r.chosen), few = all.first(64);
    std::vector<vec3> radiance;
    const auto light = [&](std::span<const uint32_t> chosen, const std::stop_token& stop) {
        SliceStats stats;
        radiance.assign(chosen.size(), vec3(0));
        return cut.light(r.job, r.receivers, chosen, 0, stop, radiance, stats);
    };
    const core::Clock::time_point start = core::Clock::now();
    ASSERT_TRUE(light(all, {}));
    const std::chrono::duration<double> whole(core::secondsSince(start));
    ASSERT_TRUE(light(few, {}));
    const std::vector<vec3> clean = radiance;
    uint32_t given = 0;
    for (int k = 1; k < 20; ++k) {
        std::stop_source stop;
        std::thread later([&] {
            std::this_thread::sleep_for(whole * k / 20);
            stop.request_stop();
        });
        given += light(all, stop.get_token()) ? 0u : 1u;
        later.join();
        ASSERT_TRUE(light(few, {}));
        EXPECT_EQ(radiance, clean) << k;
    }
    EXPECT_GT(given, 0u);
}

}  // namespace
}  // namespace core::many_lights
