// Suggestions for mistyped names.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace app {

/// Number of insertions, deletions, replacements and swaps of neighbours between two words
/// (restricted Damerau-Levenshtein distance; Damerau 1964, Lowrance and Wagner 1975).
size_t editDistance(std::string_view a, std::string_view b);

/// The name closest to `word`, or an empty string when none is close enough to be meant.
std::string nearestName(std::string_view word, std::span<const std::string> names);

/// "; did you mean X?" or nothing.
std::string suggestion(std::string_view word, std::span<const std::string> names);

}  // namespace app
