// The metadata of a picture without its pixels.
#pragma once

#include <filesystem>

#include "core/image/image.h"

namespace core {

/// Of an EXR or PNG, by the name's ending; empty when another program wrote the file. Throws
/// core::Error.
Metadata readMetadata(const std::filesystem::path& file);

}  // namespace core
