// What stands on the page, and the words that its sections share. See report.h.
#include "app/lab/report.h"

#include <algorithm>
#include <cmath>

#include "app/lab/functions.h"
#include "app/lab/lab_files.h"
#include "app/lab/pairs.h"
#include "app/lab/report_parts.h"

namespace app::lab {

namespace {

template <class Known> std::string labelled(const std::string& id, const Known* known)
{
    return known ? id + " " + known->name : id;
}

template <class Known> std::string inWords(const std::string& id, const Known* known)
{
    return known ? std::string(known->name) + " (" + id + ")" : id;
}

std::vector<std::string> distinct(const std::vector<Row>& rows, std::string Row::*member)
{
    std::vector<std::string> list;
    for (const Row& row : rows)
        if (std::find(list.begin(), list.end(), row.*member) == list.end())
            list.push_back(row.*member);
    return list;
}

}  // namespace

std::string functionLabel(const std::string& id)
{
    return labelled(id, findFunction(id));
}

std::string pairLabel(const std::string& id)
{
    return labelled(id, findPair(id));
}

std::string rowWords(const Row& row)
{
    return inWords(row.pair, findPair(row.pair)) + ", " +
           inWords(row.function, findFunction(row.function));
}

Map rowMap(const std::string& title, const CellTable& table,
           const std::function<MapCell(const Row&)>& cell)
{
    const std::vector<std::string> pairs = distinct(table.rows(), &Row::pair),
                                   functions = distinct(table.rows(), &Row::function);
    Map map;
    map.title = title;
    for (const std::string& pair : pairs) map.rows.push_back(pairLabel(pair));
    for (const std::string& id : functions) {
        const TestFunction* known = findFunction(id);
        map.columns.push_back({id, known ? known->name : ""});
    }
    map.cell = [pairs, functions, cell](size_t row, size_t column) {
        const Row place{pairs[row], functions[column]};
        MapCell box = cell(place);
        box.title = rowWords(place) + ": " + box.title;
        return box;
    };
    return map;
}

std::string mapFigure(const Map& map, const std::string& caption, const std::string& id)
{
    return std::string("<figure class=\"map\"") + (id.empty() ? "" : " id=\"" + id + "\"") + ">" +
           mapElement(map) + "<figcaption>" + caption + "</figcaption></figure>\n";
}

std::string duelId(const Column& a, const Column& b)
{
    const auto name = [](const Column& column) {
        return column.method +
               (column.beta == Beta::none ? "" : std::string("-") + betaName(column.beta));
    };
    return "duel-" + name(a) + "-" + name(b);
}

Column usualRa(Beta beta)
{
    return {"ra", beta, kUsualCandidates};
}

namespace {

// The colours of the methods.
constexpr const char* kMethodStyle = R"css(
.m-discard{--c:var(--grey)}.m-full,.m-other{--c:var(--soft)}.m-reweighting{--c:var(--orange)}
.m-rejection,.m-ris{--c:var(--pink)}.m-augmentation{--c:var(--yellow)}.m-rejaug{--c:var(--red)}
.m-ra{--c:var(--blue)}.m-thinned{--c:var(--sky)}.m-mis{--c:var(--green)}
.m-reweighting,.m-thinned,.m-augmentation{--onc:#101215}
)css";

constexpr const char* kPictureStyle = R"css(
.strip{display:grid;grid-template-columns:minmax(0,680px) minmax(210px,1fr);gap:4px 18px;
align-items:center;margin:7px 0}
.strip p{margin:0}.scene text{font-size:14px}
@media (max-width:800px){.strip{grid-template-columns:minmax(0,1fr)}}
@media print{.strip{break-inside:avoid}.pixels{print-color-adjust:exact}}
)css";

constexpr const char* kFoot =
    "<p>The same seed gives the same numbers on any number of threads.</p>";

std::string facts(const LabResults& r)
{
    std::string text = "Rekindle " + r.version;
    if (!r.commit.empty()) text += " (" + r.commit + ")";
    text += " · " + std::to_string(r.trials) + " trials per cell" + fewerTrials(r) + " · seed " +
            std::to_string(r.seed);
    if (std::isfinite(r.seconds)) text += " · " + shortNumber(r.seconds) + " s";
    return text;
}

}  // namespace

std::string filesSection()
{
    std::string rows = "<tr><td><a href=\"lab.json\">lab.json</a></td><td></td><td>everything, "
                       "with the settings of the run</td></tr>\n";
    for (const LabFile& file : labFiles())
        rows += std::string("<tr><td><a href=\"") + file.name + "\">" + file.name +
                "</a></td><td><code>" + file.key + "</code></td><td>" + escapeMarkup(file.meaning) +
                "</td></tr>\n";
    return section(
        "files", "Files",
        paragraph("The numbers behind this page lie beside it, each table a second time "
                  "in lab.json. What is infinite is the word <code>infinite</code>; "
                  "what is not known is empty, in JSON null.") +
            tableMarkup("<th>file</th><th>in lab.json</th><th>what it holds</th>", rows));
}

std::string reportHtml(const LabResults& r)
{
    Page page;
    page.title = "Sample reuse: the laboratory";
    page.lead = "What are random samples still worth when the density that they should have been "
                "drawn from has changed?";
    page.facts = facts(r);
    if (r.quick)
        page.warning =
            "A quick run: few trials, wide error bars. The counts below can change with more.";
    page.style = std::string(kMethodStyle) + kPictureStyle;
    page.sections = {{"picture", "At a glance", pictureSection(r)},
                     {"idea", "The idea", ideaSection()},
                     {"summary", "Summary", summarySection(r)},
                     {"winners", "Who wins", winnersSection(r)},
                     {"losses", "Where R-A loses", lossesSection(r)},
                     {"methods", "Methods", methodsSection()},
                     {"densities", "Densities", pairsSection()},
                     {"table", "All numbers", tableSection(r)},
                     {"checks", "Is it right?", checksSection(r)},
                     {"sweeps", "c and k", sweepsSection(r)},
                     {"majorisation", "Constants", majorisationSection(r)},
                     {"lobes", "A moving lobe", lobesSection(r)},
                     {"flatland", "Flatland", flatlandSection(r)},
                     {"traps", "Traps", trapsSection(r)},
                     {"files", "Files", filesSection()}};
    page.foot = kFoot;
    return pageHtml(page);
}

}  // namespace app::lab
