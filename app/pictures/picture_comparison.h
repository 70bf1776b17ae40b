// Which of two pictures of one view came from the more efficient way to render: errors with
// intervals, and the ratio of the efficiencies, 1 / (error^2 x time), with its own.
//   The pictures are cut into tiles of 8x8 pixels, whose sums of squared errors are taken as
//   independent draws, their spread from the differences of neighbours. What a tile shows moves the
//   errors of both pictures together, so the ratio is judged from pairs of tiles (Fieller, "Some
//   Problems in Interval Estimation", 1954), not from the intervals of the two. A single error's
//   interval knows no pairs and is rather too wide.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "app/pictures/picture.h"

namespace app {

/// A number and the ends of its interval of 95 %; `high` may be infinite.
struct Bounded {
    double value = 0, low = 0, high = 0;
};

/// A picture with what it took.
struct TimedPicture {
    const core::Image& mean;
    const core::Image* variance = nullptr;  // of the mean; may be absent
    uint64_t samples = 0;
    double seconds = 0;
};

struct SideErrors {
    uint64_t samples = 0;
    double seconds = 0;
    Bounded rmse, relMse;  // defined as in core/image/metrics.h
};

struct PictureComparison {
    enum class Source { none, reference, variance };
    Source source = Source::none;  // what the errors are measured against
    std::string whyNot;            // of none
    std::array<SideErrors, 2> sides;
    /// How much less time B needs for an equal error: above 1 B is the better one. By the squared
    /// error, and by the squared relative error.
    Bounded byRmse, byRelMse;
    double referenceNoise = 0;  // RMSE of the reference itself, at most; 0: unknown
};

/// Errors against the reference. Its own noise is part of the values; the intervals also hold what
/// is left without it, as its variance says, which stratified samples make an upper bound. With
/// null: from the pictures' own variances, which know nothing of a bias. Relative errors need a
/// reference whose own relMSE is not above 0.05; else they stay unknown. Pixels that are not finite
/// in any of the images are left out. Nothing (`whyNot`) when sizes differ or there is neither
/// reference nor variance.
PictureComparison comparePictures(const TimedPicture& a, const TimedPicture& b,
                                  const Reference* reference);

/// What has to be known to read the numbers, one sentence each.
std::vector<std::string> comparisonNotes(const PictureComparison& comparison);

/// "B needs 1.8 times less time than A for an equal RMSE", "... no difference is seen".
std::string verdict(const Bounded& ratio, const char* of);

/// "1.83 (1.75 to 1.90)": digits by the standard error that the interval stands for.
std::string boundedText(const Bounded& bounded);

/// The value and the ends with those digits.
struct BoundedDigits {
    std::string value, low, high;
};
BoundedDigits boundedDigits(const Bounded& bounded);

/// All of it as lines of text with tabs, for the clipboard: `labels` say how A and B were made.
std::string comparisonText(const PictureComparison& comparison,
                           const std::array<std::string, 2>& labels);

}  // namespace app
