// LightSlice: J. Ou, F. Pellacini, "LightSlice: Matrix Slice Sampling for the Many-Lights Problem"
// (2011). One receiver of each slice sees every light; clusters of all lights for the whole picture
// are refined for each slice by what its neighbours see, since lights that are alike for a part of
// the picture need no telling apart there. What differs: entries are luminances; one scalar
// probability serves all colours, which makes the weights unbiased; lights that no sampled receiver
// sees are drawn by their brightness instead of being left out; and a slice's clusters are also
// told apart by what each light brings to it at most: a few receivers say nothing of lights that
// are near to others only, which is most of the error in corners.
#pragma once

#include <memory>

#include "core/many_lights/column_clusters.h"
#include "core/many_lights/column_source.h"
#include "core/many_lights/technique.h"

namespace core::many_lights {

class LightSlice final : public ColumnSource {
public:
    /// Traces the reduced matrix and makes the clusters of the whole picture. Keeps the light tree
    /// by reference. Adds shadow rays to `rays`. Null when `stop` came first; throws an Error when
    /// the machine does not hold the matrix, a number for each light and slice.
    static std::unique_ptr<LightSlice> make(const TechniqueInput& input,
                                            const std::stop_token& stop, uint64_t& rays);

    /// Clusters of the whole picture, refined over the rows of the slice's neighbours, and a
    /// representative for each.
    void choose(const SliceRows& rows, uint32_t slice, CutMemory& memory,
                std::vector<LightCluster>& out, const std::stop_token& stop) const override;

private:
    LightSlice(const TechniqueInput& input);
    double bytes(size_t slices) const;
    std::vector<uint32_t> neighbours(uint32_t slice) const;
    bool gatherColumns(const SliceRows& rows, uint32_t slice, ReducedMatrix& local,
                       const std::stop_token& stop) const;
    std::vector<float> localWeights(const ReducedMatrix& local) const;

    struct Place {
        glm::vec3 position{0}, normal{0};  // the latter in units of length
    };

    const LightTree& tree_;
    GatherSettings gather_;
    uint32_t clusters_ = 0, lights_ = 0;
    uint64_t seed_ = 0;
    std::vector<Place> places_;  // the mean of each slice
    ReducedMatrix matrix_;       // a row for each slice
    ColumnClusters global_;
    UnseenLights unseen_;
    std::vector<float> weights_;  // of representatives
};

}  // namespace core::many_lights
