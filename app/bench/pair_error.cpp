// See pair_error.h.
#include "app/bench/pair_error.h"

#include <vector>

#include "app/bench/picture_error.h"
#include "core/base/check.h"
#include "core/image/metrics.h"

namespace app {

PairError pairError(const core::Image& a, const core::Image& b, const core::Image& level)
{
    CHECK(a.width == b.width && a.height == b.height && a.channels == 3 && b.channels == 3 &&
          level.pixels.size() == a.pixels.size());
    std::vector<double> ofPixels(size_t(a.width) * a.height);
    double sum = 0;
    for (size_t i = 0; i < a.pixels.size(); ++i) {
        const double d = static_cast<double>(a.pixels[i]) - static_cast<double>(b.pixels[i]);
        const auto r = static_cast<double>(level.pixels[i]);
        const double e = 0.5 * d * d / (r * r + core::kRelMseFloor);
        ofPixels[i / 3] += e / 3;
        sum += e;
    }
    return {sum / static_cast<double>(a.pixels.size()), trimmedMean(ofPixels, 0.01)};
}

}  // namespace app
