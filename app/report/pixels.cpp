// See pixels.h.
#include "app/report/pixels.h"

#include <fstream>
#include <iterator>

#include "app/report/text.h"
#include "core/image/png_file.h"

namespace app::report {

namespace {

/// Bytes as text (RFC 4648).
std::string base64(const std::string& bytes)
{
    constexpr const char* kLetters =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (size_t i = 0; i < bytes.size(); i += 3) {
        uint32_t three = 0;
        for (size_t k = 0; k < 3; ++k)
            three = three << 8u | (i + k < bytes.size() ? uint8_t(bytes[i + k]) : 0u);
        for (size_t k = 0; k < 4; ++k)
            text += i + k > bytes.size() ? '=' : kLetters[three >> (18 - 6 * k) & 63u];
    }
    return text;
}

std::string dataAddress(const std::string& png)
{
    return "data:image/png;base64," + base64(png);
}

}  // namespace

std::string pngData(const GreyImage& image)
{
    return dataAddress(core::encodeGreyPng(image.width, image.values));
}

std::string embeddedPng(const std::filesystem::path& file, const std::string& words)
{
    std::ifstream stream(file, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    return "<img alt=\"" + escapeMarkup(words) + "\" src=\"" + dataAddress(bytes) + "\">";
}

}  // namespace app::report
