// What first hits tell of a picture that has no light yet: coarse pictures of a moving camera shall
// show where one is. None of this is in a picture at rest.
#pragma once

#include "core/image/image.h"
#include "core/methods/renderer.h"

namespace app {

/// First hits as a lamp at the camera would show them, in values for the display at exposure 0:
/// reflectances, darker where a surface turns away, emitters white, nothing hit nearly black.
core::Image litFromCamera(const core::Aovs& aovs, const core::Camera& camera);

/// Pixels of radiance to which no path has brought light, though they show a surface, get what a
/// lamp at the camera of the picture's own mean luminance would make of it.
void fillUnlit(core::Image& mean, const core::Aovs& aovs, const core::Camera& camera);

/// Which neighbours of each pixel show the surface that it shows, as bits, for the display: see
/// shared::displayGuided. Equal normals within 25 degrees and distances within a quarter are one
/// surface, and so is nothing hit beside nothing hit. Beside the bits: where edges aslant cut
/// pixels (edge_cuts.h).
core::Image surfaceGuide(const core::Aovs& aovs);

/// Whether all of it is there and of that size.
bool fits(const core::Aovs& aovs, const core::Image& image);

}  // namespace app
