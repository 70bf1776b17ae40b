// The formulas of the laboratory for what the expected table does not hold (methods, and c, n and M
// away from the best), against the estimators themselves.
#include "app/lab/theory.h"
#include "app/lab/trials.h"
#include "core/reuse/estimators.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace tests {
namespace {

using app::lab::Beta;
using app::lab::Cell;
using app::lab::kFunctions;
using app::lab::LabChange;
using app::lab::Pair;
using app::lab::pairOf;
using app::lab::pairs;
using app::lab::Run;
using app::lab::Streams;
using Old = std::span<const app::lab::LabPoint>;

// -------------------------------------------

/// N = 8, n = 5, so that n is neither N nor a part of it; raw and corrected by the truth.
Run runOf(const char* method, double c, decltype(Run::estimate) estimate, uint32_t k = 0)
{
    Run run;
    run.cell.method = method;
    run.cell.oldSamples = 8;
    run.cell.newSamples = 5;
    run.cell.candidates = k;
    run.cell.c = c;
    run.betas = {Beta::none, Beta::ideal};
    run.estimate = std::move(estimate);
    return run;
}

/// Mean within 4.5 and N Var within 5 standard errors of the formulas, for every function. Cells of
/// infinite variance are left out. Variances are known to 1 or 2 % for most.
void expectAgreement(const Pair& pair, const Run& run, uint64_t trials = 30000)
{
    const std::vector<Cell> cells =
        app::lab::runTrials(pair, {run}, {trials, 11, 8}, [](double) {}, {});
    ASSERT_EQ(cells.size(), 2 * kFunctions);
    for (const Cell& cell : cells) {
        const std::string what = cell.pair + " " + cell.function + " " + cell.method +
                                 (cell.beta == Beta::none ? "" : " corrected");
        ASSERT_FALSE(std::isnan(cell.expectedVariance)) << what;
        if (std::isinf(cell.expectedVariance)) continue;
        EXPECT_NEAR(cell.mean, cell.expectedMean, 4.5 * cell.standardError + 1e-12) << what;
        EXPECT_NEAR(cell.variance, cell.expectedVariance, 5 * cell.varianceError + 1e-12) << what;
    }
}

TEST(LabFormulas, Rejection)
{
    for (const char* id : {"D2", "D4", "D6"}) {
        const double b = pairOf(id).rejectionConstant();
        expectAgreement(pairOf(id), runOf("rejection", app::lab::kUnknown,
                                          [b](const LabChange& change, Old old, Streams& s) {
                                              return core::reuse::rejection(change, old, b,
                                                                            s.selection);
                                          }));
    }
}

TEST(LabFormulas, ResamplingTheOldSet)
{
    for (const char* id : {"D2", "D5", "D6", "D9"}) {
        expectAgreement(
            pairOf(id),
            runOf("ris", app::lab::kUnknown, [](const LabChange& change, Old old, Streams& s) {
                return core::reuse::resampledOldSet(change, old, 5, s.selection);
            }));
    }
}

TEST(LabFormulas, Augmentation)
{
    for (const char* id : {"D1", "D2", "D4"}) {
        const double a = pairOf(id).augmentationConstant();
        expectAgreement(pairOf(id), runOf("augmentation", app::lab::kUnknown,
                                          [a](const LabChange& change, Old old, Streams& s) {
                                              return core::reuse::augmentation(
                                                  change, old, a, s.candidates, s.selection);
                                          }));
    }
}

TEST(LabFormulas, RejectionAugmentationAtAnyC)
{
    // c well away from the best, so that the number added is no whole number.
    for (const char* id : {"D2", "D5", "D7", "D9"}) {
        const Pair& pair = pairOf(id);
        for (double factor : {.6, 1.7}) {
            const double c = factor * pair.bestC(8, 5), R = pair.residual(c);
            expectAgreement(pair, runOf("rejection-augmentation", c,
                                        [c, R](const LabChange& change, Old old, Streams& s) {
                                            return core::reuse::rejectionAugmentation(
                                                change, old, c, R, s.candidates, s.selection);
                                        }));
        }
    }
}

TEST(LabFormulas, ReweightingAugmentationAtAnyC)
{
    for (const char* id : {"D2", "D5", "D7", "D9"}) {
        const Pair& pair = pairOf(id);
        for (double factor : {.3, 2.5}) {
            const double c = factor * pair.bestC(8, 5);
            expectAgreement(pair, runOf(
                                      "ra", c,
                                      [c](const LabChange& change, Old old, Streams& s) {
                                          return core::reuse::reweightingAugmentation(
                                              change, old, 8, 5, 3,
                                              core::reuse::MinimumFraction<double>{c}, s.candidates,
                                              s.selection);
                                      },
                                      3));
        }
    }
}

TEST(LabFormulas, Thinning)
{
    for (const char* id : {"D2", "D3", "D7", "D9"}) {
        const double c = pairOf(id).bestC(8, 5);
        const auto M = static_cast<uint32_t>(std::lround(8 / c));
        expectAgreement(pairOf(id),
                        runOf("ra-thinned", c, [M](const LabChange& change, Old old, Streams& s) {
                            return core::reuse::thinnedReweightingAugmentation(
                                change, old, 8, M, s.candidates, s.selection);
                        }));
    }
}

TEST(LabFormulas, MultipleImportanceSampling)
{
    for (const char* id : {"D2", "D7", "D9"}) {
        expectAgreement(
            pairOf(id),
            runOf("mis", app::lab::kUnknown, [](const LabChange& change, Old old, Streams& s) {
                return core::reuse::balanceHeuristic(change, old, 8, 5, s.candidates);
            }));
    }
}

}  // namespace
}  // namespace tests
