// Pictures made of pixels, within the page: as PNG in the address of an image.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace app::report {

/// From black, 0, to white, 255; row by row from the top.
struct GreyImage {
    uint32_t width = 0;
    std::vector<uint8_t> values;
};

/// "data:image/png;base64,...". At least one whole row.
std::string pngData(const GreyImage& image);

/// An img element that holds the picture of a PNG file; `words` for who cannot see it.
std::string embeddedPng(const std::filesystem::path& file, const std::string& words);

}  // namespace app::report
