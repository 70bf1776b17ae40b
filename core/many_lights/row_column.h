// Matrix row-column sampling: M. Hasan, F. Pellacini, K. Bala, "Matrix Row-Column Sampling for the
// Many-Light Problem" (2007). A few hundred receivers see every light; lights that are alike for
// them are clustered, and one light of each cluster lights the whole picture. What differs is as
// for LightSlice (light_slice.h).
#pragma once

#include <memory>

#include "core/many_lights/column_source.h"
#include "core/many_lights/slice_job.h"

namespace core::many_lights {

class RowColumn final : public ColumnSource {
public:
    /// Traces the rows and makes the clusters. Adds shadow rays to `rays`. Null when `stop` came
    /// first; throws an Error when the machine does not hold the rows, a number for each light.
    static std::unique_ptr<RowColumn> make(const SliceJob& job, std::span<const Receiver> receivers,
                                           uint32_t clusters, const std::stop_token& stop,
                                           uint64_t& rays);

    /// The same for every slice.
    void choose(const SliceRows&, uint32_t, CutMemory&, std::vector<LightCluster>& out,
                const std::stop_token&) const override
    {
        out = clusters_;
    }

private:
    std::vector<LightCluster> clusters_;
};

}  // namespace core::many_lights
