// Fewer samples with the same expectation: threshold resampling (P. Fearnhead, P. Clifford,
// "On-line Inference for Hidden Markov Models via Particle Filters", 2003), systematic resampling,
// and roulette for what weighs next to nothing. Samples have a member `u`, their absolute weight;
// scores say how much each matters.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>

#include "core/base/check.h"
#include "core/reuse/change.h"

namespace core::reuse {

/// shared::reuseThreshold of any number of scores.
template <class Real> Real resamplingThreshold(std::span<const Real> scores, uint32_t keep)
{
    CHECK(keep >= 1);
    return shared::reuseThreshold(scores.data(), static_cast<uint32_t>(scores.size()), keep);
}

/// Keeps `keep` of the samples (fewer when fewer have a positive score) and moves them to the
/// front, in order; returns how many. Samples of score >= kappa stay as they are; lighter ones
/// survive with probability a / kappa and are paid for it. E[sum u h] stays as it was for every h.
/// xi uniform in [0, 1).
template <class Sample, class Real>
size_t thresholdResample(std::span<Sample> samples, std::span<const Real> scores, uint32_t keep,
                         Real xi)
{
    CHECK(samples.size() == scores.size());
    const Real kappa = resamplingThreshold(scores, keep);
    Real sum = 0;
    size_t kept = 0;
    for (size_t i = 0; i < samples.size(); ++i) {
        if (!shared::usableDensity(scores[i])) continue;
        if (kappa > 0 && (!shared::reuseKeep(sum, scores[i], kappa, xi) || kept == keep)) continue;
        Sample survivor = samples[i];
        survivor.u *= kappa > 0 ? shared::reuseKeepScale(scores[i], kappa) : 1;
        samples[kept++] = survivor;
    }
    return kept;
}

/// Draws `out.size()` samples with replacement at even steps over the cumulated scores (J.
/// Carpenter, P. Clifford, P. Fearnhead, "Improved Particle Filter for Nonlinear Problems", 1999);
/// heavy ones come several times. Returns how many: none when no score is positive.
template <class Sample, class Real>
size_t systematicResample(std::span<const Sample> samples, std::span<const Real> scores,
                          std::span<Sample> out, Real xi)
{
    CHECK(samples.size() == scores.size() && !out.empty());
    Real total = 0;
    size_t last = samples.size();
    for (size_t i = 0; i < scores.size(); ++i) {
        if (!shared::usableDensity(scores[i])) continue;
        total += scores[i];
        last = i;
    }
    if (last == samples.size()) return 0;
    const Real step = total / static_cast<Real>(out.size());
    Real cumulated = 0;
    size_t i = 0;
    for (size_t j = 0; j < out.size(); ++j) {
        const Real at = (static_cast<Real>(j) + xi) * step;
        for (; i < last; ++i) {
            const Real next = cumulated + (shared::usableDensity(scores[i]) ? scores[i] : Real(0));
            if (at < next) break;
            cumulated = next;
        }
        out[j] = samples[i];
        out[j].u *= step / scores[i];
    }
    return out.size();
}

/// Roulette for samples whose weight is below `fraction` of the mean: v survives with probability v
/// / (fraction mean), and is paid for it. Survivors move to the front, in order; returns how many.
/// `v` holds the dimensionless weights, u p, one per sample.
template <class Sample, class Real, class Random>
size_t pruneByRoulette(std::span<Sample> samples, std::span<const Real> v, Real fraction,
                       Random& random)
{
    CHECK(samples.size() == v.size());
    Real mean = 0;
    for (const Real x : v) mean += x;
    const Real least = samples.empty() ? 0 : fraction * mean / static_cast<Real>(v.size());
    size_t kept = 0;
    for (size_t i = 0; i < samples.size(); ++i) {
        const Real survival = v[i] < least ? v[i] / least : Real(1);
        if (!(uniform<Real>(random) < survival)) continue;
        Sample survivor = samples[i];
        survivor.u *= 1 / survival;
        samples[kept++] = survivor;
    }
    return kept;
}

}  // namespace core::reuse
