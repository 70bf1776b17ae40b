// What roulette takes for the value of a pixel while a picture is still noisy.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace core::guiding {

/// Luminance averaged over the 7x7 pixels around each, as far as they are in the picture; at least
/// 2 % of the whole picture's mean, so that dark corners do not keep every path alive. `rgb` row by
/// row. All zero (nothing is known) for a picture that is black.
std::vector<float> pixelEstimates(std::span<const float> rgb, uint32_t width, uint32_t height);

}  // namespace core::guiding
