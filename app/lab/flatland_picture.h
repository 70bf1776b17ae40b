// Flatland as a renderer would show it: the pixels of the camera that moved, each estimated many
// times over by each way to go on, so that grain and wrong brightness can be seen.
#pragma once

#include <cstdint>

#include "app/lab/results.h"

namespace app::lab {

/// The settings of the samples that are drawn one by one are those of the variant "exact" of
/// flatlandVariants(); the strips are named after the variants that they show.
FlatlandPicture flatlandPicture(uint64_t seed);

}  // namespace app::lab
