// Parameters of sample reuse as the shared text takes them.
#pragma once

#include "core/methods/reuse_params.h"
#include "shared/reuse_records.h"

namespace core {

/// Everything but the flags of a pass and the size of the picture before.
inline shared::ReuseSettings reuseSettings(const ReuseParams& params)
{
    shared::ReuseSettings s{};
    s.strategy = static_cast<uint32_t>(params.reuse);
    s.candidates = params.candidates;
    s.records = params.records;
    s.lights = params.lights;
    s.cap = params.cap;
    s.protection = params.protection;
    return s;
}

/// The flags of a view's pass number `pass`, from 0.
inline uint32_t reuseFlags(const ReuseParams& params, uint32_t pass)
{
    const bool jitters =
        params.jitter == PixelJitter::always || (params.jitter == PixelJitter::settled && pass > 0);
    return (jitters ? shared::kReuseJitters : 0) | (pass > 0 ? shared::kReuseFollows : 0);
}

/// What paths need to know; the strategy of the surface model is always MIS.
inline void setPathSettings(const ReuseParams& params, shared::PathSettings& s)
{
    s.seed = params.seed;
    s.samplerKind = static_cast<uint32_t>(params.sampler);
    s.strategy = shared::kStrategyMis;
    s.maxDepth = params.maxDepth;
    s.rouletteDepth = params.rouletteDepth;
}

}  // namespace core
