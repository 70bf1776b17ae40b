// What exposure pictures ask for whose brightness is known.
#include "app/pictures/metering.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/base/pcg32.h"

namespace {

core::Image grey(uint32_t width, uint32_t height, float value)
{
    core::Image image(width, height, 3);
    for (float& v : image.pixels) v = value;
    return image;
}

TEST(Metering, TheMiddleBecomesMidGrey)
{
    for (const int stops : {-9, -3, 0, 1, 7}) {
        const float value = 0.18f * std::exp2(static_cast<float>(-stops));
        for (const uint32_t side : {1u, 3u, 64u, 200u}) {
            const auto metered = app::meteredStops(grey(side, (side + 1) / 2, value));
            ASSERT_TRUE(metered.has_value());
            EXPECT_NEAR(*metered, static_cast<float>(stops), 1e-4f) << side;
        }
    }
    EXPECT_EQ(app::meteredStops(grey(9, 9, 1e-20f)), 20.0f) << "as far as the display goes";
    EXPECT_EQ(app::meteredStops(grey(9, 9, 1e20f)), -20.0f);
}

/// Lamps, the black around a box, and pixels that are no numbers.
TEST(Metering, WhatIsNotTheMiddleDoesNotCount)
{
    core::Image image = grey(640, 360, 0.18f);
    for (uint32_t y = 0; y < 360; ++y)
        for (uint32_t x = 0; x < 640; ++x) {
            float* p = image.at(x, y);
            if (x < 400)
                p[0] = p[1] = p[2] = 0;  // black
            else if (y < 100)
                p[0] = p[1] = p[2] = 1e4f;  // a lamp
            else if ((x + y) % 7 == 0)
                p[1] = NAN;
            else if ((x + y) % 7 == 1)
                p[2] = std::numeric_limits<float>::infinity();
        }
    const auto metered = app::meteredStops(image);
    ASSERT_TRUE(metered.has_value());
    EXPECT_NEAR(*metered, 0, 1e-4f);
}

/// One pixel of thirty has all of the light, as in first samples of a dark room.
TEST(Metering, NoiseHidesNoMiddle)
{
    core::Pcg32 random(3);
    core::Image image = grey(900, 700, 0);
    for (uint32_t y = 0; y < 700; ++y)
        for (uint32_t x = 0; x < 900; ++x)
            if (random() < 1 / 30.0)
                image.at(x, y)[0] = image.at(x, y)[1] = image.at(x, y)[2] = 5.4f;
    const auto metered = app::meteredStops(image);
    ASSERT_TRUE(metered.has_value());
    EXPECT_NEAR(*metered, 0, 0.15f);
}

TEST(Metering, WithoutLightThereIsNone)
{
    EXPECT_FALSE(app::meteredStops(grey(20, 10, 0)));
    EXPECT_FALSE(app::meteredStops(grey(20, 10, NAN)));
    EXPECT_FALSE(app::meteredStops(core::Image(0, 0, 3)));
    EXPECT_FALSE(app::meteredStops(core::Image(8, 8, 1)));
}

}  // namespace
