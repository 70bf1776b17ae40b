// The files of a render command: what it would write, and what it must not write over.
#pragma once

#include <filesystem>

#include "app/args/args.h"

namespace app {

/// The file of frame `index`.
std::filesystem::path pictureFile(const RenderOptions& options, uint32_t index);

/// Everything about files that can be refused before work begins. Throws core::Error: for names
/// that cannot be written, and (command line) where a picture or the statistics would replace each
/// other or a file that the command reads: the scene's own, its buffers and images, its
/// environment, the reference, the camera, the path.
void checkFiles(const RenderOptions& options);

}  // namespace app
