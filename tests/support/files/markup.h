// A strict reader of HTML, for tests of pages that the program writes.
#pragma once

#include <set>
#include <string>
#include <vector>

namespace tests {

struct Markup {
    std::string problem;  // empty: well-formed
    std::set<std::string> ids, names;
    std::vector<std::string> references;
};

/// Walks the elements as a strict reader would: every one closed by its own end, attributes quoted,
/// no stray < or &.
Markup readMarkup(const std::string& html);

/// The page without its embedded pictures, whose base64 may spell any word.
std::string withoutPictures(std::string html);

}  // namespace tests
