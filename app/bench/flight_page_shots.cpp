// Pictures within the page on flights. See flight_page_parts.h.
#include <cstdint>
#include <fstream>
#include <iterator>

#include "app/bench/flight_page_parts.h"
#include "app/report/page.h"
#include "app/report/text.h"

namespace app::flight {

namespace {

using namespace report;

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

/// An img element that holds its picture.
std::string image(const std::filesystem::path& file, const std::string& words)
{
    std::ifstream stream(file, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    return "<img alt=\"" + escapeMarkup(words) + "\" src=\"data:image/png;base64," + base64(bytes) +
           "\">";
}

std::string caption(const Shot& shot)
{
    std::string text = "<b>" + escapeMarkup(shot.name) + "</b>";
    if (shot.name == "reference") return text;
    if (shot.samples > 1) text += ", " + std::to_string(shot.samples) + " paths per pixel";
    return text + "<br>" + shortNumber(1e3 * shot.seconds) + " ms, relMSE " +
           shortNumber(shot.relMse);
}

}  // namespace

std::string shotsMarkup(const SceneResult& scene, const std::filesystem::path& folder)
{
    std::string html = paragraph(
        "The last frame of one flight each, all as bright as each other, and below each the part "
        "of it that is hardest for discard. discard with more paths per pixel is what discard can "
        "do in about the time of the slowest of the others.");
    html += "<div class=\"shots\">\n";
    for (const Shot& shot : scene.shots)
        html += "<figure>" + image(folder / shot.file, scene.name + ": " + shot.name) +
                image(folder / shot.part, "part of it") + "<figcaption>" + caption(shot) +
                "</figcaption></figure>\n";
    return html + "</div>\n";
}

}  // namespace app::flight
