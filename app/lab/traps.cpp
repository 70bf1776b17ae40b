// See traps.h.
#include "app/lab/traps.h"

#include <array>
#include <cmath>

#include "app/lab/blocks.h"
#include "app/lab/lab_change.h"
#include "app/lab/power_sums.h"
#include "core/base/check.h"
#include "core/reuse/estimators.h"
#include "core/reuse/resample.h"

namespace app::lab {

namespace {

using namespace core::reuse;
using Old = std::span<const LabPoint>;

struct TrapStreams {
    core::Pcg32 old, candidates, selection, other;
};

/// One way of estimating: the value of one trial.
using TrapWay = std::function<Values(const LabChange&, Old, TrapStreams&)>;

struct TrapCase {
    Trap text;
    const char *pair, *function;
    size_t oldSamples;
    double moreTrials;  // times those of the table
    TrapWay wrong, right;
};

double count(Old old)
{
    return static_cast<double>(old.size());
}

/// R-A with every candidate traced (no pick, less noise): n = 1.
Values allCandidates(const LabChange& change, Old old, double c, std::span<const LabPoint> batch)
{
    EstimateOf<LabChange> e;
    const MinimumFraction<double> fraction{c};
    addOld(e, change, old, count(old), fraction);
    for (const LabPoint& z : batch) {
        const double omega = 1 - fraction.alpha(z.q, z.p);
        e.add(omega / (static_cast<double>(batch.size()) * z.p), z.p, change.f(z));
    }
    return e.value;
}

constexpr size_t kBatch = 4;

std::array<LabPoint, kBatch> drawBatch(const LabChange& change, core::Pcg32& random)
{
    std::array<LabPoint, kBatch> batch;
    for (LabPoint& z : batch) z = change.sampleP(random);
    return batch;
}

double solveOn(std::span<const LabPoint> batch, double N)
{
    std::array<double, kBatch> ratios{};
    for (size_t i = 0; i < batch.size(); ++i)
        ratios[i] = shared::reuseRatio(batch[i].q, batch[i].p);
    return shared::reuseSolveC(N, 1.0, ratios.data(), kBatch);
}

TrapCase sameBatch()
{
    TrapCase t{{"c from the same candidates",
                "The scale c is solved on the candidates that the residual is then sampled with.",
                "Two independent batches: one for c, one for the residual."},
               "D2",
               "F4",
               4,
               5,
               {},
               {}};
    t.text.expectedBias = -0.0052;
    t.wrong = [](const LabChange& change, Old old, TrapStreams& s) {
        const auto batch = drawBatch(change, s.candidates);
        return allCandidates(change, old, solveOn(batch, count(old)), batch);
    };
    t.right = [](const LabChange& change, Old old, TrapStreams& s) {
        const auto first = drawBatch(change, s.other);
        return allCandidates(change, old, solveOn(first, count(old)),
                             drawBatch(change, s.candidates));
    };
    return t;
}

TrapCase postTrace()
{
    TrapCase t{{"no chance left for what the ray decides",
                "Reuse is refused after the ray (hidden, too near, too smooth), but candidates are "
                "resampled with 1 - alpha as it was before, which may be zero.",
                "Every candidate keeps a weight of at least 0.05, and the traced one is paid for "
                "the difference."},
               "D2",
               "F6",
               4,
               1,
               {},
               {}};
    t.text.expectedBias = -0.109;
    const auto way = [](double least) {
        return [least](const LabChange& change, Old old, TrapStreams& s) {
            const auto rho = [](const LabPoint& x) {
                return std::fmod(13 * x.x, 1.0) < 0.6 ? 1.0 : 0.0;
            };
            return postTraceReweightingAugmentation(change, old, count(old), 2, 6,
                                                    MinimumFraction<double>{0.7}, rho, least,
                                                    s.candidates, s.selection)
                .value;
        };
    };
    t.wrong = way(0);
    t.right = way(0.05);
    return t;
}

TrapCase retry()
{
    TrapCase t{{"drawing again when no candidate wants a ray",
                "When all k weights are zero, RIS starts over until one is not.",
                "The draw counts as zero."},
               "D2",
               "F1",
               8,
               1,
               {},
               {}};
    const MinimumFraction<double> fraction{0.52};
    t.wrong = [fraction](const LabChange& change, Old old, TrapStreams& s) {
        EstimateOf<LabChange> e;
        addOld(e, change, old, count(old), fraction);
        for (int j = 0; j < 8; ++j) {
            Draw<LabChange> draw;
            while (!(draw.u > 0))
                draw = drawResidual(e, change, 8, 2, fraction, s.candidates, s.selection);
            trace(e, change, draw);
        }
        return e.value;
    };
    t.right = [fraction](const LabChange& change, Old old, TrapStreams& s) {
        return reweightingAugmentation(change, old, count(old), 8, 2, fraction, s.candidates,
                                       s.selection)
            .value;
    };
    return t;
}

/// Old samples as a weighted set, of which those of small weight are to be removed.
Values prune(const LabChange& change, Old old, TrapStreams& s, bool paid)
{
    struct Weighted {
        const LabPoint* x;
        double u;
    };
    std::array<Weighted, 8> set;
    std::array<double, 8> v;
    double mean = 0;
    CHECK(old.size() == set.size());
    for (size_t i = 0; i < old.size(); ++i) {
        set[i] = {&old[i], 1 / (count(old) * old[i].q)};
        v[i] = set[i].u * old[i].p;
        mean += v[i] / count(old);
    }
    size_t kept = 0;
    if (paid) {
        kept = pruneByRoulette(std::span<Weighted>(set), std::span<const double>(v), 0.5, s.other);
    } else {
        for (size_t i = 0; i < set.size(); ++i)
            if (v[i] >= 0.5 * mean) set[kept++] = set[i];
    }
    Values sum;
    for (size_t i = 0; i < kept; ++i) sum += change.f(*set[i].x) * set[i].u;
    return sum;
}

TrapCase freePruning()
{
    TrapCase t{{"dropping what weighs little", "Samples below half of the mean weight are deleted.",
                "Roulette: they survive with a probability, and the survivors are paid for it."},
               "D2",
               "F1",
               8,
               1,
               {},
               {}};
    t.wrong = [](const LabChange& change, Old old, TrapStreams& s) {
        return prune(change, old, s, false);
    };
    t.right = [](const LabChange& change, Old old, TrapStreams& s) {
        return prune(change, old, s, true);
    };
    return t;
}

TrapCase ownMean()
{
    TrapCase t{{"the own mean as control variate",
                "The noise of the weights is corrected with the estimate itself "
                "(self-normalisation).",
                "Corrected with a value from independent samples."},
               "D2",
               "F4",
               8,
               1,
               {},
               {}};
    const auto estimate = [](const LabChange& change, Old old, TrapStreams& s) {
        return reweightingAugmentation(change, old, count(old), 8, 4,
                                       MinimumFraction<double>{0.520724}, s.candidates,
                                       s.selection);
    };
    t.wrong = [estimate](const LabChange& change, Old old, TrapStreams& s) {
        return estimate(change, old, s).selfNormalised();
    };
    t.right = [estimate](const LabChange& change, Old old, TrapStreams& s) {
        const Values neighbour = discard(change, 8, s.other).value;
        return estimate(change, old, s).corrected(neighbour);
    };
    return t;
}

TrapCase missingSupport()
{
    TrapCase t{{"reweighting where the old density was zero",
                "Old samples alone, divided by their density: what they could not reach is lost, "
                "and nothing tells.",
                "Reweighting-Augmentation: new samples answer for the rest."},
               "D9",
               "F2",
               8,
               1,
               {},
               {}};
    t.text.expectedBias = 0.36 / 0.84 - 1;
    t.wrong = [](const LabChange& change, Old old, TrapStreams&) {
        return reweighting(change, old).value;
    };
    t.right = [](const LabChange& change, Old old, TrapStreams& s) {
        return reweightingAugmentation(change, old, count(old), 8, 4, MinimumFraction<double>{0.75},
                                       s.candidates, s.selection)
            .value;
    };
    return t;
}

/// Both ways on the same old samples; false when stopped.
bool measure(TrapCase& t, uint64_t trials, uint64_t seed, std::stop_token stop)
{
    constexpr uint64_t kBlock = 4096;
    const LabChange change(pairOf(t.pair));
    const size_t function = functionIndex(t.function);
    const double truth = change.pair().truth()[function];
    struct Ways {
        PowerSums wrong, right;
    };
    const auto found = runBlocks(
        trials, kBlock,
        [&](uint64_t block, uint64_t count) {
            const auto stream = [&](uint64_t i) { return core::Pcg32(seed, block * 8 + i); };
            TrapStreams wrong{stream(0), stream(1), stream(2), stream(3)};
            TrapStreams right{stream(4), stream(5), stream(6), stream(7)};
            OldSamples samples(change, t.oldSamples);
            Ways ways;
            for (uint64_t trial = 0; trial < count; ++trial) {
                const Old old = samples.draw(wrong.old);
                ways.wrong.add(t.wrong(change, old, wrong)[function] - truth);
                ways.right.add(t.right(change, old, right)[function] - truth);
            }
            return ways;
        },
        [](Ways& into, const Ways& from) {
            into.wrong.merge(from.wrong);
            into.right.merge(from.right);
        },
        stop);
    if (!found) return false;
    t.text.wrongBias = found->wrong.mean() / truth;
    t.text.wrongZ = found->wrong.z();
    t.text.rightBias = found->right.mean() / truth;
    t.text.rightZ = found->right.z();
    t.text.trials = trials;
    return true;
}

}  // namespace

std::vector<Trap> measureTraps(uint64_t trials, uint64_t seed,
                               const std::function<void(double)>& step, std::stop_token stop)
{
    std::array cases{sameBatch(), postTrace(), retry(), freePruning(), ownMean(), missingSupport()};
    std::vector<Trap> traps;
    for (TrapCase& t : cases) {
        const auto count = static_cast<uint64_t>(static_cast<double>(trials) * t.moreTrials);
        if (!measure(t, std::max<uint64_t>(count, 2), seed, stop)) return {};
        traps.push_back(t.text);
        step(static_cast<double>(traps.size()) / static_cast<double>(cases.size()));
    }
    return traps;
}

}  // namespace app::lab
