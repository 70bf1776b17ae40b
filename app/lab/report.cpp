// What stands on the page, and the words that its sections share. See report.h.
#include "app/lab/report.h"

#include <cmath>

#include "app/lab/report_parts.h"

namespace app::lab {

std::string rowList(const std::vector<Row>& rows)
{
    std::string text;
    for (size_t i = 0; i < rows.size(); ++i) {
        if (i > 0 && rows[i].pair == rows[i - 1].pair)
            text += ", " + rows[i].function;
        else
            text += (i ? "; " : "") + rows[i].pair + ": " + rows[i].function;
    }
    return rows.empty() ? "none" : escapeMarkup(text);
}

Column usualRa(Beta beta)
{
    return {"ra", beta, kUsualCandidates};
}

double decidingVariance(const Cell& cell)
{
    return std::isnan(cell.expectedVariance) ? cell.variance : cell.expectedVariance;
}

namespace {

// The colours of the methods.
constexpr const char* kMethodStyle = R"css(
.m-discard{--c:var(--grey)}.m-full,.m-other{--c:var(--soft)}.m-reweighting{--c:var(--orange)}
.m-rejection,.m-ris{--c:var(--pink)}.m-augmentation{--c:var(--yellow)}.m-rejaug{--c:var(--red)}
.m-ra{--c:var(--blue)}.m-thinned{--c:var(--sky)}.m-mis{--c:var(--green)}
.m-reweighting,.m-thinned,.m-augmentation{--onc:#101215}
)css";

constexpr const char* kFoot = "<p>The numbers behind this page: <code>lab.json</code> holds "
                              "everything; <code>cells.csv</code>, "
                              "<code>sweeps.csv</code>, <code>majorisation.csv</code>, "
                              "<code>lobes.csv</code>, <code>stores.csv</code>, "
                              "<code>flatland.csv</code> and <code>traps.csv</code> hold the same "
                              "as tables. The same seed gives the same numbers "
                              "on any number of threads.</p>";

std::string facts(const LabResults& r)
{
    std::string text = "Rekindle " + r.version;
    if (!r.commit.empty()) text += " (" + r.commit + ")";
    text += " · " + std::to_string(r.trials) + " trials per cell · seed " + std::to_string(r.seed);
    if (std::isfinite(r.seconds)) text += " · " + shortNumber(r.seconds) + " s";
    return text;
}

}  // namespace

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
    page.style = kMethodStyle;
    page.sections = {{"summary", "Summary", summarySection(r)},
                     {"idea", "The idea", ideaSection()},
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
                     {"traps", "Traps", trapsSection(r)}};
    page.foot = kFoot;
    return pageHtml(page);
}

}  // namespace app::lab
