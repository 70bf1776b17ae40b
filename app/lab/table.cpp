// Runs and sweeps. See table.h.
#include "app/lab/table.h"

#include <cmath>

#include "app/lab/methods.h"
#include "app/lab/theory.h"
#include "core/base/check.h"
#include "core/reuse/estimators.h"

namespace app::lab {

namespace {

using core::reuse::MinimumFraction;

Run runOf(const char* method, uint32_t n, uint32_t k, double c,
          std::vector<Beta> betas = {Beta::none})
{
    Run run;
    run.cell.method = methodOf(method).id;
    run.cell.oldSamples = kOldSamples;
    run.cell.newSamples = n;
    run.cell.candidates = k;
    run.cell.c = c;
    run.betas = std::move(betas);
    return run;
}

Run reweightingAugmentationRun(uint32_t n, uint32_t k, double c, std::vector<Beta> betas)
{
    Run run = runOf("ra", n, k, c, std::move(betas));
    run.estimate = [n, k, c](const LabChange& change, std::span<const LabPoint> old, Streams& s) {
        return core::reuse::reweightingAugmentation(change, old, static_cast<double>(old.size()), n,
                                                    k, MinimumFraction<double>{c}, s.candidates,
                                                    s.selection);
    };
    return run;
}

/// The methods that take no new samples, and augmentation, whose number of new samples is not free.
void addOldOnlyRuns(const Pair& pair, std::vector<Run>& runs)
{
    using namespace core::reuse;
    Run plain = runOf("reweighting", 0, 0, kUnknown);
    plain.estimate = [](const LabChange& change, std::span<const LabPoint> old, Streams&) {
        return reweighting(change, old);
    };
    Run normalised = runOf("reweighting-normalised", 0, 0, kUnknown, {Beta::own});
    normalised.estimate = plain.estimate;
    Run ris = runOf("ris", kOldSamples, 0, kUnknown);
    ris.estimate = [](const LabChange& change, std::span<const LabPoint> old, Streams& s) {
        return resampledOldSet(change, old, kOldSamples, s.selection);
    };
    for (Run& run : {std::ref(plain), std::ref(normalised), std::ref(ris)})
        runs.push_back(std::move(run));

    const double b = pair.rejectionConstant(), a = pair.augmentationConstant();
    if (std::isfinite(b)) {
        Run run = runOf("rejection", 0, 0, kUnknown, {Beta::none, Beta::ideal});
        run.estimate = [b](const LabChange& change, std::span<const LabPoint> old, Streams& s) {
            return rejection(change, old, b, s.selection);
        };
        runs.push_back(std::move(run));
    }
    if (std::isfinite(a)) {
        const auto added = static_cast<uint32_t>(std::lround((a - 1) * kOldSamples));
        Run run = runOf("augmentation", added, 0, kUnknown, {Beta::none, Beta::ideal});
        run.thinning = a > kMuchAugmentation ? kThinning : 1;
        run.estimate = [a](const LabChange& change, std::span<const LabPoint> old, Streams& s) {
            return augmentation(change, old, a, s.candidates, s.selection);
        };
        runs.push_back(std::move(run));
    }
}

void addFreshRuns(const Pair& pair, uint32_t n, std::vector<Run>& runs)
{
    using namespace core::reuse;
    const double c = pair.bestC(kOldSamples, n);
    const auto M = static_cast<uint32_t>(std::lround(kOldSamples / c));
    const auto fresh = [](uint32_t count) {
        return [count](const LabChange& change, std::span<const LabPoint>, Streams& s) {
            return discard(change, count, s.candidates);
        };
    };
    Run none = runOf("discard", n, 0, kUnknown);
    none.estimate = fresh(n);
    runs.push_back(std::move(none));
    Run full = runOf("full", n, 0, c);
    full.estimate = fresh(M);
    runs.push_back(std::move(full));

    Run rejected = runOf("rejection-augmentation", n, 0, c, {Beta::none, Beta::ideal});
    rejected.estimate = [c, R = pair.residual(c)](const LabChange& change,
                                                  std::span<const LabPoint> old, Streams& s) {
        return rejectionAugmentation(change, old, c, R, s.candidates, s.selection);
    };
    runs.push_back(std::move(rejected));

    const std::vector<Beta> all{Beta::none, Beta::ideal, Beta::own};
    for (const uint32_t k : {1u, 4u, 16u}) runs.push_back(reweightingAugmentationRun(n, k, c, all));

    Run thinned = runOf("ra-thinned", n, M, kOldSamples / double(M), {Beta::none, Beta::ideal});
    thinned.estimate = [M](const LabChange& change, std::span<const LabPoint> old, Streams& s) {
        return thinnedReweightingAugmentation(change, old, static_cast<double>(old.size()), M,
                                              s.candidates, s.selection);
    };
    runs.push_back(std::move(thinned));

    Run mis = runOf("mis", n, 0, kUnknown, all);
    mis.estimate = [n](const LabChange& change, std::span<const LabPoint> old, Streams& s) {
        return balanceHeuristic(change, old, static_cast<double>(old.size()), n, s.candidates);
    };
    runs.push_back(std::move(mis));
}

/// So that the errors of two pairs are independent.
uint32_t experimentOf(const Pair& pair)
{
    return static_cast<uint32_t>(&pair - pairs().data());
}

SweepPoint sweepPoint(const Cell& cell, double cFactor)
{
    return {cell.pair,          cell.function,         cFactor, cell.candidates, cell.variance,
            cell.varianceError, cell.expectedVariance, cell.z()};
}

}  // namespace

std::vector<Run> methodRuns(const Pair& pair, uint32_t n, bool withOldOnly)
{
    std::vector<Run> runs;
    if (withOldOnly) addOldOnlyRuns(pair, runs);
    addFreshRuns(pair, n, runs);
    return runs;
}

std::vector<Cell> measurePair(const Pair& pair, const LabSettings& settings,
                              const std::function<void(double)>& step, std::stop_token stop)
{
    std::vector<Run> runs = methodRuns(pair, kOldSamples, true);
    for (Run& run : methodRuns(pair, kOldSamples / 4, false)) runs.push_back(std::move(run));
    const TrialSettings trials{settings.trials, settings.seed, kOldSamples, experimentOf(pair)};
    return runTrials(pair, runs, trials, step, stop);
}

bool measureSweeps(const Pair& pair, const LabSettings& settings, LabResults& results,
                   const std::function<void(double)>& step, std::stop_token stop)
{
    constexpr double kFactors[] = {0.25, 0.5, 1, 2, 4};
    constexpr uint32_t kCandidates[] = {1, 2, 4, 8, 16, 32};
    const double best = pair.bestC(kOldSamples, kOldSamples);
    std::vector<Run> runs;
    for (const double factor : kFactors)
        runs.push_back(reweightingAugmentationRun(kOldSamples, 4, best * factor, {Beta::none}));
    for (const uint32_t k : kCandidates)
        runs.push_back(reweightingAugmentationRun(kOldSamples, k, best, {Beta::none}));
    const TrialSettings trials{std::max<uint64_t>(settings.trials / 8, 2), settings.seed,
                               kOldSamples, static_cast<uint32_t>(kPairs) + experimentOf(pair)};
    const std::vector<Cell> cells = runTrials(pair, runs, trials, step, stop);
    for (size_t i = 0; i < cells.size(); ++i) {
        const size_t run = i / kFunctions;
        const bool overC = run < std::size(kFactors);
        (overC ? results.overC : results.overK)
            .push_back(sweepPoint(cells[i], overC ? kFactors[run] : 1));
    }
    return !cells.empty();
}

std::vector<MajorisationPoint> majorisationSweep()
{
    std::vector<MajorisationPoint> points;
    const Density q = Density::cauchy(0.45, 0.1);
    for (int i = 0; i <= 50; ++i) {
        const double at = 0.45 + 0.01 * i;
        const Pair pair{"", "", "", "", q, Density::cauchy(at, 0.1)};
        const double c = pair.bestC(1, 1);
        const double squares = integrate(crossings(pair.q, pair.p, 1), [&](double x) {
            return pair.p.pdf(x) * pair.p.pdf(x) / pair.q.pdf(x);
        });
        points.push_back({at, pair.rejectionConstant(), pair.augmentationConstant(), c, 1 / c,
                          pair.residual(1), 1 / squares});
    }
    return points;
}

}  // namespace app::lab
