// Numbers as people read them. See ui_text.h.
#include "app/view/ui/ui_text.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>

#include <imgui.h>

namespace app {
namespace {

/// Three significant digits of a value from 1 to below 1000.
std::string three(double value)
{
    if (value < 9.995) return format("%.2f", value);
    if (value < 99.95) return format("%.1f", value);
    return format("%.0f", value);
}

}  // namespace

std::string format(const char* pattern, ...)
{
    va_list arguments;
    va_start(arguments, pattern);
    va_list again;
    va_copy(again, arguments);
    const int length = std::vsnprintf(nullptr, 0, pattern, arguments);
    va_end(arguments);
    std::string text(length > 0 ? static_cast<size_t>(length) : 0, '\0');
    std::vsnprintf(text.data(), text.size() + 1, pattern, again);
    va_end(again);
    return text;
}

std::string countText(double value)
{
    if (!(value >= 0) || !std::isfinite(value)) return "-";
    if (value < 999.5)
        return value == std::floor(value) ? format("%.0f", value) : digitsText(value);
    const char* const prefixes[] = {" k", " M", " G", " T"};
    size_t i = 0;
    value /= 1000;
    while (value >= 999.5 && i < 3) {
        value /= 1000;
        ++i;
    }
    return three(value) + prefixes[i];
}

std::string countedText(uint64_t count, const char* noun)
{
    return countText(static_cast<double>(count)) + " " + noun + (count == 1 ? "" : "s");
}

std::string bytesText(uint64_t bytes)
{
    if (bytes < 1024) return format("%llu B", static_cast<unsigned long long>(bytes));
    const char* const units[] = {" KiB", " MiB", " GiB", " TiB"};
    double value = static_cast<double>(bytes) / 1024;
    size_t i = 0;
    while (value >= 999.5 && i < 3) {
        value /= 1024;
        ++i;
    }
    return (value < 0.995 ? format("%.2f", value) : three(value)) + units[i];
}

std::string secondsText(double seconds)
{
    if (!(seconds >= 0) || !std::isfinite(seconds)) return "-";
    if (seconds == 0) return "0 s";
    if (seconds < 0.0995) return digitsText(seconds * 1000) + " ms";
    if (seconds < 9.95) return format("%.2g s", seconds);
    if (seconds < 99.5) return format("%.1f s", seconds);
    const double whole = std::round(seconds);
    if (whole > 1e15) return digitsText(seconds) + " s";
    const auto total = static_cast<unsigned long long>(whole);
    if (total < 3600) return format("%llu:%02llu", total / 60, total % 60);
    return format("%llu:%02llu:%02llu", total / 3600, total / 60 % 60, total % 60);
}

std::string shortenedLabel(std::string text, float room)
{
    if (ImGui::CalcTextSize(text.c_str()).x <= room) return text;
    const auto isInside = [](char byte) { return (byte & 0xC0) == 0x80; };  // a letter of UTF-8
    while (text.size() > 1 && ImGui::CalcTextSize((text + "...").c_str()).x > room) {
        while (text.size() > 1 && isInside(text.back())) text.pop_back();
        text.pop_back();
    }
    return text + "...";
}

std::string wrappedAtSpaces(const std::string& text, float room)
{
    std::string wrapped;
    float line = 0;
    const float space = ImGui::CalcTextSize(" ").x;
    for (size_t at = 0; at <= text.size();) {
        const size_t end = std::min(text.find_first_of(" \n", at), text.size());
        const std::string word = text.substr(at, end - at);
        const float width = ImGui::CalcTextSize(word.c_str()).x;
        if (line > 0 && wrapped.back() == ' ' && line + width > room) {
            wrapped.back() = '\n';
            line = 0;
        }
        wrapped += word;
        line += width + space;
        if (end < text.size()) wrapped += text[end];
        if (end < text.size() && text[end] == '\n') line = 0;
        at = end + 1;
    }
    return wrapped;
}

std::string digitsText(double value)
{
    return format("%.3g", value);
}

}  // namespace app
