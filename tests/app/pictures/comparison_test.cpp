// Equal-time runs against pictures made up here, and labels.
#include "app/pictures/comparison.h"

#include <gtest/gtest.h>

#include "core/methods/method.h"

namespace {

app::RenderParams depth(uint32_t maxDepth)
{
    app::RenderParams params;
    params.method.as<core::PathParams>().maxDepth = maxDepth;
    return params;
}

std::shared_ptr<const app::Picture> picture(const app::RenderParams& params, double seconds,
                                            uint64_t generation, bool preview = false)
{
    auto made = std::make_shared<app::Picture>();
    made->params = params;
    made->seconds = seconds;
    made->generation = generation;
    made->samples = 1 + static_cast<uint64_t>(seconds * 10);
    made->preview = preview;
    return made;
}

TEST(EqualTime, RendersOneSideAfterTheOther)
{
    app::EqualTime run;
    EXPECT_FALSE(run.running());
    EXPECT_FALSE(run.offer(picture(depth(3), 100, 9)));

    app::RenderParams a = depth(3), b = depth(5);
    a.sppLimit = 4;  // limits of the user would end a side early
    b.errorLimit = 1;
    run.start(a, b, 2);
    EXPECT_TRUE(run.running());
    EXPECT_EQ(run.side(), 0);
    EXPECT_EQ(run.wanted().method.as<core::PathParams>().maxDepth, 3u);
    EXPECT_EQ(run.wanted().sppLimit, 0u);
    EXPECT_EQ(run.wanted().secondsLimit, 2);

    EXPECT_FALSE(run.offer(picture(run.wanted(), 0.5, 1)));
    EXPECT_DOUBLE_EQ(run.fraction(), 0.25);
    const auto first = picture(run.wanted(), 2.1, 1);
    const auto slotA = run.offer(first);
    ASSERT_TRUE(slotA);
    EXPECT_EQ(slotA->picture, first);
    EXPECT_EQ(slotA->label, app::pictureLabel(*first));

    EXPECT_EQ(run.side(), 1);
    EXPECT_EQ(run.fraction(), 0);
    EXPECT_EQ(run.wanted().method.as<core::PathParams>().maxDepth, 5u);
    EXPECT_EQ(run.wanted().errorLimit, 0);
    const auto second = picture(run.wanted(), 2, 2);
    const auto slotB = run.offer(second);
    ASSERT_TRUE(slotB);
    EXPECT_EQ(slotB->picture, second);
    EXPECT_FALSE(run.running());
    EXPECT_FALSE(run.offer(picture(depth(5), 3, 3)));
}

TEST(EqualTime, IgnoresWhatIsNotOfTheSide)
{
    app::EqualTime run;
    run.start(depth(3), depth(5), 2, 7);
    EXPECT_FALSE(run.offer(nullptr));
    EXPECT_FALSE(run.offer(picture(depth(4), 5, 8)));        // other parameters
    EXPECT_FALSE(run.offer(picture(depth(5), 5, 8)));        // the other side's
    EXPECT_FALSE(run.offer(picture(depth(3), 5, 8, true)));  // a preview
    EXPECT_FALSE(run.offer(picture(depth(3), 5, 7)));        // what was on show before the start
    EXPECT_EQ(run.fraction(), 0);
    EXPECT_EQ(run.side(), 0);
    EXPECT_TRUE(run.offer(picture(depth(3), 5, 8)));
    EXPECT_EQ(run.side(), 1);
}

TEST(EqualTime, EqualSidesAreBothRendered)
{
    app::EqualTime run;
    run.start(depth(3), depth(3), 2, 4);
    const auto a = picture(depth(3), 2, 5);
    EXPECT_TRUE(run.offer(a));
    EXPECT_FALSE(run.offer(a)) << "the first side's picture is not the second's";
    EXPECT_TRUE(run.running());
    EXPECT_TRUE(run.offer(picture(depth(3), 2, 6)));
    EXPECT_FALSE(run.running());
}

TEST(EqualTime, ARestartWithinASideBeginsItsTimeAgain)
{
    app::EqualTime run;
    run.start(depth(3), depth(5), 10);
    run.offer(picture(run.wanted(), 8, 1));
    EXPECT_DOUBLE_EQ(run.fraction(), 0.8);
    EXPECT_FALSE(run.offer(picture(run.wanted(), 1, 2)));
    EXPECT_DOUBLE_EQ(run.fraction(), 0.1);
}

TEST(EqualTime, CancelAndANewStart)
{
    app::EqualTime run;
    run.start(depth(3), depth(5), 2);
    run.offer(picture(run.wanted(), 2, 1));
    run.cancel();
    EXPECT_FALSE(run.running());
    EXPECT_FALSE(run.offer(picture(depth(5), 2, 2)));
    run.start(depth(1), depth(2), 0, 2);  // no time at all would never render
    EXPECT_EQ(run.side(), 0);
    EXPECT_GT(run.seconds(), 0);
    EXPECT_EQ(run.wanted().method.as<core::PathParams>().maxDepth, 1u);
}

TEST(PictureLabel, TellsWhatDistinguishes)
{
    app::RenderParams params = depth(8);
    EXPECT_EQ(app::pictureLabel(*picture(params, 2, 1)), "path, vulkan, depth 8, 21 spp, 2.0 s");
    params.device = app::DeviceKind::cpu;
    params.method.as<core::PathParams>().clampIndirect = 2.5f;
    params.method.as<core::PathParams>().sampler = core::SamplerKind::independent;
    params.method.as<core::PathParams>().seed = 7;
    EXPECT_EQ(app::pictureLabel(*picture(params, 65, 1)),
              "path, cpu, depth 8, seed 7, sampler independent, clamp-indirect 2.5, 651 spp, 65 s");
}

TEST(ParamDifferences, AreNamedAlsoBetweenMethods)
{
    app::RenderParams a = depth(8), b = depth(8);
    b.sppLimit = 7;  // no matter: equal time has its own
    EXPECT_TRUE(app::differences(a, b).empty());
    b.method.as<core::PathParams>().sampler = core::SamplerKind::independent;
    b.method.as<core::PathParams>().clampIndirect = 2.5f;
    b.device = app::DeviceKind::cpu;
    std::string text;
    for (const auto& [name, x, y] : app::differences(a, b)) text += name + ' ' + x + ' ' + y + '\n';
    EXPECT_EQ(text, "device vulkan cpu\nsampler sobol independent\nclamp-indirect 0 2.5\n");
    b = a;
    b.method = core::methodNamed("ao").defaults;
    bool method = false, none = false;
    for (const auto& [name, x, y] : app::differences(a, b)) {
        method |= name == "method" && x == "path" && y == "ao";
        none |= name == "max-depth" && x == "8" && y == "-";
        EXPECT_NE(x, y) << name;
    }
    EXPECT_TRUE(method && none);
}

}  // namespace
