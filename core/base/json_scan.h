// What a JSON text would do to a parser, found out in one pass before there is a tree: the parser's
// tree is copied, written and destroyed by functions that call themselves.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace core {

constexpr int kMaxJsonDepth = 64;

struct JsonScan {
    std::string problem;  // "nested deeper than 64 levels at line 1, column 65"; empty: none
    // Commas, colons and opened brackets: so many values, keys and containers, about.
    uint64_t commas = 0, colons = 0, containers = 0;
};

/// Looks at brackets, commas and colons outside of strings; the grammar is the parser's business.
JsonScan scanJson(std::string_view text);

}  // namespace core
