// Which frames the window draws while the camera moves: those with something new, and of the others
// so few that pictures get most of the time.
#include <gtest/gtest.h>

#include "app/view/frame_pace.h"

namespace {

using app::FrameNews;
using app::isWorthDrawing;

TEST(FramePace, WhatIsNewIsDrawnAtOnce)
{
    for (const FrameNews& news :
         {FrameNews{.picture = true}, FrameNews{.panel = true}, FrameNews{.layout = true}})
        EXPECT_TRUE(isWorthDrawing(news, 0, 0.02));
}

TEST(FramePace, WithoutNewsDrawingGetsAQuarterOfTheTime)
{
    constexpr double kDraw = 0.01, kTick = 0.001;
    double drawing = 0, sinceDraw = 0;
    int ticks = 0;
    for (; ticks < 10'000; ++ticks) {
        sinceDraw += kTick;
        if (!isWorthDrawing({}, sinceDraw, kDraw)) continue;
        drawing += kDraw;
        sinceDraw = 0;
    }
    const double share = drawing / (ticks * kTick + drawing);
    EXPECT_GT(share, 0.2) << "the panel goes on";
    EXPECT_LE(share, 0.25);
}

TEST(FramePace, AQuickDeviceDrawsEveryFrame)
{
    EXPECT_TRUE(isWorthDrawing({}, 1.0 / 60, 0.001));
}

}  // namespace
