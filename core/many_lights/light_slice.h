// LightSlice: J. Ou, F. Pellacini, "LightSlice: Matrix Slice Sampling for the Many-Lights Problem"
// (2011). One receiver of each slice sees every light; clusters of all lights for the whole picture
// are refined for each slice by what its neighbours see, since lights that are alike for a part of
// the picture need no telling apart there. What differs: entries are luminances; one scalar
// probability serves all colours, which makes the weights unbiased; and lights that no sampled
// receiver sees are drawn by their brightness instead of being left out.
#pragma once

#include <memory>

#include "core/many_lights/column_clusters.h"
#include "core/many_lights/column_source.h"
#include "core/many_lights/slices.h"

namespace core::many_lights {

class LightSlice final : public ColumnSource {
public:
    /// Traces the reduced matrix and makes the clusters of the whole picture. Keeps the job's
    /// lights by reference. Adds shadow rays to `rays`. Null when `stop` came first.
    static std::unique_ptr<LightSlice> make(const SliceJob& job,
                                            std::span<const Receiver> receivers,
                                            const Slices& slices, const SliceSettings& slicing,
                                            uint32_t clusters, const std::stop_token& stop,
                                            uint64_t& rays);

    /// Clusters of the whole picture, refined over the rows of the slice's neighbours, and a
    /// representative for each.
    void choose(const SliceRows& rows, uint32_t slice, CutMemory& memory,
                std::vector<LightCluster>& out) const override;

private:
    LightSlice() = default;
    std::vector<uint32_t> neighbours(uint32_t slice) const;
    std::vector<float> localWeights(const ReducedMatrix& local) const;

    struct Place {
        glm::vec3 position{0}, normal{0};  // the latter in units of length
    };

    uint32_t clusters_ = 0, lights_ = 0;
    uint64_t seed_ = 0;
    std::vector<Place> places_;  // the mean of each slice
    ReducedMatrix matrix_;       // a row for each slice
    ColumnClusters global_;
    UnseenLights unseen_;
    std::vector<float> weights_;  // of representatives
};

}  // namespace core::many_lights
