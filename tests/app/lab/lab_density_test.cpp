// The densities of the one-dimensional laboratory: pdf, cdf and inverse against each other and
// against chi-square, crossings and suprema of ratios against what a fine scan finds.
#include "app/lab/pairs.h"
#include "app/lab/theory.h"
#include "core/base/pcg32.h"
#include "tests/support/statistics/stats.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <utility>
#include <vector>

namespace tests {
namespace {

using app::lab::Density;
using app::lab::kInfinite;
using app::lab::Pair;
using app::lab::pairs;

std::vector<std::pair<std::string, Density>> densities()
{
    std::vector<std::pair<std::string, Density>> all;
    for (const Pair& pair : pairs()) {
        all.emplace_back(std::string(pair.id) + " q", pair.q);
        all.emplace_back(std::string(pair.id) + " p", pair.p);
    }
    all.emplace_back("lobe beyond the end", Density::cauchy(1.2, .3));
    return all;
}

TEST(LabDensity, CdfIsTheIntegralOfThePdf)
{
    core::Pcg32 random(1);
    for (const auto& named : densities()) {
        const std::string& name = named.first;
        const Density& d = named.second;
        EXPECT_EQ(d.cdf(0), 0) << name;
        EXPECT_EQ(d.cdf(1), 1) << name;
        EXPECT_NEAR(
            app::lab::integrate({0, d.low(), d.high(), 1}, [&](double x) { return d.pdf(x); }), 1,
            1e-11)
            << name;
        for (int i = 0; i < 20; ++i) {
            double a = random(), b = random();
            if (a > b) std::swap(a, b);
            std::vector<double> breaks{a, b};
            for (double end : {d.low(), d.high()})
                if (end > a && end < b) breaks.push_back(end);
            std::sort(breaks.begin(), breaks.end());
            const double mass = app::lab::integrate(breaks, [&](double x) { return d.pdf(x); });
            EXPECT_NEAR(d.cdf(b) - d.cdf(a), mass, 1e-11) << name << " on " << a << ", " << b;
        }
    }
}

TEST(LabDensity, VanishesOutsideItsSupport)
{
    for (const auto& [name, d] : densities()) {
        for (double x : {d.low() - 1e-9, d.high() + 1e-9, -1., 2., std::nan("")})
            EXPECT_EQ(d.pdf(x), 0) << name << " at " << x;
        EXPECT_GT(d.pdf((d.low() + d.high()) / 2), 0) << name;
    }
}

TEST(LabDensity, SampleInvertsTheCdf)
{
    for (const auto& [name, d] : densities()) {
        double before = -1;
        for (int i = 1; i < 1000; ++i) {
            const double xi = i / 1000., x = d.sample(xi);
            EXPECT_NEAR(d.cdf(x), xi, 1e-14) << name;
            EXPECT_GT(x, before) << name;
            before = x;
        }
    }
}

TEST(LabDensity, EveryRandomNumberGivesAUsableSample)
{
    for (const auto& [name, d] : densities()) {
        for (double xi : {0., 0x1p-64, 0x1p-32, .5, 1 - 0x1p-32, 1 - 0x1p-53}) {
            const double x = d.sample(xi);
            EXPECT_TRUE(x >= d.low() && x <= d.high()) << name << " at " << xi;
            const app::lab::Values f = app::lab::evaluateFunctions(x);
            for (double value : f.at) EXPECT_TRUE(std::isfinite(value)) << name << " at " << xi;
        }
        // The lower end may have no density; no sample falls on it. (The upper end of 2 - 2x has
        // none either, and is 2^-16 away for a generator with 32 bits.)
        EXPECT_GT(d.pdf(d.sample(0)), 0) << name;
        EXPECT_GT(d.pdf(d.sample(1 - 0x1p-32)), 0) << name;
    }
}

TEST(LabDensity, SamplesFollowTheCdf)
{
    constexpr size_t kCells = 50;
    constexpr int kSamples = 100000;
    for (const auto& [name, d] : densities()) {
        core::Pcg32 random(7);
        std::vector<double> observed(kCells), expected(kCells);
        for (int i = 0; i < kSamples; ++i)
            ++observed[std::min(static_cast<size_t>(d.sample(random()) * kCells), kCells - 1)];
        for (size_t i = 0; i < kCells; ++i) {
            const double low = static_cast<double>(i) / kCells;
            expected[i] = kSamples * (d.cdf(low + 1. / kCells) - d.cdf(low));
        }
        const ChiSquare result = chiSquareTest(observed, expected, 1);
        EXPECT_GT(result.p, kLevel) << name << ": " << result.statistic;
        EXPECT_EQ(result.outside, 0) << name;
    }
}

/// Whether (p - c q) has the sign `sign` or is 0 to rounding.
bool hasSign(const Pair& pair, double c, double x, bool positive)
{
    const double p = pair.p.pdf(x), cq = c * pair.q.pdf(x);
    return std::abs(p - cq) <= 1e-13 * (p + cq) || (p > cq) == positive;
}

TEST(LabDensity, BetweenCrossingsTheSignIsOne)
{
    for (const Pair& pair : pairs()) {
        for (double c : {0., 1e-6, .1, .3, .5, .7, .9, 1., 1.1, 1.5, 2., 3., 10., 100.}) {
            const std::vector<double> ends = app::lab::crossings(pair.q, pair.p, c);
            ASSERT_TRUE(std::is_sorted(ends.begin(), ends.end()));
            EXPECT_EQ(ends.front(), 0);
            EXPECT_EQ(ends.back(), 1);
            for (size_t i = 1; i < ends.size(); ++i) {
                const double low = ends[i - 1], length = ends[i] - low;
                const double middle = low + length / 2;
                const bool positive = pair.p.pdf(middle) > c * pair.q.pdf(middle);
                for (int j = 1; j < 400; ++j) {
                    EXPECT_TRUE(hasSign(pair, c, low + length * j / 400, positive))
                        << pair.id << " c " << c << " between " << low << " and " << ends[i];
                }
            }
        }
    }
}

TEST(LabDensity, CrossingsAreExact)
{
    int roots = 0;
    for (const Pair& pair : pairs()) {
        for (double c : {.05, .21, .37, .54, .83, 1.19, 1.7, 2.9, 40.}) {
            for (double x : app::lab::crossings(pair.q, pair.p, c)) {
                const bool edge = x == 0 || x == 1 || x == pair.q.low() || x == pair.q.high() ||
                                  x == pair.p.low() || x == pair.p.high();
                if (edge) continue;
                const auto difference = [&](double at) {
                    return pair.p.pdf(at) - c * pair.q.pdf(at);
                };
                EXPECT_LT(difference(x - 1e-14) * difference(x + 1e-14), 0)
                    << pair.id << " c " << c << " at " << x;
                ++roots;
            }
        }
    }
    EXPECT_GT(roots, 40);
    // Where only one of the two is defined there is nothing to cross: 2x = .2 at .1 is none.
    const std::vector<double> none{0, .5, 1};
    EXPECT_EQ(app::lab::crossings(Density::uniform(.5, 1), Density::linearUp(), .1), none);
}

TEST(LabDensity, SupremaBoundTheRatioAndAreAttained)
{
    for (const Pair& pair : pairs()) {
        for (bool rejection : {true, false}) {
            const Density& above = rejection ? pair.p : pair.q;
            const Density& below = rejection ? pair.q : pair.p;
            const double supremum = app::lab::supremumOfRatio(above, below);
            double largest = 0;
            for (int i = 0; i <= 100000; ++i) {
                const double x = i / 100000.;
                if (above.pdf(x) > 0) largest = std::max(largest, above.pdf(x) / below.pdf(x));
            }
            if (largest == kInfinite) {
                EXPECT_EQ(supremum, kInfinite) << pair.id;
            } else {
                EXPECT_GE(supremum * (1 + 1e-14), largest) << pair.id;
                EXPECT_NEAR(supremum, largest, 1e-6 * largest) << pair.id;
            }
        }
    }
    const Density up = Density::linearUp(), down = Density::linearDown();
    EXPECT_EQ(app::lab::supremumOfRatio(up, up), 1);  // both vanish at 0
    EXPECT_EQ(app::lab::supremumOfRatio(down, down), 1);
    EXPECT_EQ(app::lab::supremumOfRatio(Density::uniform(.2, .4), up), 5 / .4);
    EXPECT_EQ(app::lab::supremumOfRatio(up, Density::uniform(.2, 1)), kInfinite);
}

}  // namespace
}  // namespace tests
