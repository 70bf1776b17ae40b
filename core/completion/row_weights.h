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
    /// Of every row. Valid until they change.
    std::span<const double> weights();

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

    /// Rows begin <= i < end side by side that are known and have equal bits.
    struct Piece {
        uint32_t begin = 0, end = 0, run = 0;
    };

    double& step(uint32_t row) { return steps_[size_t(row % kRun) * runs_ + row / kRun]; }
    void findPieces(std::span<const uint64_t> column, std::span<const uint64_t> known);
    void raise(uint32_t begin, uint32_t end, double by);
    void cumulate();
    uint32_t pick(Pcg32& random) const;
    template <class Take>
    uint32_t drawUntil(uint32_t count, uint32_t attempts, Pcg32& random, Take&& take);
    void drawByKeys(uint32_t count, std::span<const uint64_t> eligible, Pcg32& random,
                    std::span<uint64_t> drawn);

    uint32_t count_ = 0;
    size_t runs_ = 0;
    // What a row weighs more than the one before it in its run of kRun, or altogether, where it is
    // the first. A column that becomes known changes few of these and nearly all weights. The first
    // rows of all runs, then the second ones, and so on.
    std::vector<double> steps_;
    std::vector<double> weights_;
    // Floats, of which twice as many are compared at a time: rows are drawn right to 1e-7 of all.
    std::vector<float> cumulated_;  // empty: weights have changed
    std::vector<float> runSums_;    // up to the end of every run but the last; then infinity
    std::vector<double> rowOfRun_, inRun_;  // weights and sums within runs, while they are made
    float below_ = 0;                       // the largest number below the sum of all
    double total_ = 0;
    std::vector<Piece> pieces_;     // of a column
    std::vector<uint32_t> length_;  // of its runs
};

/// Draws `count` rows of `eligible` uniformly without replacement, all of them when there are not
/// more; sets their bits in `drawn`, which is zero. Returns the probability of each to be drawn.
double drawUniform(uint32_t count, std::span<const uint64_t> eligible, Pcg32& random,
                   std::span<uint64_t> drawn);

}  // namespace core::many_lights
