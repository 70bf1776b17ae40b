// How long a submission holds the device (V3): the rule alone, and renderers on a device that says
// it is a hundred times slower than it is, or take many paths to a pixel; what a stop leaves
// behind; the mean beside the film; views that compile no kernels.
#include <algorithm>
#include <chrono>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "app/gpu/base/api.h"
#include "app/gpu/base/batch_pace.h"
#include "app/gpu/methods/methods.h"
#include "app/gpu/methods/path.h"
#include "core/methods/reuse_params.h"
#include "tests/support/scenes/asset.h"

namespace {

using tests::asset;

TEST(BatchPace, ReachesTheWantedTimeFromNothing)
{
    for (const double secondsPerLane : {1e-9, 1e-7, 1e-5}) {
        gpu::BatchPace pace;
        EXPECT_EQ(pace.lanes(0.05, 1u << 18), gpu::BatchPace::kFirst);
        double seconds = 0;
        for (int i = 0; i < 8; ++i) {
            const uint32_t lanes = pace.lanes(0.05, 1u << 18);
            seconds = 2e-4 + lanes * secondsPerLane;
            pace.measured(lanes, seconds);
        }
        const double most = 2e-4 + (1u << 18) * secondsPerLane;
        EXPECT_LE(seconds, 0.055);
        EXPECT_GE(seconds, std::min(0.04, 0.99 * most)) << secondsPerLane;
    }
}

TEST(BatchPace, ASlowPartIsRememberedForAWhile)
{
    gpu::BatchPace pace;
    const auto run = [&](double secondsPerLane) {
        const uint32_t lanes = pace.lanes(0.05, 1u << 20);
        pace.measured(lanes, lanes * secondsPerLane);
        return lanes;
    };
    for (int i = 0; i < 8; ++i) run(1e-6);
    const uint32_t before = pace.lanes(0.05, 1u << 20);
    run(4e-6);
    const uint32_t slow = pace.lanes(0.05, 1u << 20);
    EXPECT_LE(slow, before / 3);
    run(1e-6);
    EXPECT_LE(pace.lanes(0.05, 1u << 20), slow * 5 / 4);
    for (int i = 0; i < 20; ++i) run(1e-6);
    EXPECT_GE(pace.lanes(0.05, 1u << 20), before * 9 / 10);
}

TEST(BatchPace, StaysWithinItsBounds)
{
    gpu::BatchPace pace;
    pace.measured(64, 10);
    EXPECT_EQ(pace.lanes(0.008, 1u << 18), 64u);
    pace.restart();
    for (int i = 0; i < 10; ++i) pace.measured(pace.lanes(1, 1000), 1e-6);
    EXPECT_EQ(pace.lanes(1, 1000), 960u);  // whole groups
    pace.again();
    EXPECT_EQ(pace.lanes(1, 1000), 192u);  // a quarter, in whole groups
    EXPECT_EQ(pace.lanes(0, 1000), 64u);
}

/// What is left of a picture does not make the next batch small.
TEST(BatchPace, GrowsFromTheLargestBatch)
{
    gpu::BatchPace pace;
    for (int i = 0; i < 10; ++i) pace.measured(pace.lanes(1, 1u << 16), 1e-3);
    ASSERT_EQ(pace.lanes(1, 1u << 16), 1u << 16);
    pace.measured(64, 1e-6);
    EXPECT_EQ(pace.lanes(1, 1u << 16), 1u << 16);
    pace.again();
    EXPECT_EQ(pace.lanes(1, 1u << 16), 1u << 14);
    pace.measured(1u << 14, 2e-4);
    EXPECT_EQ(pace.lanes(1, 1u << 16), 1u << 16);
}

// A device whose clock advances by the work it is given, so that other work on the machine does not
// count.
double secondsPerLane = 0;
uint64_t dispatchedGroups = 0;          // dispatched since the last look at the clock
uint32_t mostGroups = 0;                // of one dispatch
std::vector<double> submissionSeconds;  // seconds of each submission by that clock

void countedDispatch(VkCommandBuffer commands, uint32_t x, uint32_t y, uint32_t z)
{
    dispatchedGroups += uint64_t(x) * y * z;
    mostGroups = std::max(mostGroups, x * y * z);
    vkCmdDispatch(commands, x, y, z);
}

VkResult countedTime(VkDevice device, VkQueryPool pool, uint32_t first, uint32_t count,
                     size_t bytes, void* data, VkDeviceSize stride, VkQueryResultFlags flags)
{
    const VkResult result =
        vkGetQueryPoolResults(device, pool, first, count, bytes, data, stride, flags);
    const double seconds = secondsPerLane * double(dispatchedGroups) * 64;
    auto* ticks = static_cast<uint64_t*>(data);
    ticks[1] = ticks[0] +
               static_cast<uint64_t>(seconds * 1e9);  // Mesa's software device counts nanoseconds
    submissionSeconds.push_back(seconds);
    dispatchedGroups = 0;
    return result;
}

/// A renderer on that device; Vulkan's table is put back at the end.
class GpuPace : public testing::Test {
protected:
    static void SetUpTestSuite()
    {
        gpu::vk.CmdDispatch = countedDispatch;
        gpu::vk.GetQueryPoolResults = countedTime;
        renderer = gpu::makePathRenderer({});
        world = asset("cornell-glossy");
    }
    static void TearDownTestSuite()
    {
        renderer.reset();
        world.reset();
        gpu::vk.GetQueryPoolResults = vkGetQueryPoolResults;
        gpu::vk.CmdDispatch = vkCmdDispatch;
    }
    void SetUp() override
    {
        secondsPerLane = 1e-6;  // about that of Mesa's software device on two cores
        renderer->setPace({});
        renderer->setWorld(world, {});
    }
    static void view(uint32_t width, uint32_t height, uint32_t depth = 8)
    {
        core::PathParams params;
        params.maxDepth = depth;
        params.kernel = core::Kernel::megakernel;  // its dispatches say how many lanes they have
        renderer->setView({world->cameras.at(0), {width, height}, params}, core::Start::anew);
        submissionSeconds.clear();
    }

