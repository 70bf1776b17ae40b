// What the EXR file of a picture says of its noise; its colours: app/files/picture_layers.h.
#pragma once

#include <optional>

#include "core/image/image.h"

namespace app {

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
