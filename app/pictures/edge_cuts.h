// Edges of coarse pictures that are aslant: where the steps that their pixels make are cut.
#pragma once

#include "core/image/image.h"

namespace app {

/// Adds to the bits of a guide (surfaceGuide) the cuts for shared::displayCut: a line from the
/// middle of each step of an edge to that of the next, as in Reshetov, "Morphological
/// Antialiasing", 2009, but of surfaces. Steps are one pixel high; edges along rows and columns,
/// their corners and what is one pixel thick stay as they are.
void addCuts(core::Image& guide);

}  // namespace app
