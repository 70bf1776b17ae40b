// See pattern.h.
#include "tests/support/files/pattern.h"

#include <regex>

namespace tests {

struct Pattern::Compiled {
    std::regex regex;
};

static Pattern::Groups groupsOf(const std::smatch& match)
{
    return {match.begin(), match.end()};
}

Pattern::Pattern(const std::string& expression, bool anyCase)
    : compiled_(std::make_shared<Compiled>(
          Compiled{std::regex(expression, anyCase ? std::regex::ECMAScript | std::regex::icase
                                                  : std::regex::ECMAScript)}))
{}

std::optional<Pattern::Groups> Pattern::match(const std::string& text) const
{
    std::smatch match;
    if (!std::regex_match(text, match, compiled_->regex)) return {};
    return groupsOf(match);
}

std::optional<Pattern::Groups> Pattern::find(const std::string& text) const
{
    std::smatch match;
    if (!std::regex_search(text, match, compiled_->regex)) return {};
    return groupsOf(match);
}

std::vector<Pattern::Groups> Pattern::findAll(const std::string& text) const
{
    std::vector<Groups> all;
    for (std::sregex_iterator i(text.begin(), text.end(), compiled_->regex), end; i != end; ++i)
        all.push_back(groupsOf(*i));
    return all;
}

std::string Pattern::replace(const std::string& text, const std::string& with) const
{
    return std::regex_replace(text, compiled_->regex, with);
}

}  // namespace tests
