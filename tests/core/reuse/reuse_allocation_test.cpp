// No estimator of core/reuse takes memory from the heap: they run once per pixel and frame.
#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "bench/changes.h"
#include "core/reuse/estimators.h"
#include "core/reuse/history.h"
#include "core/reuse/solve_c.h"
#include "tests/support/process/allocation_count.h"

namespace {

using bench::CauchyChange;
using bench::GgxChange;
using core::Pcg32;
namespace reuse = core::reuse;

/// How often `work` allocates.
template <class Work> uint64_t allocationsOf(Work&& work)
{
    const uint64_t before = tests::allocations();
    work();
    return tests::allocations() - before;
}

TEST(ReuseAllocation, IsCounted)
{
    if (!tests::allocationsAreCounted()) GTEST_SKIP() << "a sanitizer counts for itself";
    static std::unique_ptr<std::vector<int>> kept;  // static: not to be optimised away
    EXPECT_GE(allocationsOf([] { kept = std::make_unique<std::vector<int>>(100); }), 2u);
    EXPECT_EQ(allocationsOf([] { kept.reset(); }), 0u);
}

template <class C> void expectNoAllocation()
{
    using Real = typename C::Real;
    using Point = typename C::Point;
    if (!tests::allocationsAreCounted()) GTEST_SKIP() << "a sanitizer counts for itself";
    const C change;
    const std::vector<Point> points = change.oldSamples(32);
    const std::span<const Point> old(points);
    Pcg32 a(1), b(2), c(3);
    const reuse::MinimumFraction<Real> fraction{Real(0.6)};
    double sum = 0;
    const auto count = [&](const char* name, auto&& estimate) {
        EXPECT_EQ(allocationsOf([&] { sum += estimate().weightSum; }), 0u) << name;
    };
    count("discard", [&] { return reuse::discard(change, 4, a); });
    count("reweighting", [&] { return reuse::reweighting(change, old); });
    count("rejection", [&] { return reuse::rejection(change, old, Real(2.7), a); });
    count("resampledOldSet", [&] { return reuse::resampledOldSet(change, old, 4, a); });
    count("augmentation", [&] { return reuse::augmentation(change, old, Real(1.5), a, b); });
    count("rejectionAugmentation",
          [&] { return reuse::rejectionAugmentation(change, old, Real(0.6), Real(0.5), a, b); });
    count("reweightingAugmentation", [&] {
        return reuse::reweightingAugmentation(change, old, Real(32), 4, 8, fraction, a, b);
    });
    count("balanceHeuristic", [&] { return reuse::balanceHeuristic(change, old, Real(32), 4, a); });
    const auto rho = [](const Point&) { return Real(0.5); };
    count("postTraceReweightingAugmentation", [&] {
        return reuse::postTraceReweightingAugmentation(change, old, Real(32), 4, 8, fraction, rho,
                                                       Real(0.05), a, b);
    });
    count("thinnedReweightingAugmentation",
          [&] { return reuse::thinnedReweightingAugmentation(change, old, Real(32), 40, a, b); });
    EXPECT_EQ(allocationsOf(
                  [&] { sum += double(reuse::solveCFromCandidates(change, Real(32), 4, 8, a)); }),
              0u);
    for (const auto resampling : {reuse::Resampling::threshold, reuse::Resampling::systematic}) {
        reuse::History<Point, Real> history(
            {.n = 4, .k = 8, .K = 16, .cap = 16, .resampling = resampling});
        for (int frame = 0; frame < 12; ++frame) {
            const double scale = reuse::solveC(double(history.nominal()), 4, [](double) {
                return reuse::Masses{0.7, 0.4};
            });
            count("History",
                  [&] { return history.advance(change, static_cast<Real>(scale), a, b, c); });
        }
        EXPECT_GT(history.samples().size(), 8u);
    }
    EXPECT_GT(sum, 0);
}

TEST(ReuseAllocation, NoneInAnyEstimator)
{
    expectNoAllocation<CauchyChange<double>>();
    expectNoAllocation<CauchyChange<float>>();
    expectNoAllocation<GgxChange>();
}

}  // namespace
