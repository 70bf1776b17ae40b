// JPEG through libjpeg-turbo. Colour profiles are not decoded, and the size of a progressive file
// is judged before it is run through.
#pragma once

#include <stop_token>

#include "core/image/raw_image.h"

namespace core {

bool isJpeg(EncodedImage bytes);

/// One channel for grey, else three; the inks of Adobe's CMYK are multiplied by black. Colour
/// profiles and orientation are ignored. A file that was cut off or damaged within its pixels is
/// shown as far as it goes, and `damage` says so.
DecodedImage decodeJpeg(EncodedImage bytes, const ImageGuards& guards, std::stop_token stop = {});

}  // namespace core
