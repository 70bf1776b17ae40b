// A strict reader of HTML, for tests of pages that the program writes.
#pragma once

#include <algorithm>
#include <regex>
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
inline Markup readMarkup(const std::string& html)
{
    Markup m;
    const std::set<std::string> empty{"meta", "br"};
    std::vector<std::string> open;
    const std::regex tag(
        R"(^<(/?)([a-zA-Z][a-zA-Z0-9]*)((?:\s+[a-zA-Z0-9:-]+="[^"<]*")*)\s*(/?)>)");
    const std::regex attribute(R"(([a-zA-Z0-9:-]+)="([^"]*)\")");
    const std::regex entity(R"(^&(amp|lt|gt|quot|#[0-9]+);)");
    size_t i = html.find('\n') + 1;  // behind the doctype
    while (i < html.size()) {
        const size_t length = std::min<size_t>(html.size() - i, 20000);
        const char* from = html.data() + i;
        std::cmatch match;
        if (html[i] == '&' && !std::regex_search(from, from + std::min<size_t>(length, 12), entity))
            m.problem = "stray & at " + html.substr(i, 40);
        if (html[i] != '<') {
            ++i;
            continue;
        }
        const size_t close = html.find('>', i);
        if (close == std::string::npos ||
            !std::regex_match(from, html.data() + close + 1, match, tag)) {
            m.problem = "no tag: " + html.substr(i, 80);
            return m;
        }
        i = close + 1;
        const std::string name = match[2], attributes = match[3];
        m.names.insert(name);
        if (match[1].length()) {
            if (open.empty() || open.back() != name) {
                m.problem = "</" + name + "> closes " + (open.empty() ? "nothing" : open.back()) +
                            " before " + html.substr(i, 80);
                return m;
            }
            open.pop_back();
            continue;
        }
        for (auto a = std::sregex_iterator(attributes.begin(), attributes.end(), attribute);
             a != std::sregex_iterator(); ++a) {
            const std::string key = (*a)[1], value = (*a)[2];
            if (key == "id" && !m.ids.insert(value).second) m.problem = "id twice: " + value;
            if (key == "href" || key == "src") m.references.push_back(value);
            if (key.rfind("on", 0) == 0) m.problem = "a script: " + key;
        }
        if (match[4].length() == 0 && !empty.count(name)) open.push_back(name);
        // The style sheet is text in another language.
        if (name == "style") i = html.find("</style>", i);
    }
    if (!open.empty()) m.problem = "never closed: " + open.back();
    return m;
}

}  // namespace tests
