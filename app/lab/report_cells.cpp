// The table of all cells, and the plots that compare them with their expectation. See
// report_parts.h.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/base/read_value.h"
#include "app/lab/methods.h"
#include "app/lab/pairs.h"
#include "app/lab/report_parts.h"

namespace app::lab {

namespace {

std::string cellTitle(const Column& column, const Cell& c)
{
    std::string text =
        rowWords({c.pair, c.function}) + "; " + column.label() + ": N·Var " +
        shortNumber(c.variance, 4) + " ± " + shortNumber(c.varianceError, 2) + ", expected " +
        (std::isnan(c.expectedVariance) ? "not known" : shortNumber(c.expectedVariance, 4)) +
        "; mean " + shortNumber(c.mean, 5) + " for " + shortNumber(c.truth, 5) +
        ", z = " + shortNumber(c.z(), 2) + "; rays " + shortNumber(c.rays) +
        ", pairs of densities " + shortNumber(c.densities) + ", ESS " + shortNumber(c.ess);
    if (!std::isnan(c.c)) text += ", c = " + shortNumber(c.c, 4);
    return escapeMarkup(text);
}

/// Within a tenth of the best of the row.
bool isNear(const CellTable& table, const Cell& cell, const Cell& best)
{
    return !isBiased(cell) && !isInfinite(cell) && !table.exceedsBudget(cell) &&
           decidingVariance(cell) <= 1.1 * decidingVariance(best) + 1e-12 * cell.truth * cell.truth;
}

std::string cellHtml(const CellTable& table, const Row& row, const Column& column,
                     const std::vector<Column>& best)
{
    const Cell* cell = table.find(row, column);
    if (!cell) return "<td class=\"none\" title=\"not defined here\">·</td>";
    std::string style;
    if (isBiased(*cell))
        style = "biased";
    else if (isInfinite(*cell))
        style = "none";
    else if (std::find(best.begin(), best.end(), column) != best.end())
        style = "win " + column.style();
    else if (!best.empty() && isNear(table, *cell, *table.find(row, best.front())))
        style = "near " + column.style();
    // A bias of the expectation is a warning; one of order 1/N is in the head of the column.
    const bool misses = isBiased(*cell) && std::abs(cell->z()) > kMeanBound;
    // What is left where rounding is the only noise.
    const bool nothing = cell->variance <= 1e-20 * cell->truth * cell->truth;
    const std::string number = nothing ? "0" : shortNumber(cell->variance);
    const std::string text = isInfinite(*cell) ? "∞" : number + (misses ? "†" : "");
    return "<td class=\"" + style + "\" title=\"" + cellTitle(column, *cell) + "\">" + text +
           "</td>";
}

std::string pairHead(const std::string& id, size_t columns)
{
    std::string words = pairLabel(id);
    if (const Pair* pair = findPair(id))
        words += ": " + std::string(pair->meaning) + ", " + pair->formula;
    return "<tr class=\"pair\"><th colspan=\"" + std::to_string(columns + 1) + "\">" +
           escapeMarkup(words) + "</th></tr>\n";
}

/// Columns in which nothing was corrected; or those that were, beside Discard to compare with.
std::vector<Column> columnsOf(const CellTable& table, bool corrected)
{
    std::vector<Column> chosen;
    for (const Column& column : table.columns()) {
        const bool plain = column.beta == Beta::none || column.method == "reweighting-normalised";
        if (plain != corrected || (corrected && column == Column{"discard"}))
            chosen.push_back(column);
    }
    return chosen;
}

std::string bigTable(const CellTable& table, bool corrected)
{
    const std::vector<Column> columns = columnsOf(table, corrected);
    std::string html = "<div class=\"scroll tall\"><table class=\"big\"><thead><tr><th>f</th>";
    for (const Column& column : columns)
        html += "<th title=\"" + escapeMarkup(column.name()) + "\"><span>" +
                escapeMarkup(column.label()) + "</span></th>";
    html += "</tr></thead>\n";
    std::string pair;
    for (const Row& row : table.rows()) {
        if (row.pair != pair) {
            html += (pair.empty() ? "<tbody>\n" : "</tbody>\n<tbody>\n") +
                    pairHead(row.pair, columns.size());
            pair = row.pair;
        }
        const std::vector<Column> best =
            winners(table, row, {corrected ? Beta::ideal : Beta::none});
        html += "<tr><th>" + escapeMarkup(functionLabel(row.function)) + "</th>";
        for (const Column& column : columns) html += cellHtml(table, row, column, best);
        html += "</tr>\n";
    }
    if (!pair.empty()) html += "</tbody>\n";
    return html + "</table></div>\n";
}

/// Measured against predicted variance, in standard errors, over the size of the variance.
std::string deviationPlot(const LabResults& results)
{
    std::vector<Point> points[3];
    double low = kInfinite, high = 0, farthest = kVarianceBound + 0.5;
    for (const Cell& cell : results.cells) {
        const double deviation = varianceDeviation(cell);
        if (!std::isfinite(deviation) || !(cell.expectedVariance > 1e-9)) continue;
        const size_t group = cell.method.starts_with("ra") ? 0 : cell.method == "mis" ? 1 : 2;
        points[group].push_back({cell.expectedVariance, deviation});
        low = std::min(low, cell.expectedVariance);
        high = std::max(high, cell.expectedVariance);
        farthest = std::max(farthest, std::abs(deviation));
    }
    Plot plot("Measured minus predicted N·Var, in standard errors",
              logAxis("predicted N·Var", low, high),
              linearAxis("standard errors", -farthest, farthest, 6), 500, 290);
    plot.horizontal(kVarianceBound, "bound", "c-red dashed");
    plot.horizontal(-kVarianceBound, "", "c-red dashed");
    constexpr const char* kNames[] = {"R-A", "MIS", "others"};
    constexpr const char* kStyles[] = {"m-ra", "m-mis", "c-grey"};
    constexpr Shape kShapes[] = {Shape::circle, Shape::diamond, Shape::square};
    for (const size_t i : {2u, 1u, 0u}) {
        plot.markers(points[i], kShapes[i], std::string("faint ") + kStyles[i]);
        plot.legend({kNames[i], kStyles[i], false, true, false, kShapes[i]});
    }
    return plot.element();
}

/// Histogram of z of the means under the normal curve that it should follow.
std::string scorePlot(const LabResults& results)
{
    constexpr double kStep = 0.5, kReach = 5;
    std::vector<Point> bars;
    for (double z = -kReach + kStep / 2; z < kReach; z += kStep) bars.push_back({z, 0});
    double count = 0;
    for (const Cell& cell : results.cells) {
        // Where nothing varies z is 0 by definition, and carries no information about chance.
        if (isBiased(cell) || isInfinite(cell) || cell.z() == 0) continue;
        const double bin =
            std::clamp((cell.z() + kReach) / kStep, 0.0, static_cast<double>(bars.size()) - 1);
        if (std::isnan(bin)) continue;
        ++bars[static_cast<size_t>(bin)].y;
        ++count;
    }
    std::vector<Point> normal;
    double highest = 1;
    for (double z = -kReach; z <= kReach; z += 0.1)
        normal.push_back(
            {z, count * kStep * std::exp(-z * z / 2) / std::sqrt(2 * std::numbers::pi)});
    for (const Point& p : bars) highest = std::max(highest, p.y);
    for (const Point& p : normal) highest = std::max(highest, p.y);
    Plot plot("Means: z of unbiased cells",
              linearAxis("z, standard errors from the truth", -5, 5, 10),
              linearAxis("cells", 0, highest, 4), 500, 290);
    plot.bars(bars, kStep, 0, "c-blue");
    plot.curve(normal, "ink");
    plot.legend({"measured", "c-blue", false, false, true});
    plot.legend({"normal distribution", "ink"});
    return plot.element();
}

}  // namespace

std::string tableSection(const LabResults& results)
{
    std::string html;
    for (const double ratio : ratios(results)) {
        const CellTable table(results, ratio);
        const std::string n = "n = " + (ratio == 1 ? "" : numberText(ratio) + " ") + "N";
        // The tables at n = N are open; the others are folded.
        for (const bool corrected : {false, true}) {
            if (corrected && columnsOf(table, true).size() < 2) continue;
            const std::string title =
                corrected ? "With the correction β, " + n : "As they are, " + n;
            const std::string content = bigTable(table, corrected);
            html += ratio == 1
                        ? "<h3>" + title + "</h3>\n" + content
                        : "<details><summary>" + title + "</summary>\n" + content + "</details>\n";
        }
    }
    if (html.empty()) return {};
    return section(
        "table", "All numbers",
        paragraph("Measured N·Var; smaller is better. <b>Filled</b>: the best unbiased method of "
                  "the row with at most n new rays, by the predicted variance. <b>Underlined</b>: "
                  "within a tenth of it. <b>∞</b>: the variance is provably infinite, so that a "
                  "measured one would mean nothing. <b><i>Italic</i></b>: biased; <b>†</b> where "
                  "the bias shows. <b>·</b>: not defined, or not run. Rest the pointer on a number "
                  "for its error, prediction, mean, z, rays and ESS.") +
            html +
            dataLine("cells.csv", {"pair", "f", "method", "beta", "k", "n", "n_var", "n_var_se",
                                   "expected_n_var", "mean", "z", "rays", "ess"}));
}

std::string checksSection(const LabResults& results)
{
    if (results.cells.empty()) return {};
    std::string html = paragraph(
        "Each cell was predicted before it was measured: the mean from the integral, the variance "
        "by quadrature of its formula. In a laboratory that is right, both differ from the "
        "measurement by chance alone: deviations of ±1 are ordinary, ±3 rare, and beyond the "
        "dashed lines there should be nothing. Each dot has, in these units, an error bar of ±1. "
        "All methods and functions of a change of density are given the same old samples, which "
        "sharpens their comparison: their cells deviate together, and the histogram is less even "
        "than that of so many independent ones would be.");
    html += "<div class=\"pairoffigures\">\n<figure>" + deviationPlot(results) +
            "</figure>\n<figure>" + scorePlot(results) + "</figure>\n</div>\n" +
            dataLine("cells.csv", {"n_var", "n_var_se", "expected_n_var", "z"});
    return section("checks", "Is it right?", html);
}

}  // namespace app::lab
