// Plots of the laboratory's report: ticks are round and cover what is shown, points that are not
// finite are left out.
#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/lab/results.h"
#include "app/report/svg.h"
#include "app/report/text.h"
#include "tests/support/files/markup.h"
#include "tests/support/files/pattern.h"
#include "tests/support/files/text_search.h"

namespace app::lab {
namespace {

using namespace report;
using tests::contains;
using tests::readMarkup;

TEST(Markup, CheckerSeesFaults)
{
    const auto problem = [](const std::string& body) {
        return readMarkup("<!DOCTYPE html>\n" + body).problem;
    };
    EXPECT_EQ(problem("<p class=\"a\">x &amp; y<br></p>"), "");
    EXPECT_NE(problem("<p><b>x</p></b>"), "");
    EXPECT_NE(problem("<p>"), "");
    EXPECT_NE(problem("</p>"), "");
    EXPECT_NE(problem("<p>1 < 2</p>"), "");
    EXPECT_NE(problem("<p>a & b</p>"), "");
    EXPECT_NE(problem("<p id=\"a\"></p><p id=\"a\"></p>"), "");
    EXPECT_NE(problem("<p class=a></p>"), "");
}

/// 1, 2 or 5 times a power of ten.
bool isRound(double x)
{
    const double mantissa = x / std::pow(10.0, std::floor(std::log10(x) + 1e-6));
    return std::abs(mantissa - 1) < 1e-6 || std::abs(mantissa - 2) < 1e-6 ||
           std::abs(mantissa - 5) < 1e-6;
}

void expectGoodTicks(const std::vector<Tick>& ticks, double low, double high, bool log)
{
    ASSERT_GE(ticks.size(), 3u);
    EXPECT_LE(ticks.size(), 16u);
    const double slack = 1e-6 * std::max(std::abs(low), std::abs(high));
    EXPECT_LE(ticks.front().value, low + slack);
    EXPECT_GE(ticks.back().value, high - slack);
    std::set<std::string> labels;
    const double step = ticks[1].value - ticks[0].value;
    bool multiples = isRound(step), round = true;
    for (size_t i = 0; i < ticks.size(); ++i) {
        labels.insert(ticks[i].label);
        const double wanted = ticks[0].value + static_cast<double>(i) * step;
        const double multiple = ticks[i].value / step;
        multiples = multiples && std::abs(ticks[i].value - wanted) < 1e-5 * step &&
                    std::abs(multiple - std::round(multiple)) < 1e-5;
        round = round && ticks[i].value > 0 && isRound(ticks[i].value) &&
                (i == 0 || ticks[i - 1].value < ticks[i].value);
    }
    EXPECT_EQ(labels.size(), ticks.size()) << "two ticks with one label";
    EXPECT_TRUE(multiples || (log && round));
    if (log) {
        EXPECT_GT(ticks.front().value, 0);
    }
}

TEST(LabPlot, TicksAreRoundAndCoverTheRange)
{
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(-1, 1), decade(-6, 6), width(-4, 1);
    for (int i = 0; i < 20000; ++i) {
        const double scale = std::pow(10.0, decade(random)), low = place(random) * scale;
        const double high = low + scale * std::pow(10.0, width(random));
        SCOPED_TRACE(std::to_string(low) + " to " + std::to_string(high));
        expectGoodTicks(linearTicks(low, high), low, high, false);
        const double first = scale, last = scale * std::pow(10.0, 6 * std::abs(place(random)));
        SCOPED_TRACE("log " + std::to_string(first) + " to " + std::to_string(last));
        expectGoodTicks(logTicks(first, last), std::min(first, last), last, true);
        if (HasFailure()) break;
    }
}

TEST(LabPlot, AnyRangeGivesAnAxis)
{
    const double odd[] = {kUnknown, kInfinite, -kInfinite, 0, -1, 1, 1e-300, 1e300, 5e-324};
    for (const double low : odd)
        for (const double high : odd)
            for (const Axis& axis : {linearAxis("", low, high), logAxis("", low, high)}) {
                SCOPED_TRACE(std::to_string(low) + " to " + std::to_string(high));
                ASSERT_GE(axis.ticks.size(), 3u);
                EXPECT_LE(axis.ticks.size(), 20u);
                EXPECT_LT(axis.low, axis.high);
                EXPECT_NEAR(axis.at(axis.low), 0, 1e-9);
                EXPECT_NEAR(axis.at(axis.high), 1, 1e-9);
            }
}

TEST(LabPlot, LabelsSayTheValue)
{
    const auto labels = [](const std::vector<Tick>& ticks) {
        std::string all;
        for (const Tick& tick : ticks) all += (all.empty() ? "" : " ") + tick.label;
        return all;
    };
    EXPECT_EQ(labels(linearTicks(0, 1)), "0.0 0.2 0.4 0.6 0.8 1.0");
    EXPECT_EQ(labels(linearTicks(-7, 12)), "−10 −5 0 5 10 15");
    EXPECT_EQ(labels(logTicks(0.7, 40)), "0.5 1 2 5 10 20 50");
    EXPECT_EQ(labels(logTicks(2e-5, 3)), "10⁻⁵ 10⁻⁴ 0.001 0.01 0.1 1 10");
    EXPECT_EQ(shortNumber(0.8359), "0.836");
    EXPECT_EQ(shortNumber(12.76), "12.8");
    EXPECT_EQ(shortNumber(9.996), "10.0");
    EXPECT_EQ(shortNumber(-0.5, 1), "−0.5");
    EXPECT_EQ(shortNumber(2.13e-5), "2.13·10⁻⁵");
    EXPECT_EQ(shortNumber(0), "0");
    EXPECT_EQ(shortNumber(kInfinite), "∞");
    EXPECT_EQ(shortNumber(-kInfinite), "−∞");
    EXPECT_EQ(shortNumber(kUnknown), "–");
}

TEST(LabPlot, PointsThatAreNoneLeaveNothing)
{
    Plot plot("T & Q", linearAxis("x", 0, 4), logAxis("y", 1, 100), 300, 200);
    const std::vector<Point> points{{0, 1},  {1, 10},  {kUnknown, 2},
                                    {2, -5}, {3, 100}, {4, kInfinite}};
    plot.curve(points, "c-blue");
    plot.markers(points, Shape::diamond, "c-blue");
    plot.errorBars(points, {0.5, 20, 1, 1, kUnknown, 1}, "c-blue");
    plot.legend({"one", "c-blue", true, true});
    const std::string svg = plot.element();
    EXPECT_EQ(readMarkup("\n" + svg).problem, "");
    EXPECT_TRUE(contains(svg, "T &amp; Q"));
    EXPECT_FALSE(contains(svg, "nan"));
    EXPECT_FALSE(contains(svg, "inf"));
    // Three points are left, in two pieces; each has a marker, and the legend has one.
    EXPECT_EQ(tests::Pattern("class=\"dot c-blue\"").findAll(svg).size(), 4u);
    const auto curve = tests::Pattern("d=\"([^\"]*)\" class=\"curve c-blue\"").find(svg);
    ASSERT_TRUE(curve);
    const std::string& path = curve->at(1);
    EXPECT_EQ(std::count(path.begin(), path.end(), 'M'), 2);
    EXPECT_EQ(std::count(path.begin(), path.end(), 'L'), 1);
}

}  // namespace
}  // namespace app::lab
