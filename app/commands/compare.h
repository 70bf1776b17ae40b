// The command `compare`: how far one image is from another, as JSON.
#pragma once

#include <filesystem>
#include <ostream>

namespace app {

/// Writes one JSON object about two EXR files of equal size to `out`: rmse, relmse,
/// mean_signed_error, flip (HDR-FLIP, its mean), mean_image, mean_reference ([R, G, B]), the
/// formulas and, when both files store variances, welch_z (of the image means, of the channel where
/// it is largest) with details in welch. Returns 0. Throws core::Error (bad input) when a file
/// cannot be read, has no colours, or the sizes differ.
int compareCommand(const std::filesystem::path& image, const std::filesystem::path& reference,
                   std::ostream& out);

}  // namespace app
