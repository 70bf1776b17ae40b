// Distributions that renderers invert: over emitters by power, over the texels of an environment by
// their radiance. A CDF is stored in float and its differences are the probabilities, exactly: all
// values are multiples of 2^-24, as the uniform numbers are, so nothing is lost between what is
// stored and what happens.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace core {

/// Most positive weights that a CDF can hold.
inline constexpr uint64_t kMaxCdfEntries = 1u << 22;

/// CDF of `weights` (finite, >= 0): weights.size() + 1 values from exactly 0 to exactly 1. A weight
/// of zero has probability zero, every positive one at least 2^-24. All zero: uniform. At most
/// kMaxCdfEntries weights may be positive.
std::vector<float> makeCdf(std::span<const double> weights);

/// Mean luminance of the bilinear look-up over each texel (1-6-1 by 1-6-1 over 64; wraps in x,
/// clamps in y) times its share of the sphere: positive wherever the environment shines. Row 0 is
/// at the +Y pole. Returned row by row.
std::vector<double> environmentWeights(std::span<const glm::vec4> texels, uint32_t width,
                                       uint32_t height);

/// The two-level CDF of world.h from weights: height + 1 values over rows, then width + 1 values
/// for each row; behind them, in the same order, for each of these the intervals in which the
/// shared::kCdfParts parts of [0,1) begin, and the last one.
std::vector<float> makeEnvironmentCdf(std::span<const double> weights, uint32_t width,
                                      uint32_t height);

}  // namespace core
