// Which receivers and lights of a pair of nodes are asked whether they see each other. Shadows that
// reach into a pair do so from its edges as a rule, so half of either side of the samples are the
// outermost members; the others are spread evenly.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/base/pcg32.h"
#include "core/many_lights/light_tree.h"
#include "core/many_lights/pixel_tree.h"

namespace core::many_lights {

/// Members of a node that lie farthest towards the corners of a cube. The first four corners are no
/// neighbours: of a flat node along two axes they already are all four.
using Outermost = std::array<uint32_t, 8>;

/// The lights of all nodes of a tree; needs no more than the tree once it is made.
class NodeLights {
public:
    explicit NodeLights(const LightTree& tree);

    /// Of the lights below a node; `k` counts them.
    uint32_t light(uint32_t node, uint32_t k) const { return lights_[first_[node] + k]; }
    const Outermost& outermost(uint32_t node) const { return outermost_[node]; }

private:
    std::vector<uint32_t> lights_, first_;  // the former in the order of leaves, the latter by node
    std::vector<Outermost> outermost_;      // lights, by node
};

/// The outermost rows of every node, in `out`.
void outermostRows(const PixelTree& tree, const SliceRows& rows, std::vector<Outermost>& out);

/// A receiver and a light of a pair.
struct PairSample {
    uint32_t row, light;
};

/// Samples of a pair, as many as `out` has places: a power of two, 8 at least. The first four are
/// of two corners of either side and of two members, as are all fours that follow.
void samplePair(const PixelNode& pixels, const Outermost& rows, const LightNode& lights,
                uint32_t node, const NodeLights& nodeLights, Pcg32& random,
                std::span<PairSample> out);

}  // namespace core::many_lights
