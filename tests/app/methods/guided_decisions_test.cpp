// Who follows the guide, on every device: nobody before it promises enough, all while it pays, and
// nobody again once it has been given up; then the picture is the path tracer's and costs as much.
#include "tests/support/methods/guided_renders.h"

namespace {

using namespace tests;

using core::GuidedParams;
using GuidedDecisions = GuidedRenders;

/// Once the guide has been given up, paths are the path tracer's own: to its speed on a device
/// whose kernels are slower for what they leave alone, and in every pixel.
TEST_P(GuidedDecisions, PathsAreThePathTracersWhereItDoesNotPay)
{
    constexpr uint32_t kTrial = 24, kMost = 8192;
    begin("cornell-diffuse", {64, 64});
    const GuidedParams params{.seed = 3};
    const core::Image before = render(params, kTrial).mean;
    ASSERT_EQ(guiding(), "does not pay here");
    const auto rests = [&] {
        return detail<std::string>("kernel").ends_with(" without the guide");
    };
    uint32_t all = kTrial;
    do {  // other kernels are compiled beside the paths, after enough of these
        guided_->advance({.samples = 8}, {});
        all += 8;
    } while (GetParam() == app::DeviceKind::vulkan && !rests() && all < kMost);
    guided_->advance({.samples = 8}, {});
    all += 8;
    ASSERT_LT(all, kMost);
    const core::Image after = guided_->read(core::Reading::mean).mean;
    const core::Image plainBefore = plain({.seed = 3}, kTrial).mean,
                      plainAfter = plain({.seed = 3}, all).mean;
    for (size_t i = 0; i < after.pixels.size(); ++i) {
        const auto sum = [&](const core::Image& late, const core::Image& early) {
            return float(all) * late.pixels[i] - kTrial * early.pixels[i];
        };
        const float expected = sum(plainAfter, plainBefore);
        ASSERT_NEAR(sum(after, before), expected, 1e-3f * expected + 1e-3f) << i;
    }
}

/// Light that is easy to find: what the guide would save is less than what it costs.
TEST_P(GuidedDecisions, GivesUpWhereItDoesNotPay)
{
    begin("cornell-diffuse", {96, 96});
    const auto raysOf = [&](core::GuideUse use) {
        render({.use = use, .seed = 3}, 24);
        return double(guided_->stats().rays);
    };
    const double followed = raysOf(core::GuideUse::always);
    EXPECT_EQ(guiding(), "always");
    EXPECT_LT(raysOf(core::GuideUse::pays), 0.9 * followed);
    EXPECT_EQ(guiding(), "does not pay here");

    // Another view may be another matter: it is tried again at once where there was a long rest...
    double records = detail("guide_records");
    render({.seed = 3}, 6, core::Start::moved);
    EXPECT_GT(detail("guide_records"), records);
    EXPECT_EQ(guiding(), "does not pay here");
    // ... and else when the view has lasted.
    records = detail("guide_records");
    render({.seed = 3}, 7, core::Start::moved);
    EXPECT_EQ(detail("guide_records"), records);
    render({.seed = 3}, 16, core::Start::moved);
    EXPECT_GT(detail("guide_records"), records);
}

/// Nobody but the recorded paths follows a guide that promises less than it costs, in larger
/// pictures either, where it promises more: what it would save is only seen, not paid for.
TEST_P(GuidedDecisions, IsNotFollowedWithoutAPromise)
{
    begin("cornell-diffuse", {256, 256});
    render({.seed = 3}, 1);
    for (int n = 2; n <= 18; ++n) {
        guided_->advance({.samples = 1}, {});
        ASSERT_NE(guiding(), "pays") << n;
    }
    EXPECT_EQ(guiding(), "does not pay here");
    EXPECT_LT(detail("guide_gain"), 1.2);
}

/// What promises less than rooms do that gain is not tried to the end: recorded paths cost more
/// than others.
TEST_P(GuidedDecisions, IsGivenUpSoonWhereThereIsNoHope)
{
    begin("cornell-diffuse", {144, 144});
    for (const uint32_t seed : {3u, 4u, 5u}) {
        render({.seed = seed}, 5);
        EXPECT_EQ(guiding(), "does not pay here") << seed;
        EXPECT_LT(detail("guide_gain"), 1.14) << seed;
    }
}

/// What is neither hopeless nor promised yet is tried on: where few paths are recorded of each
/// sample the promise comes late.
TEST_P(GuidedDecisions, IsFollowedOnceItPromisesEnough)
{
    for (const uint32_t side : {128u, 80u}) {
        begin("cornell-moderate", {side, side});
        render({.seed = 3}, 3);
        EXPECT_EQ(guiding(), "is tried") << side;
        guided_->advance({.samples = 1}, {});
        if (side == 80) EXPECT_EQ(guiding(), "is tried");
        guided_->advance({.samples = side == 80 ? 12u : 4u}, {});
        EXPECT_EQ(guiding(), "pays") << side;
        EXPECT_GT(detail("guide_gain"), 1.22) << side;
    }
}

/// Single samples teach slowly: after six lessons of them nothing is decided yet, after twelve a
/// glossy box is found to pay.
TEST_P(GuidedDecisions, IsFollowedInAFlightWhereItPaysLate)
{
    begin("cornell-glossy", {96, 96});
    for (const uint32_t seed : {1u, 2u}) {
        render({.seed = seed}, 1);
        for (int frame = 1; frame < 8; ++frame) render({.seed = seed}, 1, core::Start::moved);
        EXPECT_EQ(guiding(), "is tried") << seed;
        for (int frame = 8; frame < 14; ++frame) render({.seed = seed}, 1, core::Start::moved);
        EXPECT_EQ(guiding(), "pays") << seed;
        EXPECT_GT(detail("guide_gain"), 1.15) << seed;
    }
}

/// Where it does not pay it is tried again and again while views are short, ever more seldom.
TEST_P(GuidedDecisions, IsTriedAgainInAFlightWhereItDidNotPay)
{
    begin("cornell-diffuse", {64, 64});
    render({.seed = 3}, 1);
    int trials = 0;
    double records = 0;
    for (int frame = 0; frame < 60; ++frame) {
        render({.seed = 3}, 1, core::Start::moved);
        const double now = detail("guide_records");
        if (frame >= 8 && now > records) ++trials;
        records = now;
    }
    EXPECT_NE(guiding(), "pays");
    EXPECT_GE(trials, 2);
    EXPECT_LE(trials, 3 * 6);
}

/// A guide that did not pay is tried again while it may still learn, however short its training and
/// in whatever pieces a view is rendered: the next view begins as if nobody had tried.
TEST_P(GuidedDecisions, ShortTrainingsEndInAllPieces)
{
    begin("cornell-diffuse", {96, 96});
    for (const uint32_t training : {4u, 8u}) {
        const GuidedParams params{.training = training, .seed = 3};
        const auto thirdView = [&](uint32_t pieces) {
            render(params, 16);
            EXPECT_EQ(guiding(), "does not pay here") << training;
            render(params, 16 / pieces, core::Start::moved);
            for (uint32_t k = 1; k < pieces; ++k) guided_->advance({.samples = 16 / pieces}, {});
            EXPECT_NE(guiding(), "is tried") << training;
            return render(params, 4, core::Start::moved).mean.pixels;
        };
        EXPECT_EQ(thirdView(1), thirdView(4)) << training;
    }
}

/// The guide of the first samples knows too little: nobody follows it, and nothing is lost.
TEST_P(GuidedDecisions, IsThePathTracerUntilItHasSomethingToSay)
{
    begin("door-ajar", {96, 54});
    const core::Estimate first = render({.seed = 4}, 2);
    EXPECT_EQ(guiding(), "is tried");
    EXPECT_EQ(first.mean.pixels, plain({.seed = 4}, 2).mean.pixels);
    guided_->advance({.samples = 14}, {});
    EXPECT_EQ(guiding(), "pays");
    EXPECT_GT(detail("guide_gain"), 2);
    render({.training = 2, .seed = 4}, 4);
    EXPECT_EQ(guiding(), "pays") << "training ended before a trial";
}

INSTANTIATE_TEST_SUITE_P(Devices, GuidedDecisions,
                         testing::Values(app::DeviceKind::cpu, app::DeviceKind::vulkan),
                         [](const testing::TestParamInfo<app::DeviceKind>& where) {
                             return std::string(core::enumName(where.param));
                         });

}  // namespace
