// The tests' own instruments against values of tables (and closed forms), and their false-alarm
// rates.
#include "tests/support/statistics/stats.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace tests {
namespace {

TEST(Stats, gammaQHasClosedForms)
{
    for (double x : {0.01, 0.5, 1.0, 3.0, 20.0, 200.0}) {
        EXPECT_NEAR(regularizedGammaQ(1, x), std::exp(-x), 1e-13);
        EXPECT_NEAR(regularizedGammaQ(0.5, x), std::erfc(std::sqrt(x)), 1e-13);
        EXPECT_NEAR(regularizedGammaQ(3, x), std::exp(-x) * (1 + x + x * x / 2), 1e-13);
    }
    EXPECT_NEAR(regularizedGammaQ(5e5, 5e5), 0.5, 5e-4);
}

TEST(Stats, chiSquareMatchesTables)
{
    EXPECT_NEAR(chiSquareP(3.841458821, 1), 0.05, 1e-9);
    EXPECT_NEAR(chiSquareP(18.30703805, 10), 0.05, 1e-9);
    EXPECT_NEAR(chiSquareP(149.4492528, 100), 0.001, 1e-9);
}

TEST(Stats, betaHasClosedForms)
{
    for (double x : {0.1, 0.5, 0.93}) {
        EXPECT_NEAR(regularizedBeta(1, 1, x), x, 1e-13);
        EXPECT_NEAR(regularizedBeta(2, 3, x), x * x * (6 - 8 * x + 3 * x * x), 1e-13);
        EXPECT_NEAR(regularizedBeta(0.5, 0.5, x), 2 / std::acos(-1.0) * std::asin(std::sqrt(x)),
                    1e-12);
    }
}

TEST(Stats, studentAndNormalMatchTables)
{
    EXPECT_NEAR(studentTwoSidedP(2.228138852, 10), 0.05, 1e-9);
    EXPECT_NEAR(studentTwoSidedP(4.21, 1e7), normalTwoSidedP(4.21), 1e-9);
    EXPECT_NEAR(normalTwoSidedP(1.959963985), 0.05, 1e-9);
    EXPECT_NEAR(normalQuantile(0.975), 1.959963985, 1e-8);
    EXPECT_NEAR(normalQuantile(1e-10), -6.361340902, 1e-8);
    for (double p : {1e-300, 1e-12, 0.3, 0.5, 0.999}) {
        EXPECT_NEAR(0.5 * std::erfc(-normalQuantile(p) / std::sqrt(2.0)) / p, 1, 1e-9);
    }
}

TEST(Stats, levelsAgree)
{
    EXPECT_NEAR(sidak(0.01, 400), kLevel, 2e-7);
    EXPECT_NEAR(normalTwoSidedP(kScore), kLevel, 1e-6);
}

TEST(Stats, chiSquarePoolsRareCellsAndCountsForbiddenOnes)
{
    std::vector<double> expected = {100, 1, 2, 3, 0, 50};
    std::vector<double> observed = {110, 2, 2, 2, 7, 44};
    ChiSquare r = chiSquareTest(observed, expected);
    EXPECT_EQ(r.outside, 7);
    EXPECT_EQ(r.degreesOfFreedom, 3);  // {1,2,3} together
    EXPECT_NEAR(r.statistic, 1.0 + 36.0 / 50.0, 1e-12);
}

TEST(Stats, momentsMergeLikeOneSeries)
{
    Moments whole;
    Moments parts[2];
    for (int i = 0; i < 1000; ++i) {
        double x = std::sin(i) + (i % 7);
        whole.add(x);
        parts[i % 3 == 0 ? 1 : 0].add(x);
    }
    parts[0].merge(parts[1]);
    EXPECT_NEAR(parts[0].mean(), whole.mean(), 1e-12);
    EXPECT_NEAR(parts[0].variance(), whole.variance(), 1e-10);
}

TEST(Stats, welchHasUniformPValuesAndSeesABias)
{
    std::mt19937 engine(7);
    std::exponential_distribution<double> wide(0.5);
    std::normal_distribution<double> narrow(2.0, 0.3);
    std::vector<double> values;
    for (int run = 0; run < 400; ++run) {
        Moments a;
        Moments b;
        for (int i = 0; i < 500; ++i) {
            a.add(wide(engine));
            b.add(narrow(engine));
        }
        values.push_back(welch(a, b).p);
    }
    EXPECT_GT(kolmogorovUniformP(values), 1e-3);
    Moments a;
    Moments b;
    for (int i = 0; i < 100000; ++i) {
        a.add(wide(engine));
        b.add(narrow(engine) * 1.05);
    }
    Comparison c = welch(a, b);
    EXPECT_LT(c.detectable, 0.05);
    EXPECT_LT(c.p, kLevel);
}

TEST(Stats, kolmogorovMatchesItsTableAndRejectsASquare)
{
    // Critical value 1.3581 at 5 % in the limit.
    std::vector<double> values(10000);
    double n = 10000;
    for (int i = 0; i < 10000; ++i) {
        values[static_cast<std::size_t>(i)] = std::min(1.0, (i + 0.5) / n + 1.3581 / 100 - 0.5 / n);
    }
    EXPECT_NEAR(kolmogorovUniformP(values), 0.05, 2e-3);
    for (double& v : values) v = v * v;
    EXPECT_LT(kolmogorovUniformP(values), 1e-12);
}

}  // namespace
}  // namespace tests
