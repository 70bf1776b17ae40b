// The command `compare`: how far one image is from another, as JSON.
#pragma once

#include <filesystem>
#include <ostream>

namespace app {

/// Writes one JSON object about two EXR files of equal size to `out`: rmse, relmse,
/// mean_signed_error, flip (HDR-FLIP, its mean), mean_image, mean_reference ([R, G, B]), the
/// formulas; when the reference stores variances, reference_noise (the RMSE that its own noise
/// makes); when both files do, welch_z (of the image means, of the channel where it is largest)
/// with details in welch: of methods whose pixels share their light without smallest_p, uniform_p
/// and p_histogram. Returns 0. Throws core::Error (bad input) when a file cannot be read, has no
/// colours, or the sizes differ.
int compareCommand(const std::filesystem::path& image, const std::filesystem::path& reference,
                   std::ostream& out);

}  // namespace app
