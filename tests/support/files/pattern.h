// Regular expressions for tests. <regex> stands behind this one file: it takes seconds to compile.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tests {

/// A regular expression of ECMAScript's grammar.
class Pattern {
public:
    /// The whole match, then its groups; a group that took no part is empty.
    using Groups = std::vector<std::string>;

    explicit Pattern(const std::string& expression, bool anyCase = false);

    /// A match of the whole text.
    std::optional<Groups> match(const std::string& text) const;
    /// The first match within the text.
    std::optional<Groups> find(const std::string& text) const;
    std::vector<Groups> findAll(const std::string& text) const;
    /// Every match replaced; $1 in `with` is its first group.
    std::string replace(const std::string& text, const std::string& with) const;

private:
    struct Compiled;
    std::shared_ptr<const Compiled> compiled_;
};

}  // namespace tests
