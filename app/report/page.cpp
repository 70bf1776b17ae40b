// The page's head, contents, sections and foot, and the small pieces of markup. See page.h.
#include "app/report/page.h"

#include "app/report/page_style.h"
#include "app/report/text.h"
#include "core/base/check.h"

namespace app::report {

namespace {

std::string sectionHead(const std::string& id)
{
    return "<section id=\"" + id + "\">";
}

/// Links to the sections that there are.
std::string contents(const std::vector<PageSection>& sections)
{
    std::string links;
    for (const PageSection& s : sections) {
        if (s.html.empty()) continue;
        CHECK(s.html.starts_with(sectionHead(s.id)));
        links += "<a href=\"#" + s.id + "\">" + s.name + "</a>\n";
    }
    return "<nav aria-label=\"Contents\">" + links + "</nav>\n";
}

}  // namespace

std::string pageHtml(const Page& page)
{
    const std::string title = escapeMarkup(page.title);
    std::string html = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
                       "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
                       "<meta name=\"color-scheme\" content=\"light dark\">\n<title>" +
                       title + "</title>\n<style>" + kPageStyle + page.style +
                       "</style>\n</head>\n<body>\n<header>\n<h1>" + title +
                       "</h1>\n<p class=\"lead\">" + escapeMarkup(page.lead) +
                       "</p>\n<p class=\"facts\">" + escapeMarkup(page.facts) + "</p>\n";
    if (!page.warning.empty()) html += "<p class=\"warn\">" + escapeMarkup(page.warning) + "</p>\n";
    html += contents(page.sections) + "</header>\n<main>\n";
    for (const PageSection& s : page.sections) html += s.html;
    return html + "</main>\n<footer>" + page.foot + "</footer>\n</body>\n</html>\n";
}

std::string section(const std::string& id, const std::string& title, const std::string& content)
{
    return sectionHead(id) + "\n<h2>" + escapeMarkup(title) + "</h2>\n" + content + "</section>\n";
}

std::string paragraph(const std::string& html)
{
    return "<p>" + html + "</p>\n";
}

std::string tile(const std::string& figure, const std::string& words)
{
    return "<div class=\"tile\"><b>" + escapeMarkup(figure) + "</b>" + escapeMarkup(words) +
           "</div>\n";
}

std::string verdictSpan(const std::string& word, Judgement judgement)
{
    constexpr const char* kStyles[] = {"good", "bad", "open"};
    return std::string("<span class=\"") + kStyles[static_cast<size_t>(judgement)] + "\">" +
           escapeMarkup(word) + "</span>";
}

std::string programText(const std::string& version, const std::string& commit)
{
    return "Rekindle " + version + (commit.empty() ? "" : " (" + commit + ")");
}

std::string warningText(bool interrupted, const std::string& quick)
{
    const std::string first = interrupted ? "Interrupted: what was measured until then." : "";
    return first + (first.empty() || quick.empty() ? "" : " ") + quick;
}

std::string numberCell(const std::string& text, bool bad)
{
    return std::string("<td class=\"n") + (bad ? " bad" : "") + "\">" + escapeMarkup(text) +
           "</td>";
}

std::string numberHead(const std::string& html)
{
    return "<th class=\"n\">" + html + "</th>";
}

std::string tableMarkup(const std::string& head, const std::string& rows)
{
    return "<div class=\"scroll\"><table><thead><tr>" + head + "</tr></thead><tbody>\n" + rows +
           "</tbody></table></div>\n";
}

std::string dataLine(const std::string& file, const std::vector<std::string>& columns,
                     const std::string& words)
{
    std::string html = "<p class=\"data\">Data: <a href=\"" + escapeMarkup(file) + "\">" +
                       escapeMarkup(file) + "</a>";
    for (size_t i = 0; i < columns.size(); ++i)
        html += (i ? ", <code>" : ": <code>") + escapeMarkup(columns[i]) + "</code>";
    return html + (words.empty() ? "" : "; " + escapeMarkup(words)) + "</p>\n";
}

}  // namespace app::report
