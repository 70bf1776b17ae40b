// Words and numbers as the pages of measurements write them.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace app::report {

/// Text safe inside elements and quoted attributes.
std::string escapeMarkup(std::string_view text);

/// About `digits` significant digits for a reader: "0.836", "12.8", "2.1·10⁻⁵", "∞", "–" for NaN.
std::string shortNumber(double value, int digits = 3);

/// With a fixed number of decimals and a real minus sign.
std::string fixedNumber(double value, int decimals);

/// A round number as a tick of an axis shows it: "10⁻⁵", "1", "5000".
std::string roundNumber(double value);

/// "−6.6 %", of a fraction.
std::string percent(double fraction, int digits = 2);

/// "0.0988 ± 0.0007": as many digits as the error leaves.
std::string measured(double value, double error);

/// "1 cell", "3 cells".
std::string counted(size_t count, const std::string& noun);

/// "62 of 72".
std::string outOf(size_t count, size_t all);

/// Spaces behind a text, up to `width` bytes in all; one at least, so that columns stay apart.
std::string padded(const std::string& text, size_t width);

/// A number as printf writes it; "-" unless finite.
std::string printed(const char* pattern, double value);

}  // namespace app::report
