// FLIP: the difference that a person sees when two images alternate on a screen, in [0, 1] per
// pixel.
//   Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astrom, Fairchild, "FLIP: A Difference
//   Evaluator for Alternating Images", 2020 (low dynamic range); Andersson, Nilsson, Shirley,
//   Akenine-Moeller, "Visualizing Errors in Rendered High Dynamic Range Images", 2021. Written from
//   the papers; deviations stand at flipHdr.
#pragma once

#include <stop_token>

#include "core/image/image.h"

namespace core {

/// Pixels per degree at 0.7 m from a screen 0.7 m wide of 3840 pixels, the papers' viewer: 0.7 /
/// 0.7 * 3840 * pi / 180.
inline constexpr double kFlipPixelsPerDegree = 67.02064327658226;

/// Error per pixel of two images of linear RGB in [0, 1] as a screen shows them (values outside are
/// clamped). Symmetric. Both images have the same size and at least three channels.
Image flipLdr(const Image& image, const Image& reference,
              double pixelsPerDegree = kFlipPixelsPerDegree);

/// Exposures (in stops) between which the HDR metric looks, and in how many steps.
struct FlipExposures {
    double start = 0, stop = 0;
    int count = 2;
};

/// Chosen from the reference's luminance: at `start` its brightest pixel, at `stop` its median is
/// shown at 0.85 of white; one step per stop, at least two. The papers' choice has no answer when
/// the median is zero: then the median of the pixels above zero counts, and an image without light
/// is compared as it is. At most 40 stops.
FlipExposures flipExposures(const Image& reference);

struct FlipResult {
    Image map;        // one channel: the largest error over all exposures
    double mean = 0;  // of the map
    FlipExposures exposures;
};

/// HDR-FLIP of linear radiance: per pixel the largest low-dynamic-range error over exposures, each
/// through the ACES curve of Narkowicz. Negative radiance counts as zero; a pixel that is not
/// finite in one image or the other has error 1 (the papers leave both undefined). Equal sizes, at
/// least three channels. After a `stop` the result is of no use.
FlipResult flipHdr(const Image& image, const Image& reference,
                   double pixelsPerDegree = kFlipPixelsPerDegree, std::stop_token stop = {});

}  // namespace core
