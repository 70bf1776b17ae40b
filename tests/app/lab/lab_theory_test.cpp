// What the formulas of the laboratory give, against closed forms and against the expected table.
#include "app/lab/theory.h"
#include "core/base/pcg32.h"
#include "tests/support/methods/lab_table.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace tests {
namespace {

using app::lab::Beta;
using app::lab::Cell;
using app::lab::Density;
using app::lab::Expectation;
using app::lab::functions;
using app::lab::integrate;
using app::lab::kExactResidual;
using app::lab::kFunctions;
using app::lab::Pair;
using app::lab::pairOf;
using app::lab::pairs;
using app::lab::Values;

size_t functionOf(const std::string& id)
{
    return static_cast<size_t>(id.at(1) - '1');
}

/// A cell with N = 8, at the best c.
Cell theoryCell(const std::string& pair, const std::string& function, const std::string& method,
                uint32_t k = 0, Beta beta = Beta::none, uint32_t n = 8)
{
    Cell cell;
    cell.pair = pair;
    cell.function = function;
    cell.method = method;
    cell.beta = beta;
    cell.oldSamples = 8;
    cell.newSamples = n;
    cell.candidates = k;
    cell.c = pairOf(pair).bestC(8, n);
    return cell;
}

/// The cell of a column of the table.
Cell theoryCell(const LabRow& row, LabColumn column)
{
    const auto make = [&](const char* method, uint32_t k = 0, Beta beta = Beta::none) {
        return theoryCell(row.pair, row.function, method, k, beta);
    };
    switch (column) {
    case kDiscard:
        return make("discard");
    case kReweighting:
        return make("reweighting");
    case kRa1:
        return make("ra", 1);
    case kRa4:
        return make("ra", 4);
    case kRaExact:
        return make("ra", kExactResidual);
    case kRejectionAugmentation:
        return make("rejection-augmentation");
    case kMis:
        return make("mis");
    case kRa4Ideal:
        return make("ra", 4, Beta::ideal);
    default:
        return make("mis", 0, Beta::ideal);
    }
}

double varianceOf(const LabRow& row, LabColumn column)
{
    return app::lab::expectation(theoryCell(row, column)).variance;
}

std::string nameOf(const LabRow& row)
{
    return std::string(row.pair) + "-" + row.function;
}

/// Four digits were printed.
void expectPrinted(double value, double printed, const std::string& what)
{
    if (std::isinf(printed)) {
        EXPECT_EQ(value, printed) << what;
    } else {
        EXPECT_NEAR(value, printed, 6e-4 * printed) << what;
    }
}

// --- functions, quadrature, pairs

TEST(LabTheory, IntegratesPowersWithSingularEnds)
{
    for (double power : {-.75, -.5, -.25, .25, .75, 1., 2.5, 7.}) {
        const double exact = 1 / (power + 1);
        const auto h = [power](double x) { return std::pow(x, power); };
        EXPECT_NEAR(integrate({0, 1}, h), exact, 1e-12 * exact) << power;
        EXPECT_NEAR(integrate({0, .3, .6, 1}, h), exact, 1e-12 * exact) << power;
    }
    EXPECT_NEAR(integrate({0, 1}, [](double x) { return 1 / std::sqrt(x * (1 - x)); }),
                std::numbers::pi, 1e-9);
    EXPECT_EQ(integrate({.5, .5}, [](double) { return 1.; }), 0);
}

TEST(LabTheory, FunctionIntegralsAreExact)
{
    core::Pcg32 random(3);
    for (int i = 0; i < 40; ++i) {
        double a = i == 0 ? 0 : random(), b = i == 0 ? 1 : random();
        if (a > b) std::swap(a, b);
        std::vector<double> breaks{a, b};
        for (double jump : {.3, .6})
            if (jump > a && jump < b) breaks.push_back(jump);
        std::sort(breaks.begin(), breaks.end());
        const Values exact = app::lab::integrateFunctions(a, b);
        for (size_t f = 0; f < kFunctions; ++f) {
            const double sum =
                integrate(breaks, [f](double x) { return app::lab::evaluateFunctions(x)[f]; });
            EXPECT_NEAR(sum, exact[f], 1e-12) << functions()[f].id << " on " << a << ", " << b;
        }
    }
}

TEST(LabTheory, FunctionsAreTheOnesStated)
{
    const double firstMoments[] = {1, 1, 1, 1, .274307021, .275711358, 1, 1};
    const double secondMoments[] = {1,         4. / 3,    1.233701, 10. / 3,
                                    .15654175, .17370193, 1.405,    9. / 8};
    const Values integral = app::lab::integrateFunctions(0, 1);
    for (size_t f = 0; f < kFunctions; ++f) {
        EXPECT_NEAR(integral[f], firstMoments[f], 6e-10) << functions()[f].id;
        const double second = integrate({0, .3, .6, 1}, [f](double x) {
            const double value = app::lab::evaluateFunctions(x)[f];
            return value * value;
        });
        EXPECT_NEAR(second, secondMoments[f], 6e-7) << functions()[f].id;
    }
    const double inD9[] = {.6, .84, .654508, 2. / 3, .233492, .200596, .6, .497027};
    const Values truth = pairOf("D9").truth();
    for (size_t f = 0; f < kFunctions; ++f) EXPECT_NEAR(truth[f], inD9[f], 6e-7);
}

TEST(LabTheory, ResidualMassHasTheClosedForms)
{
    for (double c = 0; c < 4; c += .0625) {
        EXPECT_NEAR(pairOf("D1").residual(c), std::max(1 - c, 0.), 1e-12) << c;
        EXPECT_NEAR(pairOf("D6").residual(c), c < 2 ? (1 - c / 2) * (1 - c / 2) : 0, 1e-12) << c;
        EXPECT_NEAR(pairOf("D7").residual(c), 1 / (1 + c), 1e-12) << c;
        EXPECT_NEAR(pairOf("D9").residual(c), 1 - std::min(c, 1.) / 3, 1e-12) << c;
    }
    for (const Pair& pair : pairs()) {
        for (double c : {.2, .7, 1., 1.8, 3.}) {
            const double sum = integrate(crossings(pair.q, pair.p, c), [&](double x) {
                return std::max(pair.p.pdf(x) - c * pair.q.pdf(x), 0.);
            });
            EXPECT_NEAR(pair.residual(c), sum, 1e-11) << pair.id << " c " << c;
        }
    }
}

TEST(LabTheory, BestCHasTheClosedForms)
{
    const double root3 = std::sqrt(3.), root5 = std::sqrt(5.), root17 = std::sqrt(17.);
    const struct {
        const char* pair;
        double atN, atQuarter;
    } exact[] = {{"D1", .5, .8},
                 {"D6", 4 - 2 * root3, 1},
                 {"D7", (root5 - 1) / 2, (root17 - 1) / 2},
                 {"D9", .75, 8. / 3}};
    for (const auto& e : exact) {
        EXPECT_NEAR(pairOf(e.pair).bestC(8, 8), e.atN, 1e-12) << e.pair;
        EXPECT_NEAR(pairOf(e.pair).bestC(8, 2), e.atQuarter, 1e-12) << e.pair;
    }
    for (const Pair& pair : pairs()) {
        for (double n : {1., 2., 8., 100.}) {
            const double c = pair.bestC(8, n);
            EXPECT_NEAR(c * n, 8 * pair.residual(c), 1e-12) << pair.id << " n " << n;
        }
    }
}

TEST(LabTheory, ConstantsOfThePairsAreTheExpectedOnes)
{
    for (const LabConstants& row : kLabConstants) {
        const Pair& pair = pairOf(row.pair);
        expectPrinted(pair.rejectionConstant(), row.b, row.pair);
        expectPrinted(pair.augmentationConstant(), row.a, row.pair);
        const double c = pair.bestC(8, 8), quarter = pair.bestC(8, 2);
        EXPECT_NEAR(pair.residual(1), row.totalVariation, 6e-7) << row.pair;
        EXPECT_NEAR(c, row.c, 6e-7) << row.pair;
        EXPECT_NEAR(1 / c, row.growth, 6e-7) << row.pair;
        EXPECT_NEAR(quarter, row.cQuarter, 6e-7) << row.pair;
        EXPECT_NEAR(1 / quarter, row.growthQuarter, 6e-7) << row.pair;
        if (row.reweightingEss == 0) continue;  // int p^2/q diverges
        const double squares = integrate(crossings(pair.q, pair.p, 1), [&](double x) {
            return pair.p.pdf(x) * pair.p.pdf(x) / pair.q.pdf(x);
        });
        EXPECT_NEAR(1 / squares, row.reweightingEss, 6e-7) << row.pair;
    }
}

// --- the table

TEST(LabTheory, GivesTheExpectedTable)
{
    for (const LabRow& row : kLabTable) {
        EXPECT_NEAR(pairOf(row.pair).truth()[functionOf(row.function)], row.truth, 6e-7);
        for (int column = 0; column < kLabColumns; ++column) {
            const Cell cell = theoryCell(row, static_cast<LabColumn>(column));
            const Expectation found = app::lab::expectation(cell);
            const std::string what = nameOf(row) + " " + cell.method;
            const double printed = row.variance[static_cast<size_t>(column)];
            if (std::isnan(printed)) {  // (which symmetry makes right for F1, F3 and F7)
                const Values seen = app::lab::integrateFunctions(0, .6);
                EXPECT_NEAR(found.mean, seen[functionOf(row.function)], 1e-10) << what;
                continue;
            }
            EXPECT_NEAR(found.mean, row.truth, 6e-7) << what;
            expectPrinted(found.variance, printed, what);
        }
    }
}

TEST(LabTheory, GivesTheExpectedValuesForFewNewSamples)
{
    for (const LabSpot& row : kLabSpots) {
        const auto expect = [&](const char* method, uint32_t k, double printed) {
            if (std::isnan(printed)) return;
            const Cell cell = theoryCell(row.pair, row.function, method, k, Beta::none, 2);
            expectPrinted(app::lab::expectation(cell).variance, printed,
                          std::string(row.pair) + "-" + row.function + " " + method);
        };
        expect("discard", 0, row.discard);
        expect("reweighting", 0, row.reweighting);
        expect("ra", 4, row.ra4);
        expect("ra", kExactResidual, row.raExact);
        expect("rejection-augmentation", 0, row.rejectionAugmentation);
        expect("mis", 0, row.mis);
    }
}

TEST(LabTheory, ReweightingMissesWhatTheOldDensityDoesNotSee)
{
    // q is 0 on (.6, 1]: reweighting finds the integral over [0, .6], RIS that over [.4, .6].
    EXPECT_NEAR(app::lab::expectation(theoryCell("D9", "F2", "reweighting")).mean, .36, 1e-12);
    EXPECT_NEAR(app::lab::expectation(theoryCell("D9", "F2", "ris")).mean, .2, 1e-12);
    EXPECT_NEAR(app::lab::expectation(theoryCell("D9", "F2", "ra", 4)).mean, .84, 1e-12);
}

TEST(LabTheory, TheCorrectionCanMakeAVarianceInfinite)
{
    // Under D7 q vanishes at 1, as F3 does, but F3 - I p does not; and F2 - I p is 0 everywhere.
    const auto variance = [](const char* function, Beta beta) {
        return app::lab::expectation(theoryCell("D7", function, "reweighting", 0, beta)).variance;
    };
    EXPECT_NEAR(variance("F3", Beta::none), .5037, 5e-5);
    EXPECT_EQ(variance("F3", Beta::ideal), app::lab::kInfinite);
    EXPECT_EQ(variance("F2", Beta::none), app::lab::kInfinite);
    EXPECT_EQ(variance("F2", Beta::ideal), 0);
}

TEST(LabTheory, MethodsWithoutTheirConstantDoNotExist)
{
    const auto exists = [](const char* pair, const char* method) {
        return !std::isnan(app::lab::expectation(theoryCell(pair, "F3", method)).variance);
    };
    for (const Pair& pair : pairs()) {
        const std::string id = pair.id;
        EXPECT_EQ(exists(pair.id, "rejection"), id != "D7" && id != "D9") << id;
        EXPECT_EQ(exists(pair.id, "augmentation"), id != "D6" && id != "D7" && id != "D9") << id;
        EXPECT_FALSE(exists(pair.id, "reweighting-normalised"));
        const Cell own = theoryCell(pair.id, "F3", "ra", 4, Beta::own);
        EXPECT_TRUE(std::isnan(app::lab::expectation(own).variance));
    }
}

// --- what the table says

/// -1 where a is below b, 1 where above, 0 where they agree to the quadrature.
int compare(double a, double b)
{
    if (a == b || std::abs(a - b) < 1e-8 * std::max(a, b)) return 0;
    return a < b ? -1 : 1;
}

TEST(LabTheory, CorrectedReuseIsNeverWorseThanDiscard)
{
    for (const LabRow& row : kLabTable)
        EXPECT_LE(compare(varianceOf(row, kRa4Ideal), varianceOf(row, kDiscard)), 0) << nameOf(row);
}

TEST(LabTheory, RawReuseIsWorseThanDiscardInTenCells)
{
    std::set<std::string> worse;
    for (const LabRow& row : kLabTable)
        if (compare(varianceOf(row, kRa4), varianceOf(row, kDiscard)) > 0)
            worse.insert(nameOf(row));
    const std::set<std::string> expected{"D2-F5", "D5-F3", "D6-F2", "D7-F2", "D9-F1",
                                         "D9-F2", "D9-F3", "D9-F5", "D9-F7", "D9-F8"};
    EXPECT_EQ(worse, expected);
}

TEST(LabTheory, ReuseAgainstMultipleImportanceSampling)
{
    int wins = 0, ties = 0, losses = 0, notWorseCorrected = 0;
    for (const LabRow& row : kLabTable) {
        const int raw = compare(varianceOf(row, kRa4), varianceOf(row, kMis));
        ++(raw < 0 ? wins : raw == 0 ? ties : losses);
        if (compare(varianceOf(row, kRa4Ideal), varianceOf(row, kMisIdeal)) <= 0)
            ++notWorseCorrected;
    }
    EXPECT_EQ(wins, 14);
    EXPECT_EQ(ties, 8);  // all of D1
    EXPECT_EQ(losses, 50);
    EXPECT_EQ(notWorseCorrected, 47);
}

TEST(LabTheory, KeepingByWeightIsNeverWorseThanKeepingByChance)
{
    // The difference is the variance of the coins: N times it is c^2 E_q[w (1 - w) g^2].
    int finite = 0;
    for (const LabRow& row : kLabTable) {
        const double coins = varianceOf(row, kRejectionAugmentation);
        const double weights = varianceOf(row, kRaExact);
        EXPECT_LE(compare(weights, coins), 0) << nameOf(row);
        if (std::isinf(coins)) continue;
        ++finite;
        const Pair& pair = pairOf(row.pair);
        const size_t f = functionOf(row.function);
        const double c = pair.bestC(8, 8);
        std::vector<double> breaks = crossings(pair.q, pair.p, c);
        for (double jump : {.3, .6}) breaks.push_back(jump);
        std::sort(breaks.begin(), breaks.end());
        const double gap = c * c * integrate(breaks, [&](double x) {
                               const double q = pair.q.pdf(x), p = pair.p.pdf(x);
                               if (!(q > 0 && p > 0)) return 0.;
                               const double w = std::min(1., p / (c * q)),
                                            g = app::lab::evaluateFunctions(x)[f] / p;
                               return q * w * (1 - w) * g * g;
                           });
        // F6 under 2x: the integral of the vanishing tail is cut in one of the two.
        EXPECT_NEAR(coins - weights, gap, 1e-9 + 1e-4 * (f == 5 ? gap : 0)) << nameOf(row);
    }
    EXPECT_EQ(finite, 64);
    EXPECT_NEAR(app::lab::expectation(theoryCell("D2", "F1", "rejection-augmentation")).variance -
                    app::lab::expectation(theoryCell("D2", "F1", "ra", kExactResidual)).variance,
                .0250, 5e-5);
}

TEST(LabTheory, FullSampleIsDiscardWithMoreRays)
{
    for (const Pair& pair : pairs()) {
        const double M = std::round(8 / pair.bestC(8, 5));
        const double full =
            app::lab::expectation(theoryCell(pair.id, "F3", "full", 0, Beta::none, 5)).variance;
        const double fresh =
            app::lab::expectation(theoryCell(pair.id, "F3", "discard", 0, Beta::none, 5)).variance;
        EXPECT_NEAR(full * M, fresh * 5, 1e-12 * fresh) << pair.id;
    }
}

}  // namespace
}  // namespace tests
