// PNG through libpng. Of what is wrapped around the pixels only header, palette and transparency
// are decoded: the rest is compressed or parsed, and a texture does not need it.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "core/image/raw_image.h"

namespace core {

bool isPng(EncodedImage bytes);

/// Values as stored: palettes become RGB, fewer than 8 bits become 8, a transparent colour becomes
/// alpha. Colour profiles and gamma are ignored, as glTF 2.0 demands.
DecodedImage decodePng(EncodedImage bytes, const ImageGuards& guards, std::stop_token stop = {});

/// The bytes of a file of 8-bit values as they are: 1 to 4 channels, sRGB colours, alpha not
/// multiplied in. `texts` become text entries (tEXt). `name` is that of the file in messages.
/// Throws core::Error.
std::vector<std::byte> encodePng(const std::string& name, uint32_t width, uint32_t height,
                                 uint32_t channels, std::span<const uint8_t> pixels,
                                 const std::map<std::string, std::string>& texts = {});

/// The bytes of a file of `width` by as many rows of one byte per pixel as there are; at least one.
std::string encodeGreyPng(uint32_t width, const std::vector<uint8_t>& pixels);

/// The uncompressed text entries (tEXt) up to the first chunk that is damaged.
std::map<std::string, std::string> pngText(EncodedImage bytes);

}  // namespace core
