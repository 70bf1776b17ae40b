// Text that came from files or names, before it reaches a person, a terminal or JSON.
#pragma once

#include <string>
#include <string_view>

namespace core {

/// One line of valid UTF-8. Control characters (terminal escapes and line breaks among them),
/// separators of lines and marks that change the direction of writing stand as \x1b or \u2028,
/// bytes that are no UTF-8 as \xff. Longer than `longest` bytes: cut between letters, with "..."
/// behind.
std::string printable(std::string_view text, size_t longest = std::string_view::npos);

/// The same for text of several lines: line breaks and tabs stay.
std::string printableLines(std::string_view text);

/// "line 3, column 14" of a byte of a text.
std::string placeInText(std::string_view text, size_t offset);

}  // namespace core
