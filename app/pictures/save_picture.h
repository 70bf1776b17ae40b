// A picture of the window as a file, with everything needed to render it again.
#pragma once

#include <filesystem>

#include "app/files/stats.h"
#include "app/pictures/picture.h"
#include "app/pictures/view_params.h"

namespace app {

/// EXR (mean, variance and first hits when the picture has them, metadata) or PNG (radiance through
/// exposure and tone curve of `view`), by the name's ending. The file appears when it is complete.
/// Throws core::Error; also for a preview, which nothing could render again, and one without
/// samples.
void savePicture(const std::filesystem::path& file, const Picture& picture, const ShownScene& scene,
                 const ViewParams& view);

/// What a picture of the window itself carries: the same, so that it can be replayed, too. A
/// preview stands for its full picture, of which there are no samples yet.
core::Metadata viewMetadata(const Picture& picture, const ShownScene& scene);

}  // namespace app
