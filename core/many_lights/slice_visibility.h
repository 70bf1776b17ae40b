// One slice from its receivers to bits: which lights count there, and which rows see each of them.
// Light is not summed here: that is for slice_shading.h, or for a kernel.
#pragma once

#include "core/many_lights/slice_job.h"
#include "core/many_lights/slice_oracle.h"

namespace core::many_lights {

/// Keeps its memory from slice to slice: one per thread.
class SliceVisibility {
public:
    /// Completes the visibility between the receivers that `chosen` lists and the lights that the
    /// job chooses for them. Adds what it took to `stats`. False when `stop` came in between: then
    /// nothing of the results holds.
    bool run(const SliceJob& job, std::span<const Receiver> receivers,
             std::span<const uint32_t> chosen, uint32_t slice, const std::stop_token& stop,
             SliceStats& stats);

    /// The same but for completed(): rows, columns and where these matter.
    bool prepare(const SliceJob& job, std::span<const Receiver> receivers,
                 std::span<const uint32_t> chosen, uint32_t slice, const std::stop_token& stop,
                 SliceStats& stats);

    // Of the last run. Columns go octant by octant, in each the brightest first.
    SliceRows& rows() { return rows_; }
    std::span<const Column> columns() const { return ordered_; }
    const CompletedSlice& completed() const { return completed_; }
    /// Rows that face the light at all and that its light reaches.
    const BitMatrix& matters() const { return orderedMatters_; }

private:
    void chooseSome(const SliceJob& job, std::span<const Receiver> receivers,
                    std::span<const uint32_t> chosen);
    bool makeColumns(const SliceJob& job, uint32_t slice, const std::stop_token& stop);
    void setRadii(float alone);
    bool weighColumns(const SliceJob& job, const std::stop_token& stop);
    void orderColumns();

    SliceRows rows_;
    SliceRows some_;  // of them
    std::vector<uint32_t> someChosen_;
    CutMemory cutMemory_;
    std::vector<LightCluster> clusters_;
    std::vector<Column> columns_, ordered_;
    std::vector<float> brightness_, weights_;
    std::vector<float> orderedBrightness_;  // over the mean of the columns
    std::vector<uint32_t> octants_, order_;
    std::vector<ColumnRange> ranges_;
    BitMatrix matters_, orderedMatters_;
    CompletedSlice completed_;
};

}  // namespace core::many_lights