    static inline std::unique_ptr<core::Renderer> renderer;
    static inline std::shared_ptr<const core::World> world;
};

TEST_F(GpuPace, ADeviceOfAHundredthOfTheSpeedIsHeldForAFifthOfASecondAtMost)
{
    // The same world again would be a pose of it, whose speed is known.
    const std::shared_ptr<const core::World> another = asset("cornell-diffuse");
    for (const double wanted : {0.008, 0.05, 10.0}) {
        secondsPerLane = 1e-6;
        renderer->setWorld(world, {});
        renderer->setPace({.dispatchSeconds = wanted});
        view(256, 256);
        renderer->advance({.samples = 4}, {});
        const double before = *std::max_element(submissionSeconds.begin(), submissionSeconds.end());
        EXPECT_GE(before, std::min(0.9 * wanted, 0.06)) << "batches stayed small";
        EXPECT_LE(before, std::min(1.01 * wanted, 0.101));

        secondsPerLane = 1e-4;
        renderer->setWorld(another, {});  // nothing is known of the new scene
        view(64, 64);
        renderer->advance({.samples = 2}, {});
        ASSERT_GT(submissionSeconds.size(), 10u);
        for (size_t i = 0; i < submissionSeconds.size(); ++i)
            EXPECT_LE(submissionSeconds[i], i < 3 ? 0.5 : 0.2) << i;
        EXPECT_LE(submissionSeconds.back(), std::max(1.01 * wanted, 128 * secondsPerLane));
    }
}

/// What nothing stops comes in one piece on a device of software, once its speed is known; others
/// are shared with a window.
TEST_F(GpuPace, WholePicturesAreNotCutUpBySoftware)
{
    renderer->setPace({.dispatchSeconds = 0.008, .whole = true});
    for (int i = 0; i < 4; ++i) {
        view(192, 128);
        renderer->advance({.samples = 1}, {});
    }
    const auto longest = [] {
        return *std::max_element(submissionSeconds.begin(), submissionSeconds.end());
    };
    if (gpu::Device({}).isSoftware()) {
        EXPECT_EQ(submissionSeconds.size(), 1u);
        EXPECT_GT(longest(), 0.02);
    } else {
        EXPECT_LE(longest(), 0.0081);
    }
    renderer->setPace({.dispatchSeconds = 0.008});
    view(192, 128);
    renderer->advance({.samples = 1}, {});
    EXPECT_LE(longest(), 0.0081);
}

/// Nor are first hits, of a coarse view or asked for alone.
TEST_F(GpuPace, FirstHitsOfKnownSpeedAreNotCutUpBySoftware)
{
    if (!gpu::Device({}).isSoftware()) GTEST_SKIP() << "for devices of software";
    renderer->setPace({.dispatchSeconds = 0.008, .whole = true});
    const auto submissions = [] {
        view(192, 128);
        renderer->aovs();
        return submissionSeconds.size();
    };
    EXPECT_GT(submissions(), 2u) << "nothing was known";
    EXPECT_EQ(submissions(), 1u);
    // The same world again would be a pose of it, whose speed is known.
    renderer->setWorld(asset("cornell-diffuse"), {});
    renderer->setView({world->cameras.at(0), {192, 128}, core::PathParams{}}, core::Start::anew);
    submissionSeconds.clear();
    renderer->aovs();
    EXPECT_GT(submissionSeconds.size(), 2u) << "nothing is known of another scene";
}

/// `full` takes one path for each sample that its history stands for: a moved view after one at
/// rest, whose passes take one path each, has batches of so many pixels less.
TEST_F(GpuPace, BatchesOfManyPathsHaveFewPixels)
{
    const std::unique_ptr<core::Renderer> reuse = gpu::makeSampleReuse({});
    reuse->setWorld(world, {});
    reuse->setPace({.dispatchSeconds = 0.05});
    core::ReuseParams params;
    params.reuse = core::ReuseStrategy::full;
    params.maxDepth = 1;
    const core::View view{world->cameras.at(0), {160, 120}, params};
    reuse->setView(view, core::Start::anew);
    reuse->advance({.samples = 31}, {});
    mostGroups = 0;
    reuse->advance({.samples = 1}, {});
    EXPECT_EQ(mostGroups, 300u) << "the picture fits one batch";
    reuse->setView(view, core::Start::moved);
    mostGroups = 0;
    reuse->advance({.samples = 1, .seconds = 0}, {});  // one batch
    EXPECT_GT(mostGroups, 0u);
    EXPECT_LE(mostGroups, 20u);
}

/// Deeper paths than those whose speed is known begin as if nothing were; others do not.
TEST_F(GpuPace, DeeperPathsBeginSmall)
{
    const auto firstBatch = [&](uint32_t depth) {
        view(256, 256, depth);
        mostGroups = 0;
        renderer->advance({.samples = 1, .seconds = 0}, {});
        return mostGroups;
    };
    renderer->setPace({.dispatchSeconds = 0.05});
    view(256, 256, 2);
    renderer->advance({.samples = 2}, {});
    EXPECT_GT(firstBatch(1), 2 * gpu::BatchPace::kFirst / 64);
    renderer->advance({.samples = 2}, {});
    EXPECT_EQ(firstBatch(8), gpu::BatchPace::kFirst / 64);
}

/// A card fills with the lanes of a whole batch, and is measured with as many.
TEST_F(GpuPace, SlowTheKernelIsChosenByBatchesAsTheyAre)
{
    gpu::vk.GetPhysicalDeviceProperties2 = [](VkPhysicalDevice physical,
                                              VkPhysicalDeviceProperties2* out) {
        vkGetPhysicalDeviceProperties2(physical, out);
        out->properties.deviceType = VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU;
    };
    const std::unique_ptr<core::Renderer> card = gpu::makePathRenderer({});
    gpu::vk.GetPhysicalDeviceProperties2 = vkGetPhysicalDeviceProperties2;
    secondsPerLane = 1e-9;
    card->setWorld(world, {});
    card->setPace({.dispatchSeconds = 0.05});
    core::Camera away = world->cameras.at(0);  // looks at nothing: what is traced costs little
    away.forward = -away.forward;
    core::PathParams params;
    params.maxDepth = 2;
    card->setView({away, {160, 160}, params}, core::Start::anew);
    mostGroups = 0;
    for (int i = 0; i < 400 && mostGroups <= 400; ++i) {
        card->advance({.samples = i < 3 ? 40u : 1u}, {});  // enough for it to pay, then waits
        std::this_thread::sleep_for(std::chrono::milliseconds(i < 3 ? 0 : 50));
    }
    // The film gets 400 groups at a time, whole paths two samples of as many: 65,536 lanes.
    EXPECT_EQ(mostGroups, 800u);
}

TEST_F(GpuPace, FirstHitsAreFoundInPieces)
{
    secondsPerLane = 1e-5;
    renderer->setPace({.dispatchSeconds = 0.05});
    view(400, 240);
    renderer->aovs();
    ASSERT_GT(submissionSeconds.size(), 10u);
    EXPECT_LE(*std::max_element(submissionSeconds.begin(), submissionSeconds.end()), 0.051);
}

TEST_F(GpuPace, AStopBetweenBatchesLeavesWholeTiles)
{
    view(256, 256);
    renderer->advance({.samples = 3}, {});
    const core::Estimate expected = renderer->read(core::Reading::everything);
    renderer->setPace({.dispatchSeconds = 0.002});
    view(256, 256);
    bool partial = false;
    for (uint64_t version = renderer->progress().version; renderer->progress().samples < 3;) {
        renderer->advance({.samples = 1, .seconds = 0}, {});
        const core::RenderProgress now = renderer->progress();
        ASSERT_GT(now.version, version);
        version = now.version;
        if (now.fraction == 0) continue;
        if (!partial) renderer->aovs();  // for a coarse picture: they leave the sample as it is
        partial = true;
        const core::Estimate e = renderer->read(core::Reading::everything);
        EXPECT_EQ(e.samples, now.samples);
        // The mean alone divides by the same counts.
        const core::Image mean = renderer->read(core::Reading::mean).mean;
        for (size_t i = 0; i < mean.pixels.size(); ++i)
            ASSERT_NEAR(mean.pixels[i], e.mean.pixels[i], 1e-6f * e.mean.pixels[i] + 1e-30f) << i;
        size_t ahead = 0;
        for (const float weight : e.weight.pixels)
            ahead += weight > static_cast<float>(e.samples) ? 1u : 0u;
        EXPECT_DOUBLE_EQ(now.fraction, double(ahead) / (256 * 256));
    }
    EXPECT_TRUE(partial);
    std::stop_source stop;
    stop.request_stop();
    const uint64_t version = renderer->progress().version;
    renderer->advance({.samples = 5}, stop.get_token());  // stopped before it begins
    EXPECT_EQ(renderer->progress().version, version);
    renderer->advance({.samples = 0}, {});
    const core::Estimate after = renderer->read(core::Reading::everything);
    ASSERT_EQ(after.samples, 3u);
    EXPECT_EQ(after.mean.pixels, expected.mean.pixels);
    EXPECT_EQ(after.variance.pixels, expected.variance.pixels);
    EXPECT_TRUE(after.counters.clean());
}

TEST_F(GpuPace, TheMeanIsThatOfTheFilm)
{
    for (const glm::uvec2 size :
         {glm::uvec2(64, 48), glm::uvec2(31, 7), glm::uvec2(100, 90), glm::uvec2(9, 9)}) {
        view(size.x, size.y);
        core::Image mean = renderer->read(core::Reading::mean).mean;
        EXPECT_EQ(mean.pixels, core::Image(size.x, size.y, 3).pixels) << "before the first sample";
        renderer->advance({.samples = 7}, {});
        mean = renderer->read(core::Reading::mean).mean;
        const core::Estimate film = renderer->read(core::Reading::everything);
        const core::Image& expected = film.mean;
        ASSERT_EQ(mean.pixels.size(), expected.pixels.size());
        for (size_t i = 0; i < mean.pixels.size(); ++i) {
            ASSERT_NEAR(mean.pixels[i], expected.pixels[i], 1e-6f * expected.pixels[i] + 1e-30f)
                << i;
        }
        EXPECT_GT(*std::max_element(mean.pixels.begin(), mean.pixels.end()), 0);
    }
}

TEST_F(GpuPace, AnotherCameraNeedsNoNewKernelsBuffersOrChoice)
{
    renderer->setView({world->cameras.at(0), {320, 180}, {}}, core::Start::anew);
    renderer->advance({.samples = 60}, {});  // the kernel is chosen
    const core::RenderStats before = renderer->stats();
    for (int i = 0; i < 10; ++i) {
        core::Camera camera = world->cameras.at(0);
        camera.position.x += 0.01 * i;
        core::PathParams params;
        submissionSeconds.clear();
        renderer->setView({camera, i % 2 == 0 ? glm::uvec2(320, 180) : glm::uvec2(160, 90), params},
                          core::Start::anew);
        EXPECT_LE(submissionSeconds.size(), 1u);  // the film is cleared, nothing is measured
        renderer->advance({.samples = 1}, {});
    }
    EXPECT_EQ(renderer->stats().compileSeconds, before.compileSeconds);
    EXPECT_EQ(renderer->stats().peakDeviceBytes, before.peakDeviceBytes);
    EXPECT_EQ(renderer->stats().details[0].value, before.details[0].value);
}

// A camera that moves makes paths shallow where pictures take too long, and must not wait for the
// other kernel then.
TEST_F(GpuPace, ShallowPathsNeedNoKernelOfTheirOwn)
{
    const std::unique_ptr<core::Renderer> fresh = gpu::makePathRenderer({});
    fresh->setWorld(world, {});
    core::PathParams deep, shallow;
    shallow.maxDepth = 1;
    const auto take = [&](const core::PathParams& params) {
        fresh->setView({world->cameras.at(0), {64, 48}, params}, core::Start::anew);
        fresh->advance({.samples = 2}, {});
        return fresh->read(core::Reading::mean).mean;
    };
    take(deep);
    const core::RenderStats before = fresh->stats();
    const core::Image byTheOther = take(shallow);
    EXPECT_EQ(fresh->stats().compileSeconds, before.compileSeconds);
    EXPECT_EQ(fresh->stats().details[0].value, before.details[0].value);

    shallow.kernel = core::Kernel::megakernel;
    EXPECT_EQ(take(shallow).pixels, byTheOther.pixels);
    EXPECT_GT(fresh->stats().compileSeconds, before.compileSeconds);
    EXPECT_NE(fresh->stats().details[0].value, before.details[0].value);
}

TEST_F(GpuPace, FirstHitsArePreparedOnceAndTraceNothing)
{
    const std::unique_ptr<core::Renderer> fresh = gpu::makePathRenderer({});
    fresh->setWorld(world, {});
    const core::View view{world->cameras.at(0), {320, 180}, {}};
    fresh->setView(view, core::Start::anew);
    submissionSeconds.clear();
    fresh->prepareAovs();
    EXPECT_EQ(submissionSeconds.size(), 1u);
    fresh->prepareAovs();
    EXPECT_EQ(submissionSeconds.size(), 1u);
    const core::Aovs aovs = fresh->aovs();
    fresh->setView(view, core::Start::anew);
    EXPECT_EQ(fresh->aovs().depth.pixels, aovs.depth.pixels);
    EXPECT_GT(*std::max_element(aovs.depth.pixels.begin(), aovs.depth.pixels.end()), 0);
}

}  // namespace
