// Three ways to predict which rows of a slice see a light, from those that have been traced: by a
// plane between light and shadow, by naive Bayes over lights and rows nearby, and by a vote of the
// rows nearby (Y. Huo, R. Wang, S. Jin, X. Liu, H. Bao, "A Matrix Sampling-and-Recovery Approach
// for Many-Lights Rendering", 2015). The paper's predictors are known to us by their names alone;
// what they are in detail is ours, and they draw no random numbers: the likelier answer is taken.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "core/completion/bits.h"

namespace core::many_lights {

/// What is known of one column: bit i of `visible` holds where bit i of `traced` is set, and is 0
/// elsewhere.
struct KnownColumn {
    std::span<const uint64_t> traced, visible;
};

/// A column that is thought to be similar: what is known or predicted of it, where it matters.
struct SimilarColumn {
    std::span<const uint64_t> matters, labels;
};

inline constexpr uint32_t kNear = 3;  // rows and columns that count as nearby

/// The nearest traced rows of a row, itself left out, the nearest first.
struct NearTraced {
    std::array<uint32_t, kNear> row{};
    uint32_t count = 0;
};

/// Finds rows by distance; ties go to the lower row.
class NearRows {
public:
    /// Keeps the places by reference.
    explicit NearRows(std::span<const glm::vec3> places);

    NearTraced find(uint32_t row, std::span<const uint64_t> traced) const;

private:
    float distance2(uint32_t a, uint32_t b) const;

    std::span<const glm::vec3> places_;
    uint32_t listed_;             // of each row
    std::vector<uint32_t> near_;  // by row, the nearest first
};

// Each sets, in `predicted`, the bits of rows that are `wanted` and thought to see the light, and
// clears all others.

/// The sign of a linear function of the place, fitted to 1 (visible) and -1 by least squares.
void predictLinear(std::span<const glm::vec3> places, const KnownColumn& known,
                   std::span<const uint64_t> wanted, std::span<uint64_t> predicted);

/// The answer of most of the nearest traced rows; `near` has one for each row that is wanted.
void predictByVote(std::span<const NearTraced> near, const KnownColumn& known,
                   std::span<const uint64_t> wanted, std::span<uint64_t> predicted);

/// Naive Bayes: the nearest traced rows and the labels of similar columns (kNear at most) count as
/// independent; how far each is to be trusted is counted in the traced rows. `near` has one for
/// each row that is wanted or traced.
void predictByBayes(std::span<const NearTraced> near, const KnownColumn& known,
                    std::span<const SimilarColumn> similar, std::span<const uint64_t> wanted,
                    std::span<uint64_t> predicted);

}  // namespace core::many_lights
