// Reweighting-Augmentation from frame to frame. After resampling among finitely many candidates the
// new samples do not have the residual density, so that ratios of densities alone become biased
// when used again; every sample therefore carries an absolute weight u with E[sum u_i h(x_i)] =
// integral of h, which each frame keeps true. Properly weighted samples: J. Liu, R. Chen,
// "Sequential Monte Carlo Methods for Dynamic Systems" (1998); the weight of a reservoir in B.
// Bitterli et al., "Spatiotemporal Reservoir Resampling" (2020), is u for a single sample.
#pragma once

#include <vector>

#include "core/reuse/resample.h"
#include "core/reuse/reweighting_augmentation.h"

namespace core::reuse {

/// How a history is cut down to K samples. Threshold resampling keeps heavy samples once and as
/// they are; systematic resampling draws with replacement, which costs variance when weights differ
/// much (15 % in the fast swing of the laboratory's moving lobe) and needs no threshold.
enum class Resampling : uint8_t { threshold, systematic };

struct HistorySettings {
    uint32_t n = 4;   // new rays a frame
    uint32_t k = 8;   // candidates for each
    uint32_t K = 16;  // samples kept from one frame to the next
    double cap = 16;  // of the nominal count N; K, or more when the score protects bright samples
    Resampling resampling = Resampling::threshold;
};

template <class Point, class Real> class History {
public:
    struct Sample {
        Point x;
        Real u;
    };

    explicit History(const HistorySettings& settings) : settings_(settings)
    {
        CHECK(settings.n >= 1 && settings.k >= 1 && settings.K >= 1 && settings.cap >= 1);
        samples_.reserve(settings.K + settings.n);
        scores_.reserve(settings.K + settings.n);
        drawn_.reserve(settings.K + settings.n);  // swapped with samples_
    }

    /// The nominal count N that the next c is to be solved with: a number that does not depend on
    /// the samples.
    Real nominal() const { return nominal_; }
    std::span<const Sample> samples() const { return samples_; }

    /// Forgets everything (teleport, other scene): the next frame is Discard.
    void clear()
    {
        samples_.clear();
        nominal_ = 0;
    }

    /// One frame: takes the history over to the new density, adds n new samples, returns the
    /// estimate of the integral, and keeps K samples. change.q is any stand-in for the density of
    /// the history, 0 outside its domain; change.f the integrand of this frame. `fraction` with 0 <
    /// c forgets nothing; with c = 0 history is dropped. `score(x, u, p, f)` says how much a sample
    /// matters to the next frame. Three independent streams; nothing is allocated.
    template <Change C, class Fraction, class Score, class RandomA, class RandomB, class RandomC>
    requires std::same_as<typename C::Point, Point> && std::same_as<typename C::Real, Real>
        EstimateOf<C> advance(const C& change, const Fraction& fraction, Real nextNominal,
                              const Score& score, RandomA& candidates, RandomB& selection,
                              RandomC& resampling)
    {
        EstimateOf<C> estimate;
        scores_.clear();
        const bool reuse = nominal_ > 0 && fraction.reuses();
        if (!reuse) samples_.clear();
        carryOver(estimate, change, fraction, score);
        for (uint32_t j = 0; j < settings_.n; ++j) {
            const Draw<C> draw = reuse ? drawResidual(estimate, change, settings_.n, settings_.k,
                                                      fraction, candidates, selection)
                                       : drawFresh(estimate, change, settings_.n, candidates);
            if (!(draw.u > 0)) continue;
            ++estimate.rays;
            const typename C::Value f = change.f(draw.y);
            estimate.add(draw.u, draw.p, f);
            scores_.push_back(score(draw.y, draw.u, draw.p, f));
            samples_.push_back({draw.y, draw.u});
        }
        cutDown(uniform<Real>(resampling));
        nominal_ = std::min(nextNominal, static_cast<Real>(settings_.cap));
        return estimate;
    }

    /// R-A with scale c; the score is v = u p, which equalises the weights. N becomes min(N / c,
    /// cap).
    template <Change C, class RandomA, class RandomB, class RandomC>
    EstimateOf<C> advance(const C& change, Real c, RandomA& candidates, RandomB& selection,
                          RandomC& resampling)
    {
        const bool reuse = nominal_ > 0 && c > 0;
        return advance(
            change, MinimumFraction<Real>{c}, reuse ? nominal_ / c : static_cast<Real>(settings_.n),
            [](const Point&, Real u, Real p, const typename C::Value&) { return u * p; },
            candidates, selection, resampling);
    }

private:
    template <Change C, class Fraction, class Score>
    void carryOver(EstimateOf<C>& estimate, const C& change, const Fraction& fraction,
                   const Score& score)
    {
        size_t kept = 0;
        for (const Sample& s : samples_) {
            const auto [q, p] = densitiesAt(change, s.x, estimate);
            const Real u = s.u * fraction.alpha(q, p);
            if (!(u > 0)) continue;
            const typename C::Value f = change.f(s.x);
            estimate.add(u, p, f);
            scores_.push_back(score(s.x, u, p, f));
            samples_[kept++] = {s.x, u};
        }
        samples_.resize(kept);
    }

    void cutDown(Real xi)
    {
        const std::span<const Real> scores(scores_);
        if (samples_.size() <= settings_.K) return;
        if (settings_.resampling == Resampling::threshold) {
            samples_.resize(
                thresholdResample(std::span<Sample>(samples_), scores, settings_.K, xi));
            return;
        }
        drawn_.resize(settings_.K);
        drawn_.resize(systematicResample(std::span<const Sample>(samples_), scores,
                                         std::span<Sample>(drawn_), xi));
        samples_.swap(drawn_);
    }

    HistorySettings settings_;
    Real nominal_ = 0;
    std::vector<Sample> samples_, drawn_;
    std::vector<Real> scores_;
};

}  // namespace core::reuse
