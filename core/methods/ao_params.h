// Parameters of ambient occlusion, the same on every device.
#pragma once

#include "core/methods/path_params.h"

namespace core {

struct AoParams {
    static constexpr std::string_view kMethod = "ao";

    float distance = 0;
    uint32_t seed = 1;
    SamplerKind sampler = SamplerKind::sobol;

    template <class Self, class V> static void visit(Self& p, V&& v)
    {
        v(Field{"ao-distance",
                "metres beyond which nothing occludes; 0: everything does, however far",
                {0, 1e6, true}},
          p.distance);
        v(fields::kSeed, p.seed);
        v(fields::kSampler, p.sampler);
    }
    friend bool operator==(const AoParams&, const AoParams&) = default;
};

}  // namespace core
