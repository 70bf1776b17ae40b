// JPEG through libjpeg-turbo itself. OpenImageIO 2.4 decodes colour profiles, which crashes it when
// they are damaged, and runs through a progressive file before its size can be judged.
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
