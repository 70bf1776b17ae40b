// A picture from an EXR file, as errors are measured on it: its colours, and what its file says of
// its noise.
#pragma once

#include <filesystem>
#include <optional>

#include "core/image/image.h"

namespace app {

/// The picture as R, G, B; a single channel counts for all three. Throws core::Error naming the
/// `file` and its layers when there are no channels outside of layers.
core::Image storedColors(const core::ImageFile& content, const std::filesystem::path& file);

/// Whether there is the variance of R, G, B.
bool hasVariance(const core::ImageFile& content);

/// The RMSE that a perfect picture would have against this one: what its own noise makes.
/// `isBound`: no more than that, since the variances of Sobol samples are upper bounds.
struct StoredNoise {
    double rmse = 0;
    bool isBound = false;
};

/// Nothing without variances.
std::optional<StoredNoise> storedNoise(const core::ImageFile& content);

/// Whether the metadata say that samples were of a Sobol sequence: the variance that their spread
/// leads to expect is an upper bound then.
bool usesSobol(const core::ImageFile& content);

/// Whether the metadata name a method whose pixels share their light (Traits::sharesLight): their
/// errors go together.
bool sharesLight(const core::ImageFile& content);

}  // namespace app
