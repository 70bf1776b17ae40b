// The lights that stand for all others in a slice of the picture: the columns of its matrix. How
// they are chosen is what the methods of clustering differ in.
#pragma once

#include <stop_token>

#include "core/many_lights/light_cut.h"
#include "core/many_lights/slice_rows.h"

namespace core::many_lights {

class ColumnSource {
public:
    virtual ~ColumnSource() = default;

    /// Replaces `out` by the clusters of slice `slice`, whose receivers are `rows`. The same for
    /// any number of threads, which may call it at the same time, each with its own memory. Without
    /// meaning once `stop` is requested.
    virtual void choose(const SliceRows& rows, uint32_t slice, CutMemory& memory,
                        std::vector<LightCluster>& out, const std::stop_token& stop) const = 0;
};

/// A cut through the light tree for the mean receiver of the slice, as in the thesis, but for one
/// that has the spread of them all: lights that only some of them face, or are near to, count too.
class TreeCut final : public ColumnSource {
public:
    /// Keeps the tree by reference.
    TreeCut(const LightTree& tree, const GatherSettings& gather, uint32_t clusters)
        : tree_(tree), gather_(gather), clusters_(clusters)
    {}

    void choose(const SliceRows& rows, uint32_t, CutMemory& memory, std::vector<LightCluster>& out,
                const std::stop_token&) const override
    {
        cutLightTree(tree_, rows.query(gather_), clusters_, memory, out);
    }

private:
    const LightTree& tree_;
    GatherSettings gather_;
    uint32_t clusters_;
};

}  // namespace core::many_lights
