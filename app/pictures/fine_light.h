// The light of a small picture on the surfaces of a larger one of the same view: what first hits
// tell (edges, textures, lamps) need not be as coarse as what paths tell.
#pragma once

#include "core/image/image.h"
#include "core/methods/renderer.h"

namespace app {

/// A picture of the size of `fine`: at each pixel the light (radiance without emission, by albedo)
/// of the pixels of `mean` around that show the same surface, times the albedo there, and the
/// emission there. `aovs` are the first hits of `mean`, whose samples were taken at the centres of
/// its pixels, `fine` those of the larger picture; `camera` sees both. What no pixel around shows
/// has the light of others around.
core::Image lightOnSurfaces(const core::Image& mean, const core::Aovs& aovs, const core::Aovs& fine,
                            const core::Camera& camera);

}  // namespace app
