// Whom R-A beats and to whom it loses, row by row of the table, one map per rival. See
// report_parts.h.
#include <algorithm>

#include "app/lab/report_parts.h"

namespace app::lab {

namespace {

bool holds(const std::vector<Row>& rows, const Row& row)
{
    return std::find(rows.begin(), rows.end(), row) != rows.end();
}

Map outcomeMap(const CellTable& table, const Column& a, const Column& b, const Duel& d)
{
    Map map = rowMap("against " + b.label(), table, [&table, a, b, d](const Row& row) {
        if (!holds(d.wins, row) && !holds(d.ties, row) && !holds(d.losses, row))
            return MapCell{"", "none", "", "no comparison"};
        const std::string numbers =
            a.label() + " " + shortNumber(decidingVariance(*table.find(row, a))) + ", " +
            b.label() + " " + shortNumber(decidingVariance(*table.find(row, b)));
        if (holds(d.wins, row)) return MapCell{"+", "fill c-blue", "on c-blue", numbers};
        if (holds(d.ties, row)) return MapCell{"=", "none", "", numbers};
        return MapCell{"−", "fill c-red", "on c-red", numbers};
    });
    map.cellWidth = 20;
    map.cellHeight = 17;
    map.slanted = true;
    return map;
}

std::string duelFigure(const CellTable& table, const Column& a, const Column& b)
{
    const bool own = a.beta == Beta::own;
    const Duel d = duel(table, a, b, own ? Judge::evenBiased : Judge::unbiased);
    if (d.rows() == 0) return {};
    return mapFigure(outcomeMap(table, a, b, d),
                     "Won " + std::to_string(d.wins.size()) + ", tied " +
                         std::to_string(d.ties.size()) + ", lost " +
                         std::to_string(d.losses.size()) + " of " + std::to_string(d.rows()) + ".",
                     duelId(a, b));
}

std::string group(const std::string& title, const CellTable& table, const Column& a,
                  const std::vector<Column>& rivals)
{
    std::string figures;
    for (const Column& rival : rivals) figures += duelFigure(table, a, rival);
    if (figures.empty()) return {};
    return "<h3>" + escapeMarkup(title) + "</h3>\n<div class=\"three\">\n" + figures + "</div>\n";
}

}  // namespace

std::string lossesSection(const LabResults& results)
{
    const CellTable table(results, 1);
    std::vector<Column> plain;
    for (const char* rival : {"discard", "mis", "reweighting", "rejection", "ris", "augmentation",
                              "rejection-augmentation", "ra-thinned"})
        plain.push_back({rival});
    const std::string maps = group("R-A, k = 4, as it is", table, usualRa(Beta::none), plain) +
                             group("R-A, k = 4, with the ideal β", table, usualRa(Beta::ideal),
                                   {{"discard"},
                                    {"mis", Beta::ideal},
                                    {"mis"},
                                    {"reweighting"},
                                    {"rejection-augmentation"},
                                    {"ra-thinned", Beta::ideal}}) +
                             group("R-A, k = 4, with β of its own", table, usualRa(Beta::own),
                                   {{"discard"}, {"mis", Beta::own}});
    if (maps.empty()) return {};
    std::string html = paragraph(
        "R-A with k = 4 against each rival, row by row of the table at n = N, wherever both exist "
        "and both are unbiased (with β of its own, R-A is slightly biased and compared all the "
        "same). Augmentation may spend many more rays than R-A; Reweighting, Rejection and RIS "
        "spend none.");
    html +=
        "<p class=\"small legend\"><span class=\"c-blue\"><span class=\"swatch\"></span><b>+</b> "
        "R-A has the lower variance</span><span><b>=</b> equal</span><span "
        "class=\"c-red\"><span class=\"swatch\"></span><b>−</b> R-A loses</span>"
        "<span>empty: no comparison</span></p>\n";
    html += maps + dataLine("cells.csv",
                            {"pair", "f", "method", "beta", "k", "expected_n_var", "n_var"},
                            "rows with n = N, or n = 0");
    return section("losses", "Where R-A loses, and to what", html);
}

}  // namespace app::lab
