// Images of scenes, decoded behind guards: the content's first bytes choose one of four readers,
// and the size is checked before a pixel is allocated.
#pragma once

#include <stop_token>
#include <vector>

#include "core/image/raw_image.h"
#include "core/scene/scene.h"

namespace core {

/// Decodes PNG, JPEG, OpenEXR or Radiance bytes. Alpha is not multiplied in.
DecodedImage decodeImage(EncodedImage bytes, const ImageGuards& guards, std::stop_token stop = {});

/// Half floats for renderers. `color`: integers are decoded from sRGB to linear (alpha never is);
/// floats are linear already. Grey becomes three equal channels, missing alpha one. `repaired`
/// counts values that are not finite, negative or beyond the range of half floats; they become 0, 0
/// and 65504.
Texture makeTexture(const RawImage& image, bool color, uint64_t& repaired);

/// The same as 32-bit floats, linear; values above 1e30 are lowered to it.
std::vector<glm::vec4> makeRadiance(const RawImage& image, uint64_t& repaired);

/// Magenta and grey squares: stands for a base colour that cannot be shown.
Texture checkerTexture();

}  // namespace core
