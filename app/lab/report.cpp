// The page: head, sections, foot; and the words that the sections share. See report.h.
#include "app/lab/report.h"

#include <algorithm>
#include <cmath>

#include "app/lab/report_parts.h"
#include "app/report/page_style.h"

namespace app::lab {

std::string section(const std::string& id, const std::string& title, const std::string& content)
{
    return "<section id=\"" + id + "\">\n<h2>" + escapeMarkup(title) + "</h2>\n" + content +
           "</section>\n";
}

std::string paragraph(const std::string& html)
{
    return "<p>" + html + "</p>\n";
}

std::string percent(double fraction, int digits)
{
    const std::string text = shortNumber(100 * fraction, digits);
    return std::isnan(fraction) ? text : text + " %";
}

std::string measured(double value, double error)
{
    if (!std::isfinite(value) || !(error > 0) || !std::isfinite(error) || value == 0)
        return shortNumber(value);
    const auto exponent = [](double x) { return std::floor(std::log10(std::abs(x))); };
    const double digits = std::clamp(1 + exponent(value) - exponent(error), 1.0, 8.0);
    return shortNumber(value, static_cast<int>(digits)) + " ± " + shortNumber(error, 1);
}

std::string counted(size_t count, const std::string& noun)
{
    return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

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

struct Part {
    const char* id;
    const char* name;
};
constexpr Part kParts[] = {{"summary", "Summary"},     {"idea", "The idea"},
                           {"winners", "Who wins"},    {"losses", "Where R-A loses"},
                           {"methods", "Methods"},     {"densities", "Densities"},
                           {"table", "All numbers"},   {"checks", "Is it right?"},
                           {"sweeps", "c and k"},      {"majorisation", "Constants"},
                           {"lobes", "A moving lobe"}, {"flatland", "Flatland"},
                           {"traps", "Traps"}};

std::string facts(const LabResults& r)
{
    std::string text = "Rekindle " + r.version;
    if (!r.commit.empty()) text += " (" + r.commit + ")";
    text += " · " + std::to_string(r.trials) + " trials per cell · seed " + std::to_string(r.seed);
    if (std::isfinite(r.seconds)) text += " · " + shortNumber(r.seconds) + " s";
    return "<p class=\"facts\">" + escapeMarkup(text) + "</p>\n";
}

/// Links to the sections that there are.
std::string contents(const std::string& body)
{
    std::string links;
    for (const Part& part : kParts)
        if (body.find("<section id=\"" + std::string(part.id) + "\"") != std::string::npos)
            links += "<a href=\"#" + std::string(part.id) + "\">" + part.name + "</a>\n";
    return "<nav aria-label=\"Contents\">" + links + "</nav>\n";
}

std::string footer()
{
    return "<footer><p>The numbers behind this page: <code>lab.json</code> holds everything; "
           "<code>cells.csv</code>, <code>sweeps.csv</code>, <code>majorisation.csv</code>, "
           "<code>lobes.csv</code>, <code>stores.csv</code>, <code>flatland.csv</code> and "
           "<code>traps.csv</code> hold the "
           "same as tables. The same seed gives the same numbers on any number of "
           "threads.</p></footer>\n";
}

}  // namespace

std::string reportHtml(const LabResults& r)
{
    const std::string body =
        summarySection(r) + ideaSection() + winnersSection(r) + lossesSection(r) +
        methodsSection() + pairsSection() + tableSection(r) + checksSection(r) + sweepsSection(r) +
        majorisationSection(r) + lobesSection(r) + flatlandSection(r) + trapsSection(r);
    std::string page = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta "
                       "charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width, "
                       "initial-scale=1\">\n<meta name=\"color-scheme\" content=\"light "
                       "dark\">\n<title>Sample reuse: the laboratory</title>\n<style>";
    page += kReportStyle;
    page += "</style>\n</head>\n<body>\n<header>\n<h1>Sample reuse: the laboratory</h1>\n<p "
            "class=\"lead\">What are random samples still worth when the density that they should "
            "have been drawn from has changed?</p>\n" +
            facts(r);
    if (r.quick)
        page += "<p class=\"warn\">A quick run: few trials, wide error bars. The counts below can "
                "change with more.</p>\n";
    page += contents(body) + "</header>\n<main>\n" + body + "</main>\n" + footer() +
            "</body>\n</html>\n";
    return page;
}

}  // namespace app::lab
