// Receivers of a slice that see clearly less than those around them, as lines of points one pixel
// high under an edge do: what all receivers of a node share tells nothing of them.
#pragma once

#include <span>
#include <vector>

#include "core/base/pcg32.h"
#include "core/many_lights/rough_light.h"
#include "core/many_lights/slice_pairs.h"

namespace core::many_lights {

/// Keeps its memory from slice to slice.
class DarkRows {
public:
    /// Asks every row for a few of the lights that the first pass has found for it, and lowers what
    /// that thinks the row gets, where it sees clearly less.
    void find(SlicePairs& pairs, RoughLight& rough, Pcg32& random);

    /// The darkest row of a node, of what would come with nothing in between.
    uint32_t darkest(uint32_t node) const { return darkest_[node]; }

private:
    struct Step {
        uint32_t found;
        double sum;  // of the light up to it
    };
    /// Rays of one row, by what the lights bring with nothing in between.
    template <class Packets>
    void look(SlicePairs& pairs, const RoughLight& rough, uint32_t row, Packets& packets,
              Pcg32& random);
    void lower(const SlicePairs& pairs, RoughLight& rough) const;
    double seenBy(uint32_t row) const;

    std::vector<Step> path_;         // lights of all nodes around the row at work
    std::vector<uint64_t> seen_;     // bits of what a row was asked for
    std::vector<double> light_;      // that a row would get with nothing in between
    std::vector<uint32_t> darkest_;  // rows, by node
};

}  // namespace core::many_lights
