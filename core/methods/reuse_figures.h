// What a picture made by sample reuse says of itself, on every device.
#pragma once

#include <algorithm>
#include <vector>

#include "core/methods/renderer.h"
#include "core/methods/reuse_params.h"

namespace core {

/// Sums over first hits that scatter.
struct ReuseFigures {
    double scatters = 0;     // how many there are
    double withHistory = 0;  // those that have samples of the view before
    double weights = 0;  // of the sums of v: one each on average, less where directions are lost
    double shares = 0;   // of c
    double paths = 0;    // new ones, of all pixels

    std::vector<StatsDetail> details(ReuseStrategy strategy, uint32_t records, double pixels) const
    {
        const double count = scatters > 0 ? scatters : 1;
        const char* bias = strategy == ReuseStrategy::discard ? "none"
                           : strategy == ReuseStrategy::naive || strategy == ReuseStrategy::svgf
                               ? "old light as it was"
                               : "visibility of old samples";
        return {{"bias", std::string(bias)},  {"history", withHistory / count},
                {"c", shares / count},        {"n", paths / std::max(pixels, 1.0)},
                {"weights", weights / count}, {"records", double(records)}};
    }
};

}  // namespace core
