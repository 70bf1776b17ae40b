// See text.h.
#include "core/base/text.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>

namespace core {

namespace {

struct Letter {
    uint32_t code = 0;
    size_t bytes = 0;  // 0: no UTF-8 begins here
};

/// RFC 3629: no overlong forms, no surrogates, nothing beyond U+10FFFF.
Letter firstLetter(std::string_view text)
{
    const auto byte = [&](size_t i) { return static_cast<uint8_t>(text[i]); };
    const uint8_t first = byte(0);
    if (first < 0x80) return {first, 1};
    const size_t count = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : first >= 0xc2 ? 2 : 0;
    if (count == 0 || first > 0xf4 || text.size() < count) return {};
    uint32_t code = first & (0x7fu >> count);
    for (size_t i = 1; i < count; ++i) {
        if ((byte(i) & 0xc0) != 0x80) return {};
        code = code << 6 | (byte(i) & 0x3fu);
    }
    constexpr std::array<uint32_t, 5> smallest{0, 0, 0x80, 0x800, 0x10000};
    if (code < smallest[count] || code > 0x10ffff || (code >= 0xd800 && code < 0xe000)) return {};
    return {code, count};
}

/// Whether a terminal or a reader would be led astray: C0 and C1 controls, separators, marks of
/// direction (Unicode TR 36), the byte order mark.
bool misleads(uint32_t code)
{
    return code < 0x20 || (code >= 0x7f && code < 0xa0) || code == 0x61c || code == 0xfeff ||
           (code >= 0x200e && code <= 0x200f) || (code >= 0x2028 && code <= 0x202e) ||
           (code >= 0x2066 && code <= 0x2069);
}

std::string escaped(const char* format, uint32_t value)
{
    std::array<char, 16> text{};
    std::snprintf(text.data(), text.size(), format, value);
    return text.data();
}

std::string escapedText(std::string_view text, size_t longest, std::string_view kept)
{
    std::string result;
    while (!text.empty()) {
        const Letter letter = firstLetter(text);
        std::string shown(text.substr(0, std::max<size_t>(letter.bytes, 1)));
        if (letter.bytes == 0)
            shown = escaped("\\x%02x", static_cast<uint8_t>(text[0]));
        else if (misleads(letter.code) && kept.find(text[0]) == std::string_view::npos)
            shown = escaped(letter.code < 0x100 ? "\\x%02x" : "\\u%04x", letter.code);
        if (result.size() + shown.size() > longest) return result.append("...");
        result.append(shown);
        text.remove_prefix(std::max<size_t>(letter.bytes, 1));
    }
    return result;
}

}  // namespace

std::string printable(std::string_view text, size_t longest)
{
    const auto isPlain = [](char c) { return c >= 0x20 && c < 0x7f; };
    if (text.size() <= longest && std::ranges::all_of(text, isPlain)) return std::string(text);
    return escapedText(text, longest, "");
}

std::string printableLines(std::string_view text)
{
    return escapedText(text, std::string_view::npos, "\n\t");
}

std::string placeInText(std::string_view text, size_t offset)
{
    const std::string_view before = text.substr(0, offset);
    const auto lines = std::count(before.begin(), before.end(), '\n');
    const size_t lineStart = before.rfind('\n');
    const size_t column = lineStart == std::string_view::npos ? offset + 1 : offset - lineStart;
    return "line " + std::to_string(lines + 1) + ", column " + std::to_string(column);
}

}  // namespace core
