// Parameters of the path tracer as the shared text takes them.
#pragma once

#include "core/methods/path_params.h"
#include "shared/layout.h"

namespace core {

/// What paths need to know beside the world and the picture.
inline void setPathSettings(const PathParams& params, shared::PathSettings& s)
{
    s.seed = params.seed;
    s.samplerKind = static_cast<uint32_t>(params.sampler);
    s.strategy = static_cast<uint32_t>(params.strategy);
    s.maxDepth = params.maxDepth;
    s.rouletteDepth = params.rouletteDepth;
    s.clampIndirect = params.clampIndirect;
}

}  // namespace core
