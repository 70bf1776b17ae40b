// MatSep: Y. Huo, R. Wang, S. Jin, X. Liu, H. Bao, "A Matrix Sampling-and-Recovery Approach for
// Many-Lights Rendering" (2015). Visibility between the points of a slice and its clusters is
// predicted from few traced rows; what the clusters bring the points, as a matrix, is then split
// into one of low rank, which is summed, and a sparse one, which is thrown away as mistakes of the
// prediction. A sketch of the paper rather than the paper: of the original we know the three steps,
// the names of the predictors and the settings of one re-implementation (S. Wang's, 2020), not how
// slices and clusters are made (here as everywhere in this folder), nor what the predictors and the
// separation are in detail. Biased, twice: predictions are guesses, and light that is rightly
// sparse (a few points near a light, a thin beam) is taken away or smeared.
#pragma once

#include <memory>

#include "core/completion/matrix_separation.h"
#include "core/completion/visibility_prediction.h"
#include "core/many_lights/column_source.h"
#include "core/many_lights/slice_lighter.h"

namespace core::many_lights {

struct MatSepSettings {
    PredictionSettings prediction;
    FactorSettings separation;
    bool separates = true;  // false: the matrix is summed as predicted
};

class MatSep final : public SliceLighter {
public:
    MatSep(std::unique_ptr<const ColumnSource> columns, const MatSepSettings& settings)
        : columns_(std::move(columns)), settings_(settings)
    {}

    bool light(const SliceJob& job, std::span<const Receiver> receivers,
               std::span<const uint32_t> chosen, uint32_t slice, const std::stop_token& stop,
               std::span<glm::vec3> radiance, SliceStats& stats) const override;

private:
    std::unique_ptr<const ColumnSource> columns_;
    MatSepSettings settings_;
};

}  // namespace core::many_lights
