// Who wins where, as maps of pairs against functions, and whom R-A beats. See report_parts.h.
#include <algorithm>
#include <cmath>
#include <set>

#include "app/lab/report_parts.h"

namespace app::lab {

namespace {

constexpr double kBoxWidth = 57, kBoxHeight = 21;

/// The rows and columns of a map, in the order in which the cells came.
struct Grid {
    std::vector<std::string> pairs, functions;
};

Grid gridOf(const CellTable& table)
{
    Grid grid;
    const auto add = [](std::vector<std::string>& list, const std::string& name) {
        if (std::find(list.begin(), list.end(), name) == list.end()) list.push_back(name);
    };
    for (const Row& row : table.rows()) {
        add(grid.pairs, row.pair);
        add(grid.functions, row.function);
    }
    return grid;
}

struct Box {
    std::string text, style, textStyle, title;
};

/// Pairs downwards, functions across; `box` tells what stands where.
template <class BoxOf>
std::string heatMap(const std::string& title, const CellTable& table, BoxOf box)
{
    const Grid grid = gridOf(table);
    Drawing drawing;
    constexpr double kLeft = 26, kTop = 40;
    drawing.text({0, 13}, title, "heading");
    for (size_t f = 0; f < grid.functions.size(); ++f)
        drawing.text({kLeft + kBoxWidth * (static_cast<double>(f) + 0.5), kTop - 7},
                     grid.functions[f], "label", Anchor::middle);
    for (size_t p = 0; p < grid.pairs.size(); ++p) {
        const double y = kTop + kBoxHeight * static_cast<double>(p);
        drawing.text({kLeft - 6, y + 14.5}, grid.pairs[p], "label", Anchor::end);
        for (size_t f = 0; f < grid.functions.size(); ++f) {
            const double x = kLeft + kBoxWidth * static_cast<double>(f);
            const Box b = box(Row{grid.pairs[p], grid.functions[f]});
            drawing.add("<g><title>" + escapeMarkup(b.title) + "</title>");
            drawing.rectangle({x, y}, kBoxWidth, kBoxHeight, "heat " + b.style);
            drawing.text({x + kBoxWidth / 2, y + 14.5}, b.text, "heattext " + b.textStyle,
                         Anchor::middle);
            drawing.add("</g>");
        }
    }
    return drawing.element(kLeft + kBoxWidth * static_cast<double>(grid.functions.size()) + 2,
                           kTop + kBoxHeight * static_cast<double>(grid.pairs.size()) + 2, title);
}

std::string boxLabel(const Column& column)
{
    std::string label = column.label();
    label = label.substr(0, label.find(','));
    if (label == "Reweighting") return "Reweight";
    if (label == "R-A thinned") return "thinned";
    if (label == "Rejection") return "Reject";
    if (label == "Augmentation") return "Augment";
    if (label == "RIS of old") return "RIS";
    return label;
}

std::string winnerMap(const std::string& title, const CellTable& table,
                      const std::vector<Beta>& betas, std::set<std::string>& seen)
{
    return heatMap(title, table, [&](const Row& row) {
        const std::vector<Column> best = winners(table, row, betas);
        Box box{"–", "none", "", row.pair + " " + row.function + ": nobody"};
        if (best.empty()) return box;
        std::string names;
        bool oneMethod = true;
        for (const Column& column : best) {
            names += (names.empty() ? "" : ", ") + column.label();
            oneMethod = oneMethod && column.method == best.front().method;
        }
        box.title = row.pair + " " + row.function + ": " + names + ", N·Var " +
                    shortNumber(decidingVariance(*table.find(row, best.front())));
        if (oneMethod) {
            seen.insert(best.front().method);
            box.text = best.size() == 1 ? boxLabel(best.front())
                                        : boxLabel({best.front().method, Beta::none, 0});
            box.style = "fill " + best.front().style();
            box.textStyle = "on " + best.front().style();
        } else {
            box.text = "tie";
        }
        return box;
    });
}

/// Shades by the ratio of variances; 1.02 and less is no relevant difference.
std::string shade(double ratio)
{
    const double size = std::abs(std::log(ratio));
    if (!(size > std::log(1.02))) return "none";
    const char* strength = size > std::log(3) ? "3" : size > std::log(1.4) ? "2" : "1";
    return std::string(ratio < 1 ? "b" : "w") + strength;
}

std::string duelMap(const std::string& title, const CellTable& table, const Column& a,
                    const Column& b)
{
    return heatMap(title, table, [&](const Row& row) {
        Box box{"–", "none", "", row.pair + " " + row.function + ": no comparison"};
        const Cell *first = table.find(row, a), *second = table.find(row, b);
        if (!first || !second) return box;
        const double va = decidingVariance(*first), vb = decidingVariance(*second);
        box.title = row.pair + " " + row.function + ": " + a.label() + " " + shortNumber(va) +
                    ", " + b.label() + " " + shortNumber(vb);
        const int order = compareVariance(*first, *second);
        const double ratio = order == 0 ? 1 : va / vb;
        // Against nothing at all every loss is infinite.
        box.text = order == 0 ? "=" : order > 0 && ratio > 1e4 ? "∞" : shortNumber(ratio, 2);
        if (order < 0 && ratio < 1e-4) box.text = "0";
        box.style = order == 0 ? "none" : shade(ratio);
        return box;
    });
}

std::string legendOf(const std::set<std::string>& methods)
{
    std::string html;
    for (const std::string& id : methods) {
        const Column column{id};
        html += "<span class=\"" + column.style() + "\"><span class=\"swatch\"></span>" +
                escapeMarkup(column.label()) + "</span> &#160; ";
    }
    return "<p class=\"small\">" + html +
           "A number after R-A is its k. <b>tie</b>: several methods are equally good.</p>\n";
}

std::string scoreBar(const Duel& d)
{
    std::string html = "<div class=\"bar3\">";
    const auto piece = [&](const char* style, size_t count) {
        if (count)
            html += std::string("<span class=\"") + style +
                    "\" style=\"flex:" + std::to_string(count) + "\">" + std::to_string(count) +
                    "</span>";
    };
    piece("w", d.wins.size());
    piece("t", d.ties.size());
    piece("l", d.losses.size());
    return html + "</div>";
}

std::string duelRow(const CellTable& table, const Column& a, const Column& b)
{
    const bool own = a.beta == Beta::own;
    const Duel d = duel(table, a, b, own ? Judge::evenBiased : Judge::unbiased);
    if (d.rows() == 0) return {};
    return "<tr><td class=\"name\">" + escapeMarkup(a.label()) + "</td><td class=\"name\">" +
           escapeMarkup(b.label()) + "</td><td>" + scoreBar(d) + "</td><td>" + rowList(d.losses) +
           "</td></tr>\n";
}

}  // namespace

std::string winnersSection(const LabResults& results)
{
    if (results.cells.empty()) return {};
    const CellTable table(results, 1);
    std::set<std::string> seen;
    std::string maps = "<div class=\"pairoffigures\">\n<figure>" +
                       winnerMap("Lowest variance, nothing corrected", table, {Beta::none}, seen) +
                       "</figure>\n";
    const bool corrected = std::any_of(table.columns().begin(), table.columns().end(),
                                       [](const Column& c) { return c.beta == Beta::ideal; });
    if (corrected)
        maps += "<figure>" +
                winnerMap("Lowest variance, corrections allowed (ideal β)", table,
                          {Beta::none, Beta::ideal}, seen) +
                "</figure>\n";
    std::string html =
        paragraph("Rows are changes of density, columns are functions. Only unbiased methods take "
                  "part, and only where they spend at most as many new rays as there are old "
                  "samples (n = N). The predicted variance decides.");
    html += maps + "</div>\n" + legendOf(seen);
    html += paragraph("How much does it matter? The maps below show the variance of R-A (k = 4) "
                      "divided by that of its rival: 0.5 means that R-A needs half the rays "
                      "(blue), 2 that it needs twice as many (orange), = that both are the same, 0 "
                      "that the rival has infinite variance and ∞ that it has none.");
    html += "<div class=\"pairoffigures\">\n";
    for (const Beta beta : {Beta::none, Beta::ideal}) {
        if (!table.has(usualRa(beta))) continue;
        const std::string with = beta == Beta::none ? "plain" : "ideal β";
        html += "<figure>" +
                duelMap("R-A against Discard, " + with, table, usualRa(beta), {"discard"}) +
                "</figure>\n<figure>" +
                duelMap("R-A against MIS, " + with + (beta == Beta::none ? "" : " on both"), table,
                        usualRa(beta), {"mis", beta}) +
                "</figure>\n";
    }
    return section("winners", "Who wins", html + "</div>\n");
}

std::string lossesSection(const LabResults& results)
{
    const CellTable table(results, 1);
    std::string rows;
    const Column plain = usualRa(Beta::none), ideal = usualRa(Beta::ideal),
                 own = usualRa(Beta::own);
    for (const char* rival : {"discard", "reweighting", "rejection", "ris", "augmentation",
                              "rejection-augmentation", "ra-thinned", "mis"})
        rows += duelRow(table, plain, {rival});
    for (const char* rival : {"discard", "reweighting", "rejection-augmentation", "mis"})
        rows += duelRow(table, ideal, {rival});
    for (const char* corrected : {"ra-thinned", "mis"})
        rows += duelRow(table, ideal, {corrected, Beta::ideal});
    rows += duelRow(table, own, {"discard"});
    rows += duelRow(table, own, {"mis", Beta::own});
    if (rows.empty()) return {};
    std::string html =
        paragraph("R-A with k = 4 against each rival, row by row of the table at n = N, wherever "
                  "both exist and both are unbiased (with β of its own, R-A is slightly biased and "
                  "compared all the same). Blue: rows that R-A wins; grey: ties; orange: rows that "
                  "it loses, listed at the right. Augmentation may spend many more rays than R-A; "
                  "Reweighting, Rejection and RIS spend none.");
    html +=
        tableMarkup("<th>R-A</th><th>against</th><th>won, tied, lost</th><th>lost in</th>", rows);
    return section("losses", "Where R-A loses, and to what", html);
}

}  // namespace app::lab
