// See markup.h.
#include "tests/support/files/markup.h"

#include "tests/support/files/pattern.h"

namespace tests {

Markup readMarkup(const std::string& html)
{
    Markup m;
    const std::set<std::string> empty{"br", "img", "meta"};
    std::vector<std::string> open;
    const Pattern tag(R"(^<(/?)([a-zA-Z][a-zA-Z0-9]*)((?:\s+[a-zA-Z0-9:-]+="[^"<]*")*)\s*(/?)>)");
    const Pattern attribute(R"(([a-zA-Z0-9:-]+)="([^"]*)\")");
    const Pattern entity(R"(^&(amp|lt|gt|quot|#[0-9]+);)");
    size_t i = html.find('\n') + 1;  // behind the doctype
    while (i < html.size()) {
        if (html[i] == '&' && !entity.find(html.substr(i, 12)))
            m.problem = "stray & at " + html.substr(i, 40);
        if (html[i] != '<') {
            ++i;
            continue;
        }
        const size_t close = html.find('>', i);
        const auto match =
            close == std::string::npos ? std::nullopt : tag.match(html.substr(i, close + 1 - i));
        if (!match) {
            m.problem = "no tag: " + html.substr(i, 80);
            return m;
        }
        i = close + 1;
        const std::string &closing = match->at(1), &name = match->at(2), &attributes = match->at(3);
        m.names.insert(name);
        if (!closing.empty()) {
            if (open.empty() || open.back() != name) {
                m.problem = "</" + name + "> closes " + (open.empty() ? "nothing" : open.back()) +
                            " before " + html.substr(i, 80);
                return m;
            }
            open.pop_back();
            continue;
        }
        for (const Pattern::Groups& found : attribute.findAll(attributes)) {
            const std::string &key = found[1], &value = found[2];
            if (key == "id" && !m.ids.insert(value).second) m.problem = "id twice: " + value;
            if (key == "href" || key == "src") m.references.push_back(value);
            if (key.rfind("on", 0) == 0) m.problem = "a script: " + key;
        }
        if (match->at(4).empty() && !empty.count(name)) open.push_back(name);
        // The style sheet is text in another language.
        if (name == "style") i = html.find("</style>", i);
    }
    if (!open.empty()) m.problem = "never closed: " + open.back();
    return m;
}

std::string withoutPictures(std::string html)
{
    size_t at = 0;
    while ((at = html.find("\"data:", at)) != std::string::npos) {
        ++at;
        html.erase(at, html.find('"', at) - at);
    }
    return html;
}

}  // namespace tests
