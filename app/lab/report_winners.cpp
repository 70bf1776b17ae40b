// Who wins where: maps of changes of density against functions, and of methods against both. See
// report_parts.h.
#include <algorithm>
#include <cmath>
#include <set>

#include "app/lab/report_parts.h"

namespace app::lab {

namespace {

std::string boxLabel(const Column& column)
{
    std::string label = column.label();
    label = label.substr(0, label.find(','));
    if (label == "Reweighting") return "Rew.";
    if (label == "R-A thinned") return "thinned";
    if (label == "Rejection") return "Reject";
    if (label == "Augmentation") return "Augment";
    if (label == "RIS of old") return "RIS";
    return label;
}

Map winnerMap(const std::string& title, const CellTable& table, const std::vector<Beta>& betas,
              std::set<std::string>& seen)
{
    return rowMap(title, table, [&table, betas, &seen](const Row& row) {
        const std::vector<Column> best = winners(table, row, betas);
        if (best.empty()) return MapCell{"–", "none", "", "nobody"};
        MapCell box{"tie", "none", "", ""};
        bool oneMethod = true;
        for (const Column& column : best) {
            box.title += (box.title.empty() ? "" : ", ") + column.label();
            oneMethod = oneMethod && column.method == best.front().method;
        }
        box.title += ", N·Var " + shortNumber(decidingVariance(*table.find(row, best.front())));
        if (oneMethod) {
            seen.insert(best.front().method);
            box.text = best.size() == 1 ? boxLabel(best.front())
                                        : boxLabel({best.front().method, Beta::none, 0});
            box.style = "fill " + best.front().style();
            box.textStyle = "on " + best.front().style();
        }
        return box;
    });
}

/// Against nothing at all every loss is infinite.
std::string ratioText(double ratio)
{
    if (ratio == 1) return "=";
    if (ratio > 0 && ratio < 0.01) return ratio < 1e-4 ? "0" : shortNumber(ratio, 1);
    return ratio > 1e4 ? "∞" : shortNumber(ratio, 2);
}

Map duelMap(const std::string& title, const CellTable& table, const Column& a, const Column& b)
{
    return rowMap(title, table, [&table, a, b](const Row& row) {
        const Cell *first = table.find(row, a), *second = table.find(row, b);
        if (!first || !second) return MapCell{"–", "none", "", "no comparison"};
        const double ratio = varianceRatio(*first, *second);
        return MapCell{ratioText(ratio), ratioStyle(ratio), "",
                       a.label() + " " + shortNumber(decidingVariance(*first)) + ", " + b.label() +
                           " " + shortNumber(decidingVariance(*second))};
    });
}

std::string legendOf(const std::set<std::string>& methods)
{
    std::string html;
    for (const std::string& id : methods) {
        const Column column{id};
        html += "<span class=\"" + column.style() + "\"><span class=\"swatch\"></span>" +
                escapeMarkup(boxLabel(column)) +
                (boxLabel(column) == column.name() ? "" : ": " + escapeMarkup(column.name())) +
                "</span>\n";
    }
    return "<p class=\"small legend\">" + html +
           "<span>the number after R-A: its k</span><span><b>tie</b>: several methods are equally "
           "good</span></p>\n";
}

/// One row of a map of methods: all that have no correction but Discard, with which they are
/// compared, and the best correction of the two that everything is about.
std::vector<Column> comparedColumns(const CellTable& table)
{
    std::vector<Column> columns;
    for (const Column& column : table.columns()) {
        const bool corrected = column.beta == Beta::ideal &&
                               (column == usualRa(Beta::ideal) || column.method == "mis");
        if ((column.beta == Beta::none && column.method != "discard") || corrected)
            columns.push_back(column);
    }
    return columns;
}

/// Methods downwards, across the values of one member of the rows; medians over the other.
Map methodMap(const std::string& title, const CellTable& table, std::string Row::*member)
{
    std::vector<std::string> ids;
    for (const Row& row : table.rows())
        if (std::find(ids.begin(), ids.end(), row.*member) == ids.end()) ids.push_back(row.*member);
    const std::vector<Column> columns = comparedColumns(table);
    Map map;
    map.title = title;
    map.cellWidth = 40;
    map.slanted = true;
    for (const Column& column : columns) map.rows.push_back(column.label());
    for (const std::string& id : ids)
        map.columns.push_back({member == &Row::pair ? pairLabel(id) : functionLabel(id), ""});
    map.cell = [&table, columns, ids, member, labels = map.columns](size_t row, size_t column) {
        std::vector<Row> rows;
        for (const Row& r : table.rows())
            if (r.*member == ids[column]) rows.push_back(r);
        const Worth worth = worthOf(table, columns[row], rows);
        const std::string place = columns[row].label() + ", " + labels[column].code + ": ";
        if (worth.rows == 0) return MapCell{"–", "none", "", place + "not defined, or biased"};
        const std::string text = ratioText(worth.median);
        return MapCell{worth.withinBudget ? text : "(" + text + ")",
                       worth.withinBudget ? ratioStyle(worth.median) : "none", "",
                       place + "median of " + std::to_string(worth.rows) + ", " +
                           shortNumber(worth.median) +
                           (worth.withinBudget ? "" : "; at more than n rays")};
    };
    return map;
}

std::string methodMaps(const CellTable& table)
{
    return "<h3>Which method for which change?</h3>\n" +
           paragraph("Variance relative to that of Discard, the median over what is not shown: 0.5 "
                     "means that half the rays give the same grain as starting anew (blue), 2 that "
                     "twice as many are needed (orange). In brackets: at more than n new rays. –: "
                     "not defined there, or biased.") +
           "<div class=\"pairoffigures\">\n" +
           mapFigure(methodMap("Methods by change of density", table, &Row::pair),
                     "Median over the functions. Read along a row: where a method pays; down a "
                     "column: what to take after such a change.") +
           mapFigure(methodMap("Methods by function", table, &Row::function),
                     "Median over the changes of density. Down a column: what to take for such an "
                     "integrand.") +
           "</div>\n" +
           dataLine("cells.csv",
                    {"pair", "f", "method", "beta", "k", "expected_n_var", "n_var", "rays"},
                    "rows with n = N, or n = 0");
}

std::string duelMaps(const CellTable& table)
{
    std::string html = "<div class=\"pairoffigures\">\n";
    for (const Beta beta : {Beta::none, Beta::ideal}) {
        const Column ra = usualRa(beta);
        if (!table.has(ra)) continue;
        const std::string with = beta == Beta::none ? "plain" : "ideal β";
        html +=
            mapFigure(duelMap("R-A against Discard, " + with, table, ra, {"discard"}),
                      "Blue: reuse pays. Orange: starting anew is better.") +
            mapFigure(duelMap("R-A against MIS, " + with + (beta == Beta::none ? "" : " on both"),
                              table, ra, {"mis", beta}),
                      "Blue: steering the new samples pays. Orange: the plain balance "
                      "heuristic is better.");
    }
    return html + "</div>\n" +
           dataLine("cells.csv", {"pair", "f", "method", "beta", "k", "expected_n_var", "n_var"},
                    "rows with n = N");
}

}  // namespace

std::string winnersSection(const LabResults& results)
{
    if (results.cells.empty()) return {};
    const CellTable table(results, 1);
    std::set<std::string> seen;
    std::string maps =
        "<div class=\"pairoffigures\">\n" +
        mapFigure(winnerMap("Lowest variance, nothing corrected", table, {Beta::none}, seen),
                  "The best method as it stands, for every change and function.");
    const bool corrected = std::any_of(table.columns().begin(), table.columns().end(),
                                       [](const Column& c) { return c.beta == Beta::ideal; });
    if (corrected)
        maps += mapFigure(winnerMap("Lowest variance, corrections allowed (ideal β)", table,
                                    {Beta::none, Beta::ideal}, seen),
                          "The same when the noise of the weights is taken out.");
    std::string html =
        paragraph("Rows are changes of density, columns are functions; both are drawn "
                  "<a href=\"#densities\">below</a>. Only unbiased methods take part, and only "
                  "where they spend at most as many new rays as there are old samples (n = N). The "
                  "predicted variance decides. Rest the pointer on a cell for its numbers.");
    html += maps + "</div>\n" + legendOf(seen) +
            dataLine("cells.csv",
                     {"pair", "f", "method", "beta", "k", "expected_n_var", "n_var", "rays"},
                     "rows with n = N, or n = 0") +
            methodMaps(table) + "<h3>How much does it matter?</h3>\n";
    html += paragraph("The maps show the variance of R-A (k = 4) divided by that of its rival: 0.5 "
                      "means that R-A needs half the rays (blue), 2 that it needs twice as many "
                      "(orange), = that both are the same, 0 that the rival has infinite variance "
                      "and ∞ that it has none.");
    return section("winners", "Who wins", html + duelMaps(table));
}

}  // namespace app::lab
