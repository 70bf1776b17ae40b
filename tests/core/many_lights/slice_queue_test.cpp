// M13. What a device sums is what the CPU sums: packed slices, by the twin of the kernel, against
// the CPU's own loops; and the queue between them: order, bounds, failures, stops.
#include "core/many_lights/slice_queue.h"

#include <gtest/gtest.h>

#include <atomic>

#include "core/base/check.h"
#include "core/many_lights/frame.h"
#include "tests/support/methods/light_frames.h"
#include "tests/support/methods/slice_twin.h"
#include "tests/support/scenes/asset.h"
#include "tests/support/scenes/test_scenes.h"

namespace core::many_lights {
namespace {

using glm::vec3;
using tests::asset;

constexpr uint32_t kFrameSide = 32;

FrameSettings settingsFor(const core::World& world)
{
    FrameSettings s = tests::frameSettings(world, kFrameSide);
    s.path.seed = 3;
    s.path.maxDepth = 6;
    s.compensates = true;
    s.lights = 2000;
    s.clusters = 150;
    s.sliceSize = 150;
    s.clamp = 0.2f;
    return s;
}

/// A frame, summed by `device` or, without one, by the CPU.
std::vector<vec3> frameOf(const core::Accel& accel, const FrameSettings& s, BatchSum* device,
                          double seconds = 1e9)
{
    const LightPlan plan = planLights(accel, s);
    std::vector<vec3> picture(kFrameSide * kFrameSide, vec3(-1));
    const auto done = [&](size_t pixel, const vec3& L) { picture[pixel] = L; };
    const auto frame = Frame::begin(accel, s, plan, makeFrameLights(accel, s, plan, 0, {}),
                                    makeFrameReceivers(accel, s, 0, {}), 0, {}, done);
    while (!frame->advance(core::Clock::now(), seconds, {}, done, device)) {
    }
    return picture;
}

/// The largest difference of two pictures, in shares of a pixel's and of the mean brightness.
double largestDifference(const std::vector<vec3>& a, const std::vector<vec3>& b)
{
    double mean = 0, largest = 0;
    for (const vec3& L : b) mean += double(L.x + L.y + L.z) / (3 * double(b.size()));
    for (size_t i = 0; i < a.size(); ++i)
        for (int c = 0; c < 3; ++c)
            largest = std::max(largest, std::abs(double(a[i][c]) - double(b[i][c])) /
                                            (std::abs(double(b[i][c])) + 0.1 * mean));
    return largest;
}

TEST(SliceQueue, TheKernelsTwinSumsWhatTheLoopsOfTheCpuSum)
{
    for (const char* name : {"cornell-glossy", "glass", "lights", "sky", "textured-box"}) {
        const auto world = asset(name);
        const core::Accel accel(world);
        const FrameSettings s = settingsFor(*world);
        tests::SliceTwin twin(*world);
        // Rough glass multiplies the rounding of its index, which the twin has from its
        // reflectance.
        const double most = std::string(name) == "glass" ? 1e-3 : 1e-4;
        EXPECT_LT(largestDifference(frameOf(accel, s, &twin), frameOf(accel, s, nullptr)), most)
            << name;
        EXPECT_GT(twin.pieces, 3u);
    }
}

/// And would not, if it had other rules.
TEST(SliceQueue, OtherRulesAreNoticed)
{
    class Wrong final : public BatchSum {
    public:
        explicit Wrong(const core::World& world) : twin_(world) {}
        uint64_t batchEntries() const override { return twin_.batchEntries(); }
        double sum(std::span<const SlicePiece> pieces, const SumRules& rules,
                   std::span<vec3> radiance) override
        {
            SumRules others = rules;
            others.gather.clampDistance *= 0.9f;
            return twin_.sum(pieces, others, radiance);
        }

    private:
        tests::SliceTwin twin_;
    };
    const auto world = asset("cornell-glossy");
    const core::Accel accel(world);
    const FrameSettings s = settingsFor(*world);
    Wrong wrong(*world);
    EXPECT_GT(largestDifference(frameOf(accel, s, &wrong), frameOf(accel, s, nullptr)), 1e-3);
}

/// Numbers in place of bits, and corrections of bits.
TEST(SliceQueue, NumbersAndResidualsAreSummedToo)
{
    const auto world = asset("cornell-glossy");
    const core::Accel accel(world);
    FrameSettings s = settingsFor(*world);
    s.completion = CompletionParams{};
    s.completion.svtIterations = 3;
    s.clusters = 60;
    for (const CompletionMethod method :
         {CompletionMethod::matching, CompletionMethod::amc, CompletionMethod::svt}) {
        s.completion.method = method;
        for (const float residual : {0.0f, 0.05f}) {
            s.completion.residualRate = method == CompletionMethod::svt ? 0 : residual;
            tests::SliceTwin twin(*world);
            EXPECT_LT(largestDifference(frameOf(accel, s, &twin), frameOf(accel, s, nullptr)), 2e-4)
                << "method " << int(method) << ", residual " << residual;
        }
    }
}

/// Neither batches nor pauses change a bit, and slices of many columns come in pieces.
TEST(SliceQueue, BatchesDoNotMatter)
{
    const auto world = asset("cornell-diffuse");
    const core::Accel accel(world);
    FrameSettings s = settingsFor(*world);
    s.sliceSize = 2000;
    s.lights = 5000;
    s.clusters = 4000;
    tests::SliceTwin large(*world, uint64_t(1) << 40), small(*world, 1), paused(*world);
    const std::vector<vec3> expected = frameOf(accel, s, &large);
    EXPECT_EQ(frameOf(accel, s, &small), expected);
    EXPECT_EQ(frameOf(accel, s, &paused, 0), expected);
    EXPECT_EQ(small.batches, small.pieces);
    EXPECT_EQ(small.pieces, large.pieces);
    EXPECT_GE(large.pieces, 4u);  // of one slice
}

SlicePiece smallPiece(uint32_t slice)
{
    SlicePiece piece;
    piece.rows = 1;
    piece.columns = 100;
    piece.slice = std::make_shared<PendingSlice>();
    piece.slice->slice = slice;
    piece.slice->pieces = 1;
    piece.slice->radiance.assign(1, vec3(1));
    return piece;
}

/// Adds 2 to everything, after a while; fails at a given batch.
class Slow final : public BatchSum {
public:
    uint64_t batchEntries() const override { return 250; }
    double sum(std::span<const SlicePiece> pieces, const SumRules&,
               std::span<vec3> radiance) override
    {
        if (++batches == failsAt)
            throw core::Error("the device is lost", core::ExitCode::deviceLost);
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        most = std::max(most, pieces.size());
        for (vec3& L : radiance) L = vec3(2);
        return 0.5;
    }
    int batches = 0, failsAt = 0;
    size_t most = 0;
};

TEST(SliceQueue, NoMoreWaitsThanABatch)
{
    Slow slow;
    std::atomic<uint32_t> finished = 0, pushed = 0;
    uint32_t ahead = 0;
    SliceQueue queue(slow, {}, {}, [&](PendingSlice& slice) {
        EXPECT_EQ(slice.radiance.at(0), vec3(3));
        EXPECT_EQ(slice.slice, finished);  // in order
        ++finished;
        const uint32_t known = pushed;  // of a piece that is done already it may not be told yet
        if (known > finished) ahead = std::max<uint32_t>(ahead, known - finished);
    });
    for (uint32_t i = 0; i < 40; ++i) {
        ASSERT_TRUE(queue.push(smallPiece(i)));
        ++pushed;
    }
    const double seconds = queue.finish();
    EXPECT_NEAR(seconds, 0.5 * slow.batches, 1e-9);
    EXPECT_EQ(finished, 40u);
    EXPECT_LE(slow.most, 2u);  // 250 entries
    // One batch under way and one that waits, a piece more than fits in it, and the one just
    // pushed.
    EXPECT_LE(ahead, 2u + 3u + 1u);
}

TEST(SliceQueue, AFailureEndsItAndIsTold)
{
    Slow slow;
    slow.failsAt = 3;
    SliceQueue queue(slow, {}, {}, [](PendingSlice&) {});
    uint32_t taken = 0;
    while (taken < 1000 && queue.push(smallPiece(taken))) ++taken;
    EXPECT_LT(taken, 20u);
    EXPECT_THROW(queue.finish(), core::Error);
}

TEST(SliceQueue, AStopGivesUpWhatWaits)
{
    Slow slow;
    std::stop_source stop;
    std::atomic<uint32_t> finished = 0;
    SliceQueue queue(slow, {}, stop.get_token(), [&](PendingSlice&) {
        if (++finished == 4) stop.request_stop();
    });
    uint32_t taken = 0;
    while (taken < 1000 && queue.push(smallPiece(taken))) ++taken;
    queue.finish();
    EXPECT_FALSE(queue.push(smallPiece(0)));
    EXPECT_LT(finished, 4u + 3u);
    EXPECT_LT(taken, 12u);
}

/// A frame whose device fails throws that, and the next one goes on.
TEST(SliceQueue, AFrameTellsOfItsDevicesFailure)
{
    class Fails final : public BatchSum {
    public:
        uint64_t batchEntries() const override { return 1 << 20; }
        double sum(std::span<const SlicePiece>, const SumRules&, std::span<vec3>) override
        {
            throw core::Error("the device is lost", core::ExitCode::deviceLost);
        }
    };
    const auto world = asset("cornell-diffuse");
    const core::Accel accel(world);
    const FrameSettings s = settingsFor(*world);
    Fails fails;
    EXPECT_THROW(frameOf(accel, s, &fails), core::Error);
}

}  // namespace
}  // namespace core::many_lights
