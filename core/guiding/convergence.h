// How fast the error of a picture falls: a Sobol sequence makes the mean of n samples better than n
// independent ones would be, the more so the simpler the light is. Told by the picture's own first
// samples, without a reference: for pictures m_a and m_2a, the first a samples of which they share,
// the mean of (m_a - m_2a)^2 is V_a - V_2a.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace core::guiding {

class Convergence {
public:
    /// Another picture begins; what is known stays known.
    void begin();

    /// The picture (RGB, rows of `width` pixels, which `estimates` are thought to have as
    /// luminance) after so many samples, of which one, two and four count. In the third and fourth
    /// samples one path in `stride` of a tile's was another one (shared::isRecorded), 0: none:
    /// these pixels do not count. Errors are relative to squares of pixels and `floor`.
    void note(uint64_t samples, std::span<const float> rgb, uint32_t width,
              std::span<const float> estimates, uint32_t stride, double floor);

    /// Variance of the mean of many samples over that of independent ones, from .5 to 1, after what
    /// one, two and four samples say beyond their own noise; 1 while nothing is known.
    double factor() const { return factor_; }

private:
    std::array<std::vector<float>, 2> means_;  // luminance, of one sample and of two
    double factor_ = 1;
};

}  // namespace core::guiding
