// Where IlluminationCut may take pairs as a whole: in rooms of few planes, which see each other as
// a whole but for few edges.
#pragma once

#include "core/many_lights/light_tree.h"
#include "core/many_lights/pixel_tree.h"

namespace core::many_lights {

/// Whether nearly all lights lie in a few planes and face as these do.
bool lieInFewPlanes(const LightTree& tree);

/// Whether the receivers are Lambert's and lie side by side in pieces of one normal.
bool areFewFlatPieces(const PixelTree& tree, const SliceRows& rows);

}  // namespace core::many_lights
