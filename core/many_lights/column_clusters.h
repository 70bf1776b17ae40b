// Clusters of the columns of a reduced matrix, in two phases, and lights that stand for them (M.
// Hasan, F. Pellacini, K. Bala, "Matrix Row-Column Sampling for the Many-Light Problem", 2007). Two
// columns a and b in one cluster cost |a| |b| - a . b: nothing where they are parallel, since a
// column stands for others by a factor.
#pragma once

#include "core/base/pcg32.h"
#include "core/many_lights/light_cut.h"
#include "core/many_lights/reduced_matrix.h"

namespace core::many_lights {

/// A partition of columns.
struct ColumnClusters {
    std::vector<uint32_t> members;   // cluster by cluster
    std::vector<IndexRange> ranges;  // of `members`, adjacent, none empty

    std::span<uint32_t> of(const IndexRange& range)
    {
        return {members.data() + range.begin, range.size()};
    }
    std::span<const uint32_t> of(const IndexRange& range) const
    {
        return {members.data() + range.begin, range.size()};
    }
};

/// The sampling phase: about `count` columns are drawn as centres, by what each costs with all
/// others; all columns that are not zero go to the centre with the least cost times the inverse of
/// its probability. There are fewer clusters where fewer columns differ. Without meaning once
/// `stop` is requested.
ColumnClusters sampleClusters(const ReducedMatrix& matrix, uint32_t count, Pcg32& random,
                              const std::stop_token& stop = {});

/// The splitting phase: the costliest cluster is split until there are `count`, or the costs are 0.
/// Projected on the line through its longest column and that which costs most with it, all of them
/// brought to one length, a cluster is split in the middle of its extent: without that, dim lights
/// would be parted from bright ones of the same kind. Without meaning once `stop` is requested.
void splitClusters(const ReducedMatrix& matrix, uint32_t count, ColumnClusters& clusters,
                   const std::stop_token& stop = {});

/// How probable a light is as representative, in proportion: its column's length and a share for
/// its brightness, so that no light that the sampled rows miss is left out for ever.
std::vector<float> representativeWeights(const ReducedMatrix& matrix,
                                         std::span<const VirtualLight> lights);

/// Appends one representative for each cluster; its scale is the inverse of its probability, so
/// that the sum over representatives is expected to be the sum over all lights of the clusters.
void drawRepresentatives(const ColumnClusters& clusters, std::span<const float> weights,
                         Pcg32& random, std::vector<LightCluster>& out);

/// Lights whose columns are zero, and how many of `clusters` represent them: few, and one at least.
struct UnseenLights {
    std::vector<uint32_t> lights;
    uint32_t clusters = 0;
};
UnseenLights unseenLights(const ReducedMatrix& matrix, uint32_t clusters);

/// Every light by itself.
void allLights(uint32_t lights, std::vector<LightCluster>& out);

/// Appends `count` representatives of one set of lights, drawn systematically by their weights,
/// with the same expectation.
void drawSystematic(std::span<const uint32_t> members, std::span<const float> weights,
                    uint32_t count, Pcg32& random, std::vector<LightCluster>& out);

}  // namespace core::many_lights
