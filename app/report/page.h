// A page of measurements: one HTML file that stands alone, with its style and its pictures in it,
// readable on a light and a dark screen and on paper. It refers to nothing outside itself and needs
// no script.
#pragma once

#include <string>
#include <vector>

namespace app::report {

/// `html` is what `section` made, with the same id; empty where there is nothing to show, which
/// leaves it out.
struct PageSection {
    std::string id, name;  // name: in the contents
    std::string html;
};

struct Page {
    std::string title, lead, facts;  // text: a heading, a sentence, where the numbers come from
    std::string warning;             // text, before all else; none when empty
    std::string style;               // CSS after the common style sheet
    std::vector<PageSection> sections;
    std::string foot;  // HTML
};

/// The whole file. A section whose id differs from that of its markup is a fault of the program.
std::string pageHtml(const Page& page);

/// A section with its heading; `content` is HTML.
std::string section(const std::string& id, const std::string& title, const std::string& content);

std::string paragraph(const std::string& html);

/// A figure in large digits with a few words of text below.
std::string tile(const std::string& figure, const std::string& words);

enum class Judgement { good, bad, open };

/// A verdict in a word or two, in the colour of its kind.
std::string verdictSpan(const std::string& word, Judgement judgement);

/// "Rekindle 1.2.0 (abcdef)".
std::string programText(const std::string& version, const std::string& commit);

/// What a reader must know of a measurement before all else: that it was interrupted, and `quick`
/// where that is not empty.
std::string warningText(bool interrupted, const std::string& quick);

/// A cell of a table, `text` to the right; red when `bad`.
std::string numberCell(const std::string& text, bool bad = false);
/// The head of a column of such cells; `html` may hold markup.
std::string numberHead(const std::string& html);

/// A table that scrolls sideways where the page is narrow: cells of the head, rows with their tr
/// elements.
std::string tableMarkup(const std::string& head, const std::string& rows);

/// Where the numbers of a table or plot are: a link to a file beside the page, which columns of it
/// or keys, and words on which rows.
std::string dataLine(const std::string& file, const std::vector<std::string>& columns,
                     const std::string& words = "");

}  // namespace app::report
