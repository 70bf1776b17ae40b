// Errors as text: digits by the standard error, and the reference's noise wherever it shows.
#include "app/pictures/error_text.h"

#include <cmath>

#include <gtest/gtest.h>

#include "app/pictures/picture_comparison.h"

namespace {

TEST(ErrorText, DigitsAreThoseThatTheErrorLeaves)
{
    EXPECT_EQ(app::rmseText(0.119123, 0.0012, 0), "0.119 ± 0.001");
    EXPECT_EQ(app::rmseText(0.119123, 0.00012, 0), "0.1191 ± 0.0001");
    EXPECT_EQ(app::rmseText(0.119123, 0.03, 0), "0.12 ± 0.03");
    EXPECT_EQ(app::rmseText(0.119123, 0, 0), "0.119");
}

TEST(ErrorText, AnIntervalAndItsValueHaveTheDigitsOfTheError)
{
    EXPECT_EQ(app::digitsByError(0.119123, 0.0012), "0.119");
    EXPECT_EQ(app::digitsByError(0.119123, 0), "0.119");
    EXPECT_EQ(app::boundedText({0.112, 0.0987, 0.117}), "0.112 (0.099 to 0.117)");
    EXPECT_EQ(app::boundedText({0.371, 0.328, 0.398}), "0.37 (0.33 to 0.40)");
    EXPECT_EQ(app::boundedText({1.86, 1.67, 2.41}), "1.9 (1.7 to 2.4)");
    EXPECT_EQ(app::boundedText({1.86, 0, HUGE_VAL}), "unknown");
}

TEST(ErrorText, ANoisyReferenceIsSaidWhereItShows)
{
    EXPECT_EQ(app::rmseText(0.119, 0.001, 0.114), "≤ 0.119, reference noise 0.114");
    EXPECT_EQ(app::rmseText(0.1, 0.0001, 0.0999), "≤ 0.100, reference noise 0.0999");
    // Noise of a twentieth adds an eighth of a per cent, one of a fifth adds two.
    EXPECT_EQ(app::rmseText(0.1, 0.0001, 0.005), "0.1000 ± 0.0001");
    EXPECT_EQ(app::rmseText(0.1, 0.0001, 0.02), "≤ 0.100, reference noise 0.0200");
    EXPECT_EQ(app::rmseText(0.1, 0.005, 0.02), "0.100 ± 0.005") << "less than is known";
    EXPECT_TRUE(app::noiseShows(0.1, 0.001, 0.2)) << "more noise than error: an upper bound all "
                                                     "the same";
}

TEST(ErrorText, PointsSayWhatTheyAreMeasuredBy)
{
    app::ErrorPoint point;
    EXPECT_EQ(app::errorText(point, 0), "");
    point.estimated = 0.25;
    EXPECT_EQ(app::errorText(point, 0.1), "noise 0.250");
    point.rmse = 0.119;
    point.rmseSe = 0.001;
    EXPECT_EQ(app::errorText(point, 0.114), "RMSE ≤ 0.119, reference noise 0.114");
}

TEST(ErrorText, NoiseIsAPartOfTheMeanLuminanceWhereThatIsKnown)
{
    app::ErrorPoint point;
    point.estimated = 0.25;
    EXPECT_EQ(app::errorText(point, 0, 2), "noise 12.5 %");
    EXPECT_EQ(app::errorText(point, 0, 0), "noise 0.250");
    point.rmse = 0.119;
    EXPECT_EQ(app::errorText(point, 0, 2), "RMSE 0.119");
    core::Image picture(2, 2, 3);
    picture.pixels.assign(12, 0.5f);
    EXPECT_NEAR(app::meanLuminance(picture), 0.5, 1e-6);
    picture.pixels[4] = NAN;
    EXPECT_NEAR(app::meanLuminance(picture), 0.5, 1e-6);
    EXPECT_EQ(app::meanLuminance(core::Image()), 0);
}

}  // namespace
