// Numbers as people read them.
#pragma once

#include <cstdint>
#include <string>

namespace app {

/// Three significant digits and a prefix: 950, 12.3 k, 4.56 M.
std::string countText(double value);

/// "1 emitter", "12.3 k triangles".
std::string countedText(uint64_t count, const char* noun);

/// 950 B, 12.3 KiB, 4.56 GiB.
std::string bytesText(uint64_t bytes);

/// 3.2 ms, 0.42 s, 12.3 s, 4:05, 2:03:04. "-" when not finite or negative.
std::string secondsText(double seconds);

/// Three significant digits without a prefix: 0.0123, 4.56, 1.2e-06.
std::string digitsText(double value);

/// In the present font; letters are left out at the end of what is wider than `room`.
std::string shortenedLabel(std::string text, float room);

/// In the present font, with line ends in place of spaces so that each line has `room`. Dear
/// ImGui's own wrapping also breaks behind full stops: "(." and "exr)". Words without room stay
/// whole.
std::string wrappedAtSpaces(const std::string& text, float room);

/// printf into a string.
std::string format(const char* pattern, ...) __attribute__((format(printf, 1, 2)));

}  // namespace app
