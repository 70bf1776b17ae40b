// The light of one sample, averaged over the surfaces that it fell on: a coarse picture of few lit
// pixels becomes one to steer by. None of this is in a picture of the full size.
#pragma once

#include "core/image/image.h"
#include "core/methods/renderer.h"

namespace app {

/// Replaces the light that surfaces reflect (radiance by albedo, so that textures stay) by its
/// average over the pixels around that show the same surface: as many as take its own standard
/// error to 12 %, 32 to each side at most. Averages give every pixel's light away whole: the sum
/// over pixels of one albedo stays. Where most pixels have had none and the average is dark, what a
/// lamp at the camera would show is added, less than fillUnlit() adds. Emitters and what is behind
/// everything keep their values, but for single pixels at their rims that show something else.
void spreadLight(core::Image& mean, const core::Aovs& aovs, const core::Camera& camera);

}  // namespace app
