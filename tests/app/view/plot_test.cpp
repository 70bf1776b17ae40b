// Axes, ranges and quantiles of plots; numbers as text.
#include "app/view/ui/plot.h"

#include <cmath>

#include <gtest/gtest.h>

#include "app/view/ui/scale.h"
#include "app/view/ui/ui_text.h"
#include "tests/support/statistics/no_numbers.h"

namespace {

using tests::kDoubleNan;

std::vector<std::string> majors(const app::LogRange& range, int most)
{
    std::vector<std::string> texts;
    for (const app::LogTick& tick : app::logTicks(range, most)) {
        EXPECT_GE(tick.value, range.low);
        EXPECT_LE(tick.value, range.high);
        EXPECT_EQ(tick.major, !tick.text.empty());
        if (tick.major) texts.push_back(tick.text);
    }
    return texts;
}

TEST(LogTicks, PowersOfTenWhereThereAreSome)
{
    EXPECT_EQ(majors({0.05, 200}, 10), (std::vector<std::string>{"0.1", "1", "10", "100"}));
    // One to nine in every decade: 5..9, three times nine, 1 and 2.
    EXPECT_EQ(app::logTicks({0.05, 200}, 10).size(), 34u);
}

TEST(LogTicks, FinerWithinADecade)
{
    EXPECT_EQ(majors({1.5, 8}, 10), (std::vector<std::string>{"2", "5"}));
    EXPECT_EQ(majors({0.04, 0.3}, 10), (std::vector<std::string>{"0.05", "0.1", "0.2"}));
}

TEST(LogTicks, FewerOverManyDecades)
{
    const auto texts = majors({1e-6, 1.5e6}, 5);
    EXPECT_LE(texts.size(), 5u);
    EXPECT_GE(texts.size(), 3u);
}

TEST(LogTicks, TwoAtLeastHaveTheirText)
{
    EXPECT_EQ(majors({2.2, 4.8}, 10), (std::vector<std::string>{"3", "4"}));
    EXPECT_EQ(majors({1.1, 2.8}, 10), (std::vector<std::string>{"1.5", "2", "2.5"}));
    EXPECT_EQ(majors({0.6, 12}, 10), (std::vector<std::string>{"1", "10"}));
    EXPECT_EQ(majors({5.5, 10.5}, 3), (std::vector<std::string>{"6", "8", "10"})) << "room for 3";
    for (double low = 1; low < 10; low *= 1.01)
        for (const double factor : {2.51, 5.0, 30.0, 700.0, 1e5})
            EXPECT_GE(majors({low, low * factor}, 2).size(), 2u) << low << " times " << factor;
}

TEST(CurveColours, StayWithTheirCurves)
{
    app::CurveColours colours;
    const std::vector<double> two{3.5, 4.5}, next{4.5, 5.5, 6.5};
    colours.keep(two);
    const size_t kept = colours.of(4.5);
    EXPECT_NE(colours.of(3.5), kept);
    colours.keep(next);
    EXPECT_EQ(colours.of(4.5), kept);
    EXPECT_EQ(colours.of(5.5), 0u) << "free again";
    EXPECT_NE(colours.of(6.5), colours.of(5.5));
    EXPECT_NE(colours.of(6.5), kept);
}

TEST(LogRange, FractionsAndValuesAreInverse)
{
    const app::LogRange range{0.02, 50};
    EXPECT_DOUBLE_EQ(range.fraction(range.low), 0);
    EXPECT_DOUBLE_EQ(range.fraction(range.high), 1);
    EXPECT_NEAR(range.fraction(1), 0.5, 1e-12);
    for (const double t : {-0.5, 0.0, 0.3, 1.0, 2.0})
        EXPECT_NEAR(range.fraction(range.value(t)), t, 1e-12);
}

TEST(LogRanges, HoldEverythingThatIsDrawn)
{
    app::LogPlot plot;
    app::LogRange x, y;
    app::logRanges(plot, x, y);
    EXPECT_LT(x.low, x.high);
    EXPECT_LT(y.low, y.high);

    plot.curves.push_back(
        {"a",
         {{0.1, 3, 0.1}, {4, 0.2, 0}, {0, 9, 0}, {5, kDoubleNan, 0}, {HUGE_VAL, 1, 0}},
         {},
         false});
    plot.floor = 0.01;
    plot.target = 7;
    app::logRanges(plot, x, y);
    EXPECT_LT(x.low, 0.1);
    EXPECT_GT(x.high, 4);
    EXPECT_LT(x.high, 8) << "what cannot be drawn makes no room";
    EXPECT_LT(y.low, 0.01);
    EXPECT_GT(y.high, 7);

    app::LogPlot point;
    point.curves.push_back({"b", {{1, 1, 0}}, {}, false});
    app::logRanges(point, x, y);
    EXPECT_GE(x.high / x.low, 2);
    EXPECT_NEAR(x.fraction(1), 0.5, 1e-12);
}

std::vector<std::string> scaleTexts(const app::Scale& scale, int count)
{
    std::vector<std::string> texts;
    for (const app::ScaleNumber& number : app::scaleNumbers(scale, count)) {
        EXPECT_GE(number.at, 0);
        EXPECT_LE(number.at, 1);
        texts.push_back(number.text);
    }
    return texts;
}

TEST(ScaleNumbers, CountsAreWholeAndComeOnce)
{
    const auto counts = [](float high) {
        return app::Scale{.shown = true, .low = 0, .high = high, .label = "", .whole = true};
    };
    EXPECT_EQ(scaleTexts(counts(2), 5), (std::vector<std::string>{"0", "1", "2"}));
    EXPECT_EQ(scaleTexts(counts(1), 5), (std::vector<std::string>{"0", "1"}));
    EXPECT_EQ(scaleTexts(counts(64), 5), (std::vector<std::string>{"0", "16", "32", "48", "64"}));
    EXPECT_EQ(scaleTexts({.shown = true, .low = 0, .high = 2, .label = ""}, 3),
              (std::vector<std::string>{"0.00", "1.00", "2.00"}));
}

/// The texts at the ends lie within the scale and so come closer to their neighbours.
TEST(ScaleNumbers, NeighboursAtTheEndsDoNotTouch)
{
    const app::Scale scale{.shown = true, .low = 0, .high = 1, .label = ""};
    const auto three = app::scaleNumbers(scale, 3);
    const std::vector<float> widths{60, 60, 60};
    EXPECT_FALSE(app::stayApart(three, widths, 185, 4)) << "60..62 is less than the gap";
    EXPECT_TRUE(app::stayApart(three, widths, 190, 4));
    EXPECT_TRUE(app::stayApart(app::scaleNumbers(scale, 2), {60, 60}, 130, 4));
    EXPECT_FALSE(app::stayApart(app::scaleNumbers(scale, 5), {30, 30, 30, 30, 30}, 185, 4))
        << "30 and 31 at the left end, though all have room by their sum";
}

TEST(Quantile, NearestRank)
{
    EXPECT_EQ(app::quantile({}, 0.5), 0);
    const std::vector<float> values{5, 1, 4, 2, 3};
    EXPECT_EQ(app::quantile(values, 0.5), 3);
    EXPECT_EQ(app::quantile(values, 0.99), 5);
    EXPECT_EQ(app::quantile(values, 0), 1);
    EXPECT_EQ(app::quantile(values, 0.2), 1);
    EXPECT_EQ(app::quantile(values, 0.21), 2);
}

TEST(NumbersAsText, ThreeDigitsAndUnits)
{
    EXPECT_EQ(app::countText(0), "0");
    EXPECT_EQ(app::countText(950), "950");
    EXPECT_EQ(app::countText(999.6), "1.00 k");
    EXPECT_EQ(app::countText(12345), "12.3 k");
    EXPECT_EQ(app::countText(999600), "1.00 M");
    EXPECT_EQ(app::countText(4.5678e6), "4.57 M");
    EXPECT_EQ(app::countText(kDoubleNan), "-");
    EXPECT_EQ(app::countedText(1, "emitter"), "1 emitter");
    EXPECT_EQ(app::countedText(12345, "triangle"), "12.3 k triangles");
    EXPECT_EQ(app::bytesText(1023), "1023 B");
    EXPECT_EQ(app::bytesText(1024), "1.00 KiB");
    EXPECT_EQ(app::bytesText(1000 * 1024), "0.98 MiB");
    EXPECT_EQ(app::bytesText(5ull << 30), "5.00 GiB");
    EXPECT_EQ(app::secondsText(0), "0 s");
    EXPECT_EQ(app::secondsText(0.0032), "3.2 ms");
    EXPECT_EQ(app::secondsText(0.42), "0.42 s");
    EXPECT_EQ(app::secondsText(12.34), "12.3 s");
    EXPECT_EQ(app::secondsText(245), "4:05");
    EXPECT_EQ(app::secondsText(59.96 * 60), "59:58");
    EXPECT_EQ(app::secondsText(7384), "2:03:04");
    EXPECT_EQ(app::secondsText(HUGE_VAL), "-");
    EXPECT_EQ(app::digitsText(0.012345), "0.0123");
}

TEST(Legend, NamesThePresentCurveFirstAndNothingThatIsNotDrawn)
{
    app::LogPlot plot;
    EXPECT_TRUE(app::legendOrder(plot, 4).empty());
    for (int i = 0; i < 5; ++i) {
        plot.curves.push_back({std::to_string(i), {{1, 1}}, {}, false});
        if (i == 2) plot.curves.back().points = {{0, 1}, {1, kDoubleNan}};  // nothing of it is seen
    }
    EXPECT_EQ(app::legendOrder(plot, 9), (std::vector<size_t>{4, 3, 1, 0}));
    EXPECT_EQ(app::legendOrder(plot, 2), (std::vector<size_t>{4, 3}));
}

}  // namespace
