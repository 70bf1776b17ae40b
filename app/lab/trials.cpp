// Blocks of trials with streams of their own, merged in order. See trials.h.
#include "app/lab/trials.h"

#include <algorithm>
#include <array>
#include <atomic>

#include "app/lab/blocks.h"
#include "app/lab/power_sums.h"
#include "app/lab/theory.h"
#include "core/base/check.h"

namespace app::lab {

namespace {

constexpr uint64_t kTrialBlock = 2048;  // trials

/// What one run gathers in one block.
struct Gathered {
    std::vector<std::array<PowerSums, kFunctions>> sums;  // per beta
    uint64_t trials = 0, rays = 0, densities = 0, faults = 0;
    double ess = 0;

    void merge(const Gathered& other)
    {
        for (size_t b = 0; b < sums.size(); ++b)
            for (size_t f = 0; f < kFunctions; ++f) sums[b][f].merge(other.sums[b][f]);
        trials += other.trials;
        rays += other.rays;
        densities += other.densities;
        faults += other.faults;
        ess += other.ess;
    }
};

Values corrected(const Run::Estimate& e, Beta beta, const Values& truth)
{
    switch (beta) {
    case Beta::none:
        return e.value;
    case Beta::ideal:
        return e.corrected(truth);
    case Beta::own:
        return e.selfNormalised();
    }
    CHECK(false);
    return {};
}

void gather(Gathered& g, const Run& run, const Run::Estimate& e, const Values& truth)
{
    for (size_t b = 0; b < run.betas.size(); ++b) {
        const Values value = corrected(e, run.betas[b], truth);
        for (size_t f = 0; f < kFunctions; ++f) g.sums[b][f].add(value[f] - truth[f]);
    }
    ++g.trials;
    g.rays += e.rays;
    g.densities += e.densities;
    g.faults += e.faults;
    g.ess += e.ess();
}

/// Every experiment, block, run and purpose has a stream of its own: 2^30 blocks, 2^8 runs, 2^2
/// purposes.
uint64_t streamOf(uint32_t experiment, uint64_t block, size_t run, uint32_t purpose)
{
    return (static_cast<uint64_t>(experiment) << 40) | (block << 10) | (run << 2) | purpose;
}

std::vector<Gathered> runBlock(const LabChange& change, const std::vector<Run>& runs,
                               const TrialSettings& settings, uint64_t block, uint64_t trials,
                               const Values& truth)
{
    std::vector<Gathered> gathered(runs.size());
    std::vector<Streams> streams;
    for (size_t r = 0; r < runs.size(); ++r) {
        gathered[r].sums.resize(runs[r].betas.size());
        streams.push_back({core::Pcg32(settings.seed, streamOf(settings.experiment, block, r, 1)),
                           core::Pcg32(settings.seed, streamOf(settings.experiment, block, r, 2))});
    }
    core::Pcg32 random(settings.seed, streamOf(settings.experiment, block, 0, 0));
    OldSamples samples(change, settings.oldSamples);
    for (uint64_t t = block * kTrialBlock; t < block * kTrialBlock + trials; ++t) {
        const std::span<const LabPoint> old = samples.draw(random);
        for (size_t r = 0; r < runs.size(); ++r)
            if (t % runs[r].thinning == 0)
                gather(gathered[r], runs[r], runs[r].estimate(change, old, streams[r]), truth);
    }
    return gathered;
}

Cell cellOf(const Run& run, const Gathered& g, size_t beta, size_t function, const Pair& pair,
            const Values& truth)
{
    const PowerSums& sums = g.sums[beta][function];
    const double trials = static_cast<double>(g.trials), N = run.cell.oldSamples;
    Cell cell = run.cell;
    cell.pair = pair.id;
    cell.function = functions()[function].id;
    cell.beta = run.betas[beta];
    cell.trials = g.trials;
    cell.truth = truth[function];
    cell.mean = truth[function] + sums.mean();
    cell.standardError = sums.standardError();
    cell.variance = N * sums.variance();
    cell.varianceError = N * sums.varianceError();
    cell.rays = static_cast<double>(g.rays) / trials;
    cell.densities = static_cast<double>(g.densities) / trials;
    cell.ess = g.ess / trials;
    const Expectation expected = expectation(cell);
    cell.expectedMean = expected.mean;
    cell.expectedVariance = expected.variance;
    return cell;
}

}  // namespace

std::vector<Cell> runTrials(const Pair& pair, const std::vector<Run>& runs,
                            const TrialSettings& settings, const std::function<void(double)>& step,
                            std::stop_token stop)
{
    CHECK(settings.trials >= 2 && runs.size() < 256);
    const LabChange change(pair);
    const Values truth = pair.truth();
    std::atomic<uint64_t> done = 0;
    const auto gathered = runBlocks(
        settings.trials, kTrialBlock,
        [&](uint64_t block, uint64_t trials) {
            std::vector<Gathered> part = runBlock(change, runs, settings, block, trials, truth);
            done += trials;
            step(static_cast<double>(done) / static_cast<double>(settings.trials));
            return part;
        },
        [](std::vector<Gathered>& into, const std::vector<Gathered>& from) {
            for (size_t r = 0; r < into.size(); ++r) into[r].merge(from[r]);
        },
        stop);
    if (!gathered) return {};
    std::vector<Cell> cells;
    for (size_t r = 0; r < runs.size(); ++r) {
        const Gathered& g = (*gathered)[r];
        CHECK(g.faults == 0);
        for (size_t beta = 0; beta < runs[r].betas.size(); ++beta)
            for (size_t f = 0; f < kFunctions; ++f)
                cells.push_back(cellOf(runs[r], g, beta, f, pair, truth));
    }
    return cells;
}

}  // namespace app::lab
