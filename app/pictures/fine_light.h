// The light of a small picture on the surfaces of a larger one: what first hits tell (edges,
// textures, lamps) need not be as coarse as what paths tell, nor as old.
#pragma once

#include "core/image/image.h"
#include "core/methods/renderer.h"

namespace app {

/// First hits, and the camera that sees them.
struct SeenSurfaces {
    const core::Aovs& aovs;
    const core::Camera& camera;
};

/// A picture of the size of `fine`: at each pixel the light (radiance without emission, by albedo)
/// of the pixels of `mean` around that show the same surface, times the albedo there, and the
/// emission there. `coarse` are the first hits of `mean`, whose samples were taken at the centres
/// of its pixels; the camera may have moved on since. What no pixel around shows has the light of
/// others around.
core::Image lightOnSurfaces(const core::Image& mean, const SeenSurfaces& coarse,
                            const SeenSurfaces& fine);

}  // namespace app
