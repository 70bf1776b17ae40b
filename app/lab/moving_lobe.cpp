// See moving_lobe.h. Everything that does not depend on samples (c, nominal counts, truths) is
// computed once.
#include "app/lab/moving_lobe.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "app/lab/blocks.h"
#include "app/lab/pairs.h"
#include "app/lab/power_sums.h"
#include "app/lab/theory.h"
#include "core/base/check.h"

namespace app::lab {

namespace {

double reflectance(double x)
{
    return 1 + 0.8 * std::sin(14 * x);
}

struct Frame {
    Density q, p;  // of the frame before, of this one
    double truth = 0;
    double variance = 0;  // of a single fresh sample
    double c = 0, residual = 0;
    double nominal = 0, nextNominal = 0;  // N before and after
};

struct LobeChange {
    using Point = double;
    using Real = double;
    using Value = double;

    const Frame* frame = nullptr;
    double q(double x) const { return frame->q.pdf(x); }
    double p(double x) const { return frame->p.pdf(x); }
    double f(double x) const { return p(x) * reflectance(x); }
    template <class Random> double sampleP(Random& random) const
    {
        return frame->p.sample(random());
    }
};

double capOf(const LobeSettings& s)
{
    return s.cap > 0 ? s.cap : s.K;
}

std::vector<Frame> makeFrames(const LobeSettings& s)
{
    const auto lobe = [&](double t) {
        return Density::cauchy(0.5 + 0.2 * std::sin(s.step * t / 0.2), 0.08);
    };
    const bool balance = s.method == LobeMethod::balanceHeuristic;
    std::vector<Frame> frames;
    double nominal = 0;
    for (uint32_t t = 0; t < s.frames; ++t) {
        Frame frame{lobe(t == 0 ? 0 : t - 1.0), lobe(t)};
        const std::vector<double> breaks = crossings(frame.q, frame.p, 1);
        const auto moment = [&](int power) {
            return integrate(
                breaks, [&](double x) { return frame.p.pdf(x) * std::pow(reflectance(x), power); });
        };
        frame.truth = moment(1);
        frame.variance = moment(2) - frame.truth * frame.truth;
        frame.nominal = nominal;
        if (nominal > 0) {
            const Pair pair{"", "", "", "", frame.q, frame.p};
            frame.c = pair.bestC(nominal, s.n);
            frame.residual = pair.residual(frame.c);
            frame.nextNominal = balance ? nominal + s.n : nominal / frame.c;
        } else {
            frame.nextNominal = s.n;
        }
        frame.nextNominal = std::min(frame.nextNominal, capOf(s));
        nominal = frame.nextNominal;
        frames.push_back(frame);
    }
    return frames;
}

/// Streams of one trial block.
struct LobeStreams {
    core::Pcg32 candidates, selection, resampling;
    LobeStreams(uint64_t seed, uint64_t block)
        : candidates(seed, block * 4), selection(seed, block * 4 + 1),
          resampling(seed, block * 4 + 2)
    {}
};

/// What turns one frame into an estimate and keeps what the next one needs.
using Advance = std::function<double(const Frame&, LobeStreams&)>;

core::reuse::HistorySettings historySettings(const LobeSettings& s)
{
    const bool balance = s.method == LobeMethod::balanceHeuristic;
    return {s.n, balance ? 1 : s.k, s.K, capOf(s), s.resampling};
}

class WeightedSet {
public:
    explicit WeightedSet(const LobeSettings& s) : settings_(s), history_(historySettings(s)) {}

    double operator()(const Frame& frame, LobeStreams& r)
    {
        using namespace core::reuse;
        const LobeChange change{&frame};
        if (frame.nominal == 0) history_.clear();
        const auto score = [&](double, double u, double p, double f) {
            return u * (p + settings_.brightness * f / frame.truth);
        };
        const auto advance = [&](const auto& fraction) {
            return history_
                .advance(change, fraction, frame.nextNominal, score, r.candidates, r.selection,
                         r.resampling)
                .value;
        };
        if (settings_.method == LobeMethod::reweightingAugmentation)
            return advance(MinimumFraction<double>{frame.c});
        return advance(BalanceFraction<double>{frame.nominal, static_cast<double>(settings_.n)});
    }

private:
    LobeSettings settings_;
    core::reuse::History<double, double> history_;
};

/// The obvious and biased way: resamples to equal weights, and treats the set as N independent
/// samples of the last density and each pick of RIS as an exact sample of the residual.
class EqualSet {
public:
    explicit EqualSet(const LobeSettings& s) : settings_(s) {}

