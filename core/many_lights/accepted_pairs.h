// Pairs of a node of receivers and a node of lights that are shaded by one light, whose visibility
// is guessed from samples of the receivers.
#pragma once

#include <vector>

#include "core/completion/visibility_sampling.h"
#include "core/many_lights/slice_pairs.h"

namespace core::many_lights {

/// Works on many pairs together. Keeps its memory.
class AcceptedPairs {
public:
    /// Takes a pair; its light is added to the rows sooner or later, at finish() at last.
    void add(SlicePairs& pairs, const Pair& pair);
    void finish(SlicePairs& pairs);
    /// Drops what a slice that was given up has left behind.
    void forget();

private:
    /// Its receivers that face the light stand in `lit_`.
    struct Accepted {
        IndexRange rows;
        Column column;
        uint32_t begin, end;  // of lit_
        uint32_t sequence;    // of sampling_
    };
    struct LitRow {
        uint32_t row;
        float weight;
    };

    std::vector<Accepted> accepted_;
    std::vector<LitRow> lit_;
    VisibilitySampling sampling_;
};

}  // namespace core::many_lights
