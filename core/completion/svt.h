// Completion by nuclear norm: every column is sampled at the same rate, uniformly, and the octant
// is the matrix of small nuclear norm that agrees (S. Wang, "Efficient Sample Usage in
// Photo-Realistic Rendering", 2022, section 6.1.5). For comparison: nothing is verified, and what
// is sampled is often less than such recovery needs. What differs: an octant at a time, not a
// slice.
#pragma once

#include "core/completion/octant.h"

namespace core::many_lights {

class SvtOctant : Octant {
public:
    SvtOctant(Tracer& tracer, std::span<const uint32_t> columns, const CompletionParams& params,
              uint64_t seed, CompletedSlice& out);

    /// Predicts nothing of use once `stop` is requested.
    void run(const std::stop_token& stop);
};

}  // namespace core::many_lights
