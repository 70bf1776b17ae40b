// Errors of pictures without a reference: two pictures of independent seeds differ by the noise of
// both, so that half of the squared difference is the squared error of one. A bias does not show.
#pragma once

#include "core/image/image.h"

namespace app {

/// relMSE as in core/image/metrics.h, but that the radiance which errors are relative to is given.
struct PairError {
    double all = 0;
    double trimmed = 0;  // without the hundredth of the pixels in which it is largest
};

/// The expected error of one of two pictures of independent seeds, from both, relative to `level`.
/// Of one size, three channels.
PairError pairError(const core::Image& a, const core::Image& b, const core::Image& level);

}  // namespace app
