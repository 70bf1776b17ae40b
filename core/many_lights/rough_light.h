// The first pass of IlluminationCut: roughly what every receiver of a slice gets, from pairs that
// are far apart for their sizes, a ray each; and what pairs of the second pass may therefore err.
#pragma once

#include <span>
#include <stop_token>
#include <vector>

#include "core/base/pcg32.h"
#include "core/many_lights/slice_pairs.h"

namespace core::many_lights {

/// Keeps its memory from slice to slice.
class RoughLight {
public:
    /// What a light of this pass brings to each receiver of a node with nothing in between.
    struct Found {
        Column column;
        double light;
        uint32_t next;  // of the same node; none: ~0
    };

    /// Uses the rows' sums and leaves them dirty. `keepsFound`: found() is wanted. Returns false
    /// if it was stopped.
    bool find(SlicePairs& pairs, bool keepsFound, Pcg32& random, const std::stop_token& stop);

    /// Of a node of one receiver: what it gets. May be lowered by who knows better.
    double& of(uint32_t node) { return light_[node]; }

    std::span<const Found> found() const { return found_; }
    /// Of a node, the first of its lights in found().
    uint32_t firstFound(uint32_t node) const { return firstFound_[node]; }

    /// What the pairs of every node may err, in `out`: a part of what the darkest of its receivers
    /// gets.
    void thresholds(const SlicePairs& pairs, float error, std::vector<float>& out) const;

private:
    /// A pair as one of its receivers sees its light.
    struct Probe {
        uint32_t pixels, row;
        Column column;
        float weight;
        uint64_t visible;
    };

    void probe(SlicePairs& pairs, const Pair& pair, Pcg32& random);
    void finishProbes(SlicePairs& pairs, bool keepsFound);

    std::vector<Probe> probes_;
    std::vector<double> light_;  // by node
    double open_ = 0;            // the mean of that over the slice if all lights were seen
    std::vector<Found> found_;
    std::vector<uint32_t> firstFound_;  // by node
};

}  // namespace core::many_lights
