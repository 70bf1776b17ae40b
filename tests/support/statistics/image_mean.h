// The mean of a picture.
#pragma once

#include "core/image/image.h"

namespace tests {

/// Over all pixels and channels.
inline double meanOf(const core::Image& image)
{
    double sum = 0;
    for (const float x : image.pixels) sum += double(x);
    return sum / double(image.pixels.size());
}

}  // namespace tests
