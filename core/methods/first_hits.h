// From first hits, as every device finds them (shared/first_hit.h), to images. The one place where
// ids become floats: exact below 2^24, which images of floats cannot exceed.
#pragma once

#include "core/methods/renderer.h"
#include "shared/first_hit.h"

namespace core {

/// First-hit images of that size in which nothing has been hit.
Aovs emptyAovs(uint32_t width, uint32_t height);

/// Writes the first hit of the pixel with that index, row by row from the top.
void storeFirstHit(const shared::FirstHit& hit, size_t pixel, Aovs& aovs);

}  // namespace core
