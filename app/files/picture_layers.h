// Colours of a picture file and their variance as errors are measured on them, whatever program
// wrote it.
#pragma once

#include <filesystem>
#include <optional>

#include "core/image/image.h"

namespace app {

/// R, G, B: the first three channels outside of layers; fewer than three count as grey, by the
/// first. Throws core::Error naming the `file` and its layers where all channels are in layers.
core::Image rgbOf(const core::ImageFile& content, const std::filesystem::path& file);

/// The variance of R, G, B; nothing where there is none, or one of fewer channels.
std::optional<core::Image> rgbVarianceOf(const core::ImageFile& content);

}  // namespace app