    double operator()(const Frame& frame, LobeStreams& r)
    {
        using namespace core::reuse;
        const LobeChange change{&frame};
        EstimateOf<LobeChange> estimate;
        if (frame.nominal == 0) points_.clear();
        samples_.clear();
        scores_.clear();
        const double N = static_cast<double>(points_.size());
        for (const double x : points_) {
            const double u = shared::reuseAlphaOverQ(frame.c, change.q(x), change.p(x)) / N;
            take(estimate, change, x, u);
        }
        for (uint32_t j = 0; j < settings_.n; ++j) {
            if (points_.empty()) {
                const Draw<LobeChange> draw =
                    drawFresh(estimate, change, settings_.n, r.candidates);
                take(estimate, change, draw.y, draw.u);
                continue;
            }
            const Draw<LobeChange> draw =
                drawResidual(estimate, change, settings_.n, settings_.k,
                             MinimumFraction<double>{frame.c}, r.candidates, r.selection);
            if (draw.u > 0) take(estimate, change, draw.y, frame.residual / (settings_.n * draw.p));
        }
        keep(static_cast<size_t>(std::lround(frame.nextNominal)), r);
        return estimate.value;
    }

private:
    struct Sample {
        double x, u;
    };

    void take(core::reuse::EstimateOf<LobeChange>& estimate, const LobeChange& change, double x,
              double u)
    {
        estimate.add(u, change.p(x), change.f(x));
        samples_.push_back({x, u});
        scores_.push_back(u * change.p(x));
    }

    void keep(size_t count, LobeStreams& r)
    {
        kept_.resize(count);
        const size_t drawn = core::reuse::systematicResample(
            std::span<const Sample>(samples_), std::span<const double>(scores_),
            std::span<Sample>(kept_), r.resampling());
        points_.clear();
        for (size_t i = 0; i < drawn; ++i) points_.push_back(kept_[i].x);
    }

    LobeSettings settings_;
    std::vector<double> points_, scores_;
    std::vector<Sample> samples_, kept_;
};

/// Old pixel values, averaged with the same memory as the sets have: as if nothing had changed.
class Accumulation {
public:
    explicit Accumulation(const LobeSettings& s) : settings_(s) {}

    double operator()(const Frame& frame, LobeStreams& r)
    {
        double fresh = 0;
        for (uint32_t j = 0; j < settings_.n; ++j)
            fresh += reflectance(frame.p.sample(r.candidates())) / settings_.n;
        const double blend = settings_.n / (frame.nominal + settings_.n);
        mean_ += (fresh - mean_) * (frame.nominal == 0 ? 1 : blend);
        return mean_;
    }

private:
    LobeSettings settings_;
    double mean_ = 0;
};

Advance makeAdvance(const LobeSettings& s)
{
    switch (s.method) {
    case LobeMethod::reweightingAugmentation:
    case LobeMethod::balanceHeuristic:
        return WeightedSet(s);
    case LobeMethod::equalWeights:
        return EqualSet(s);
    case LobeMethod::accumulation:
        return Accumulation(s);
    }
    CHECK(false);
    return {};
}

const char* nameOf(const LobeSettings& settings)
{
    switch (settings.method) {
    case LobeMethod::reweightingAugmentation:
        return settings.resampling == core::reuse::Resampling::systematic ? "R-A, systematic"
                                                                          : "R-A";
    case LobeMethod::balanceHeuristic:
        return "MIS";
    case LobeMethod::equalWeights:
        return "R-A, equal weights";
    case LobeMethod::accumulation:
        return "accumulation";
    }
    return "";
}

LobeFrame frameOf(const Frame& frame, const PowerSums& sums, uint32_t n)
{
    return {sums.mean() / frame.truth, sums.z(), sums.variance() / (frame.variance / n)};
}

}  // namespace

LobeSequence movingLobe(const LobeSettings& settings, std::stop_token stop)
{
    constexpr uint64_t kBlock = 500;
    const std::vector<Frame> frames = makeFrames(settings);
    LobeSequence sequence;
    sequence.step = settings.step;
    sequence.method = nameOf(settings);
    sequence.unbiased = settings.method == LobeMethod::reweightingAugmentation ||
                        settings.method == LobeMethod::balanceHeuristic;
    if (settings.method == LobeMethod::reweightingAugmentation ||
        settings.method == LobeMethod::equalWeights)
        sequence.candidates = settings.k;
    const auto sums = runBlocks(
        settings.trials, kBlock,
        [&](uint64_t block, uint64_t trials) {
            LobeStreams random(settings.seed, block);
            Advance advance = makeAdvance(settings);
            std::vector<PowerSums> part(frames.size());
            for (uint64_t trial = 0; trial < trials; ++trial)
                for (size_t t = 0; t < frames.size(); ++t)
                    part[t].add(advance(frames[t], random) - frames[t].truth);
            return part;
        },
        [](std::vector<PowerSums>& into, const std::vector<PowerSums>& from) {
            for (size_t t = 0; t < into.size(); ++t) into[t].merge(from[t]);
        },
        stop);
    if (!sums) return sequence;
    for (size_t t = 0; t < frames.size(); ++t) {
        sequence.frames.push_back(frameOf(frames[t], (*sums)[t], settings.n));
        sequence.largestBias =
            std::max(sequence.largestBias, std::abs(sequence.frames.back().bias));
    }
    const size_t late = std::min<size_t>(10, frames.size());
    for (size_t t = frames.size() - late; t < frames.size(); ++t)
        sequence.lateVarianceRatio += sequence.frames[t].varianceRatio / static_cast<double>(late);
    return sequence;
}

}  // namespace app::lab
