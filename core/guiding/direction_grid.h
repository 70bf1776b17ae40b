// Directions of a leaf as a histogram that learns (shared/guide_histogram.h): sums for ever.
#pragma once

#include <array>
#include <span>

#include "core/guiding/lesson.h"

namespace core::guiding {

class DirectionGrid {
public:
    static constexpr size_t kCells = size_t(shared::kGuideSide) * shared::kGuideSide;

    /// Whether any lesson has brought light.
    bool knowsLight() const { return total_ > 0; }

    /// Half of everything: what a child inherits.
    void halve();

    void learn(std::span<const Lesson> lessons);

    /// shared::kHistogramWords in the order of shared::sampleHistogram; `moments`: the sums are of
    /// second moments, and the density is to be their root.
    void write(std::span<glm::vec4> words, bool moments) const;

private:
    void deposit(glm::vec2 square, float value);

    double total_ = 0;                   // of the cells
    std::array<float, kCells> cells_{};  // row by row
};

}  // namespace core::guiding
