// Which rows of a slice are worth a ray: weights that grow at the borders of known shadows (S.
// Wang, N. Holzschuch, "Adaptive Matrix Completion for Fast Visibility Computations with Many
// Lights Rendering", 2020), and draws of rows.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/pcg32.h"

namespace core::many_lights {

/// A whole number below `end`.
inline uint32_t drawBelow(uint32_t end, Pcg32& random)
{
    return static_cast<uint32_t>((uint64_t(random.bits()) * end) >> 32);
}

class RowWeights {
public:
    /// All rows alike.
    explicit RowWeights(uint32_t rows);

    uint32_t rows() const { return count_; }
    std::span<const double> weights() const { return {weights_.data(), count_}; }

    /// A column has become known where `known` is set. Each of its R runs of equal bits (over the
    /// known rows, in their order) receives 1 / R, evenly over its rows: rows of short runs lie at
    /// shadow borders.
    void addRuns(std::span<const uint64_t> column, std::span<const uint64_t> known);

    /// Draws `count` rows of `eligible`, one after the other, each with a probability proportional
    /// to its weight among those left; all of them when there are not more. Sets their bits in
    /// `drawn`, which is zero. A. Wong, M. Easton, "An Efficient Method for Weighted Sampling
    /// without Replacement" (1980), has the same distribution; here draws that repeat are rejected.
    void draw(uint32_t count, std::span<const uint64_t> eligible, Pcg32& random,
              std::span<uint64_t> drawn);

    /// The same with replacement, as the thesis draws; fewer rows may come out.
    void drawWithReplacement(uint32_t count, std::span<const uint64_t> eligible, Pcg32& random,
                             std::span<uint64_t> drawn);

private:
    static constexpr uint32_t kRun = 32;  // rows whose sums are searched together

    void addWhere(std::span<const uint64_t> known);
    void cumulate();
    uint32_t pick(Pcg32& random) const;
    template <class Take>
    uint32_t drawUntil(uint32_t count, uint32_t attempts, Pcg32& random, Take&& take);
    void drawByKeys(uint32_t count, std::span<const uint64_t> eligible, Pcg32& random,
                    std::span<uint64_t> drawn) const;

    uint32_t count_ = 0;
    std::vector<double> weights_;  // padded with zeros to whole runs
    // Floats, of which twice as many are compared at a time: rows are drawn right to 1e-7 of all.
    std::vector<float> cumulated_;  // empty: weights have changed
    std::vector<float> runSums_;    // up to the end of every run but the last
    std::vector<double> inRun_;     // sums within runs, while they are made
    float below_ = 0;               // the largest number below the sum of all
    double total_ = 0;
    std::vector<uint64_t> packed_;
    std::vector<uint32_t> ends_;
    std::vector<double> shareOfRow_;
};

/// Draws `count` rows of `eligible` uniformly without replacement, all of them when there are not
/// more; sets their bits in `drawn`, which is zero. Returns the probability of each to be drawn.
double drawUniform(uint32_t count, std::span<const uint64_t> eligible, Pcg32& random,
                   std::span<uint64_t> drawn);

}  // namespace core::many_lights
