// PNG through libpng itself. OpenImageIO 2.4 decodes what is wrapped around the pixels, too: a
// damaged colour profile crashes it. Here only header, palette, transparency and pixels are read.
#pragma once

#include <cstdint>
#include <map>
#include <stop_token>
#include <string>
#include <vector>

#include "core/image/raw_image.h"

namespace core {

bool isPng(EncodedImage bytes);

/// Values as stored: palettes become RGB, fewer than 8 bits become 8, a transparent colour becomes
/// alpha. Colour profiles and gamma are ignored, as glTF 2.0 demands.
DecodedImage decodePng(EncodedImage bytes, const ImageGuards& guards, std::stop_token stop = {});

/// The bytes of a file of `width` by as many rows of one byte per pixel as there are; at least one.
std::string encodeGreyPng(uint32_t width, const std::vector<uint8_t>& pixels);

/// The uncompressed text entries (tEXt) up to the first chunk that is damaged.
std::map<std::string, std::string> pngText(EncodedImage bytes);

}  // namespace core
