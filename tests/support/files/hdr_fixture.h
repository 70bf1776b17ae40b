// Radiance pictures as their format defines them, for tests of what reads them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace tests {

/// How pixels are packed: not at all, by repeating whole pixels, or channel by channel (widths of 8
/// to 32767).
enum class HdrPacking { none, old, lines };

/// Red, green, blue and the exponent of each pixel, in the file's order, behind a header with this
/// line of sizes (such as "-Y 2 +X 4"); `width` pixels to a line.
std::vector<std::byte> makeHdr(const std::string& sizes, uint32_t width,
                               const std::vector<uint8_t>& rgbe, HdrPacking packing);

/// Three floats per pixel, rows from the top, each pixel with the smallest exponent that holds it.
std::vector<std::byte> makeHdr(uint32_t width, uint32_t height, const std::vector<float>& rgb);

}  // namespace tests
