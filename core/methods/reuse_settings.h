// Parameters of sample reuse as the shared text takes them.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/methods/reuse_params.h"
#include "shared/reuse_allocation.h"

namespace core {

/// Samples of directions that a pixel keeps; a reservoir has one.
inline uint32_t recordsKept(const ReuseParams& params)
{
    return params.reuse == ReuseStrategy::restirGi ? 1 : params.records;
}

/// The same of connections to emitters.
inline uint32_t lightsKept(const ReuseParams& params)
{
    return params.reuse == ReuseStrategy::restirGi ? 1 : params.lights;
}

/// Everything but the flags of a pass and the size of the picture before.
inline shared::ReuseSettings reuseSettings(const ReuseParams& params)
{
    shared::ReuseSettings s{};
    s.strategy = static_cast<uint32_t>(params.reuse);
    // As their authors have it: one sample that stands for at most twenty; a fifth of what is new.
    const bool reservoir = params.reuse == ReuseStrategy::restirGi;
    const float most = reservoir                             ? 20.0f
                       : params.reuse == ReuseStrategy::svgf ? 4 * std::max(params.rays, 1.0f)
                                                             : 1023.0f;  // packHistory's limit
    s.counts = shared::packCounts(recordsKept(params), lightsKept(params), params.candidates);
    // In units of the credit that pixels keep: what is cut off a part of a path would be missing.
    s.rays = std::round(params.rays * 1024) / 1024;
    s.cap = std::min(params.cap, most);
    s.protection = params.protection;
    return s;
}

/// Whether pixels get different numbers of new paths. Of a mean it is not known how it was found.
inline bool allocatesPaths(const ReuseParams& params)
{
    return params.allocation == PathAllocation::deviation && params.rays >= 2 &&
           !shared::keepsMeans(static_cast<uint32_t>(params.reuse));
}

/// Whether pixels hand on what cutting their stores down has taken away. A reservoir does as its
/// authors have it.
inline bool carriesRemainder(const ReuseParams& params)
{
    return params.remainder == ReuseRemainder::keep && params.reuse != ReuseStrategy::restirGi &&
           shared::keepsSamples(static_cast<uint32_t>(params.reuse));
}

/// Whether samples may be kept when something in the scene has moved: what light does beyond the
/// second surface is then taken for what it was, which no bound is known for.
inline bool followsMotion(const ReuseParams& params)
{
    return params.bias == ReuseBias::fast ||
           !shared::keepsSamples(static_cast<uint32_t>(params.reuse));
}

/// The flags of a view's pass number `pass`, from 0; `mayMove`: the scene has other poses.
inline uint32_t reuseFlags(const ReuseParams& params, uint32_t pass, bool mayMove)
{
    const bool jitters =
        params.jitter == PixelJitter::always || (params.jitter == PixelJitter::settled && pass > 0);
    return (jitters ? shared::kReuseJitters : 0) | (pass > 0 ? shared::kReuseFollows : 0) |
           (allocatesPaths(params) ? shared::kReuseAllocates : 0) |
           (carriesRemainder(params) ? shared::kReuseCarries : 0) |
           (params.bias == ReuseBias::fast && !mayMove ? shared::kReuseDirects : 0) |
           (mayMove && followsMotion(params) ? shared::kReuseMoves : 0);
}

/// Whether connections may come to lie through panes in a scene of such features
/// (setPathSettings).
inline bool connectsThroughPanes(uint32_t ofScene)
{
    constexpr uint32_t kLightsBehindPanes = shared::kFeaturePanes | shared::kFeaturePunctualLights;
    return (ofScene & kLightsBehindPanes) == kLightsBehindPanes;
}

/// kFeature bits of what passes do in a scene of such features: what they leave out is not in the
/// code that runs. Emitters are chosen by power (setPathSettings).
inline uint32_t reuseFeatures(const ReuseParams& params, uint32_t ofScene, bool mayMove)
{
    const auto strategy = static_cast<uint32_t>(params.reuse);
    const bool directs = (reuseFlags(params, 0, mayMove) & shared::kReuseDirects) != 0;
    if (!connectsThroughPanes(ofScene)) ofScene &= ~shared::kFeaturePanes;
    return (ofScene & ~shared::kFeatureEmitterTree) |
           (mayMove && followsMotion(params) ? shared::kFeatureMoves : 0) |
           (params.bias != ReuseBias::fast ? shared::kFeatureAsksVisibility : 0) |
           (shared::keepsSamples(strategy) ? shared::kFeatureKeepsSamples : 0) |
           (directs ? 0 : shared::kFeatureKeepsPlaces) |
           (shared::keepsMeans(strategy) ? shared::kFeatureKeepsMeans : 0);
}

/// Indices of samples that a view's pass number `pass` uses up. None is left out: every fourth
/// point of a sequence lies in the same quarter of its domain.
inline uint32_t samplesOfPass(const ReuseParams& params, uint32_t pass)
{
    return pass > 0 ? 1 : static_cast<uint32_t>(std::ceil(std::max(params.rays, 1.0f)));
}

/// Passes of a view after which its history has all that it can hold: it weighs the last two `cap`
/// of them about evenly, and more would put new samples in the place of equally good ones. Plain
/// paths go on then, at less cost, and leave it alone. Those are spread over their pixels: never
/// where first hits shall stay at the centres.
inline uint32_t passesOfHistory(const ReuseParams& params)
{
    if (params.jitter == PixelJitter::never) return ~0u;
    return 2 * static_cast<uint32_t>(std::ceil(reuseSettings(params).cap));
}

/// The plain paths that go on from there.
inline PathParams plainPaths(const ReuseParams& params)
{
    return {.maxDepth = params.maxDepth,
            .rouletteDepth = params.rouletteDepth,
            .seed = params.seed,
            .sampler = params.sampler};
}

/// New paths that a pixel may take in one pass.
inline uint32_t mostPathsOfPixel(const ReuseParams& params)
{
    const shared::ReuseSettings settings = reuseSettings(params);
    const bool full = params.reuse == ReuseStrategy::full;
    const float even = std::max(settings.rays, 1.0f) + (full ? settings.cap : 0);
    return static_cast<uint32_t>(
        std::ceil(even * (allocatesPaths(params) ? shared::kReuseMostPart : 1)));
}

/// What paths need to know; the strategy of the surface model is always MIS.
inline void setPathSettings(const ReuseParams& params, shared::PathSettings& s)
{
    s.seed = params.seed;
    s.samplerKind = static_cast<uint32_t>(params.sampler);
    s.strategy = shared::kStrategyMis;
    // A connection that is kept is drawn again at another place: the choice of its emitter must not
    // depend on the place.
    s.treeEmitters = 0;
    // What lamps and the sky send through panes is found by paths that happen to meet its source:
    // weighed against connections it would have to be known of each path which panes it has come
    // through. Point, spot and directional lights are met by none.
    if (s.passesPanes != shared::kPanesBlock) s.passesPanes = shared::kPanesPassPunctual;
    s.maxDepth = params.maxDepth;
    s.rouletteDepth = params.rouletteDepth;
}

}  // namespace core
