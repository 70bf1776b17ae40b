// What was found, in sentences made from the cells. See report_parts.h.
#include <algorithm>
#include <cmath>

#include "app/base/read_value.h"
#include "app/lab/functions.h"
#include "app/lab/methods.h"
#include "app/lab/pairs.h"
#include "app/lab/report_parts.h"

namespace app::lab {

namespace {

std::string cellName(const Cell& c)
{
    return rowWords({c.pair, c.function}) + ", " +
           Column{c.method, c.beta, c.method == "ra" ? c.candidates : 0}.label() +
           (c.newSamples != c.oldSamples ? " (n = " + std::to_string(c.newSamples) + ")" : "");
}

std::string cellList(const std::vector<const Cell*>& cells)
{
    constexpr size_t kMost = 12;
    std::string text;
    for (size_t i = 0; i < std::min(cells.size(), kMost); ++i)
        text += (i ? "; " : "") + cellName(*cells[i]);
    if (cells.size() > kMost) text += "; and " + std::to_string(cells.size() - kMost) + " more";
    return escapeMarkup(text);
}

/// Do the measurements agree with their expectations?
std::string correctness(const Verdict& v)
{
    std::string text = "<b>Are the methods right?</b> Of " + counted(v.cells, "cell") + ", " +
                       std::to_string(v.meansJudged) +
                       " are of an unbiased method with a finite variance. ";
    if (v.meansJudged == 0)
        text += "There is nothing to judge. ";
    else if (v.meansOff.empty())
        text += "In none of them is the mean farther than " + numberText(kMeanBound) +
                " standard errors from the true integral; the farthest is at " +
                shortNumber(v.largestZ, 2) + ". ";
    else
        text += "<span class=\"bad\">In " + std::to_string(v.meansOff.size()) +
                " the mean is farther than " + numberText(kMeanBound) +
                " standard errors from the true integral</span>: " + cellList(v.meansOff) + ". ";
    text += "Measured and predicted variance agree within " + numberText(kVarianceBound) +
            " standard errors in " +
            outOf(v.variancesJudged - v.variancesOff.size(), v.variancesJudged) +
            " cells that have a finite prediction";
    text += v.variancesOff.empty() ? ". " : "; not in " + cellList(v.variancesOff) + ". ";
    if (v.infinite)
        text += counted(v.infinite, "cell") + (v.infinite == 1 ? " has" : " have") +
                " provably infinite variance: what was measured there (marked ∞) means nothing and "
                "is not judged. ";
    if (v.biased)
        text += "Of " + counted(v.biased, "cell") +
                " of methods known to be biased, the bias shows in " +
                std::to_string(v.biasedSeen) + ".";
    return paragraph(text);
}

/// "lower in 62 of 72 rows, equal in 2, higher in 8".
std::string outcome(const Duel& d)
{
    std::string text = "lower in " + outOf(d.wins.size(), d.rows()) + " rows";
    if (!d.ties.empty()) text += ", equal in " + std::to_string(d.ties.size());
    return text + ", higher in " + std::to_string(d.losses.size());
}

/// Which rows, as a link to their map.
std::string mapLink(const Column& a, const Column& b)
{
    return " (<a href=\"#" + duelId(a, b) + "\">map</a>)";
}

std::string listItem(const std::string& rival, const std::string& html)
{
    return "<li>against " + rival + ": " + html + "</li>\n";
}

/// N Var of Discard over the square of the integral: how much f/p varies.
std::vector<double> relativeVariances(const CellTable& table, const std::vector<Row>& rows)
{
    std::vector<double> values;
    for (const Row& row : rows) {
        const Cell& cell = *table.find(row, {"discard"});
        values.push_back(decidingVariance(cell) / (cell.truth * cell.truth));
    }
    std::sort(values.begin(), values.end());
    return values;
}

/// Why Discard wins where it does, if the cells support that reason.
std::string lossReason(const CellTable& table, const Duel& d)
{
    const std::vector<double> lost = relativeVariances(table, d.losses),
                              won = relativeVariances(table, d.wins);
    if (lost.empty() || won.empty()) return {};
    const double median = won[won.size() / 2];
    if (!(lost.back() < 0.5 * median)) return {};
    return ": there f/p varies little, so that fresh samples are good as they are (N·Var at most " +
           shortNumber(lost.back(), 2) + " I², where the median of the other rows is " +
           shortNumber(median, 2) + " I²), and R-A pays for the noise of its weights";
}

/// Plain R-A against everyone, and where it loses.
std::string plainRa(const CellTable& table)
{
    const Column ra = usualRa(Beta::none);
    const Duel discard = duel(table, ra, {"discard"}), mis = duel(table, ra, {"mis"}),
               reweighting = duel(table, ra, {"reweighting"}),
               kept = duel(table, ra, {"rejection-augmentation"});
    if (discard.rows() == 0) return {};
    std::string list = outcome(discard) + mapLink(ra, {"discard"}) + lossReason(table, discard);
    list = listItem("Discard", list + ";");
    if (kept.rows())
        list += listItem("Rejection-Augmentation",
                         outcome(kept) + mapLink(ra, {"rejection-augmentation"}) + ";");
    if (reweighting.rows())
        list += listItem("Reweighting, which spends no new ray but is biased where the old density "
                         "vanishes (those rows are left out)",
                         outcome(reweighting) + mapLink(ra, {"reweighting"}) + ";");
    if (mis.rows())
        list += listItem("the plain balance heuristic (MIS)",
                         outcome(mis) + mapLink(ra, {"mis"}) +
                             (mis.losses.size() > mis.wins.size()
                                  ? ": <b>more often than not, MIS is the better choice "
                                    "when nothing is corrected.</b>"
                                  : ": more often than not, R-A is the better choice."));
    return paragraph("<b>Where does Reweighting-Augmentation (R-A) win, where does it lose?</b> "
                     "Plain, with " +
                     std::to_string(kUsualCandidates) +
                     " candidates and as many new samples as old ones, its variance is") +
           "<ul>\n" + list + "</ul>\n";
}

/// What subtracting beta (sum of weights - 1) changes.
std::string correctedRa(const CellTable& table)
{
    const Column ra = usualRa(Beta::ideal), mis{"mis", Beta::ideal};
    if (!table.has(ra)) return {};
    const Duel plain = duel(table, usualRa(Beta::none), {"discard"}),
               discard = duel(table, ra, {"discard"}), rival = duel(table, ra, mis);
    std::string text = "<b>What does the correction change?</b> The weights of R-A sum to one only "
                       "on average; subtracting β (Σv − 1) removes the noise of that sum. With the "
                       "best β, R-A loses to Discard in " +
                       outOf(discard.losses.size(), discard.rows()) + " rows instead of " +
                       std::to_string(plain.losses.size());
    text += discard.rows() ? mapLink(ra, {"discard"}) + ". " : ". ";
    if (rival.rows()) {
        text += "Against MIS with the same correction it is not worse in " +
                outOf(rival.wins.size() + rival.ties.size(), rival.rows()) + " rows";
        text +=
            (rival.ties.empty() ? "" : ", " + std::to_string(rival.ties.size()) + " of them ties") +
            mapLink(ra, mis) + ". ";
    }
    const Column own = usualRa(Beta::own);
    if (table.has(own)) {
        const Duel realised = duel(table, own, {"discard"}, Judge::evenBiased);
        text +=
            "The best β is the integral itself, which one does not know. With the estimate in its "
            "place (self-normalisation, at the price of a small bias) R-A loses to Discard in " +
            outOf(realised.losses.size(), realised.rows()) + " rows";
        text += realised.rows() ? mapLink(own, {"discard"}) + ". " : ". ";
    }
    if (discard.losses.empty() && !plain.losses.empty())
        text += "<b>R-A should not go without the correction; with the best β it is never worse "
                "here than starting anew.</b>";
    return paragraph(text);
}

/// The same with fewer new samples, in a sentence.
std::string fewerRays(const LabResults& results)
{
    std::string text;
    for (const double ratio : ratios(results)) {
        if (ratio >= 1) continue;
        const CellTable table(results, ratio);
        const Duel discard = duel(table, usualRa(Beta::none), {"discard"}),
                   mis = duel(table, usualRa(Beta::none), {"mis"});
        if (discard.rows() == 0) continue;
        text += "With n = " + numberText(ratio) +
                " N new samples the variance of plain R-A is, against Discard, " +
                outcome(discard) + "; against MIS, " + outcome(mis) + ". ";
    }
    return text.empty() ? text : paragraph("<b>And with fewer new rays?</b> " + text);
}

std::string tiles(const CellTable& table, const Verdict& v)
{
    const Duel discard = duel(table, usualRa(Beta::none), {"discard"}),
               mis = duel(table, usualRa(Beta::none), {"mis"}),
               corrected = duel(table, usualRa(Beta::ideal), {"discard"});
    std::string html =
        tile(std::to_string(v.cells), "cells: a method on a function under a change of density");
    html += tile(outOf(v.meansOff.size(), v.meansJudged),
                 "unbiased cells with a mean off by more than " + numberText(kMeanBound) +
                     " standard errors");
    if (discard.rows())
        html += tile(outOf(discard.losses.size(), discard.rows()),
                     "rows in which plain R-A is worse than throwing the old samples away");
    if (mis.rows())
        html += tile(outOf(mis.losses.size(), mis.rows()), "rows in which plain R-A loses to MIS");
    if (corrected.rows())
        html += tile(outOf(corrected.losses.size(), corrected.rows()),
                     "rows in which R-A with the ideal correction is worse than Discard");
    return "<div class=\"tiles\">\n" + html + "</div>\n";
}

/// Two lobes: what is kept of the old, what is missing of the new.
std::string ideaPicture()
{
    const Pair& pair = pairs()[1];
    const double c = pair.bestC(1, 1);
    Plot plot("", linearAxis("direction x", 0, 1), linearAxis("density", 0, 4, 4), 460, 230);
    std::vector<Point> old, fresh, kept, zero;
    for (int i = 0; i <= 200; ++i) {
        const double x = i / 200.0;
        old.push_back({x, c * pair.q.pdf(x)});
        fresh.push_back({x, pair.p.pdf(x)});
        kept.push_back({x, std::min(old.back().y, fresh.back().y)});
        zero.push_back({x, 0});
    }
    plot.band(zero, kept, "c-blue");
    plot.band(kept, fresh, "c-orange");
    plot.curve(old, "c-grey dashed");
    plot.curve(fresh, "ink");
    plot.describe("A lobe that has moved: what old samples cover of it, and what is missing");
    plot.legend({"c·q, the old density", "c-grey dashed"});
    plot.legend({"p, the new one", "ink"});
    plot.legend({"covered by old samples", "c-blue", false, false, true});
    plot.legend({"missing: new samples go here", "c-orange", false, false, true});
    return plot.element();
}

}  // namespace

std::string summarySection(const LabResults& results)
{
    const Verdict v = verdict(results);
    if (v.cells == 0) return section("summary", "Summary", paragraph("No cells were measured."));
    const CellTable table(results, 1);
    const uint32_t samples = results.cells.front().oldSamples;
    std::string html = paragraph(
        "A renderer that has traced random light paths and then moves its camera holds samples of "
        "the wrong density. This page compares " +
        counted(methods().size(), "way") + " to go on, on " + counted(kFunctions, "function") +
        " with known integrals and " + counted(kPairs, "change") + " of density, each with " +
        std::to_string(samples) + " old samples and repeated " + std::to_string(results.trials) +
        " times" + fewerTrials(results) +
        ", so that every claim below has an error bar. All counts are computed from the "
        "cells of this run.");
    html += tiles(table, v) + dataLine("cells.csv", {}, "counted from its rows") + correctness(v) +
            plainRa(table) + correctedRa(table) + fewerRays(results);
    return section("summary", "Summary", html);
}

std::string ideaSection()
{
    std::string html = "<div class=\"pairoffigures\"><div>";
    html +=
        paragraph("Think of the glint on a varnished table. To paint it, a path tracer sends "
                  "random rays, most of them where the glint is bright: that preference is the "
                  "<em>density</em>. When the camera moves, the glint moves, and so must the "
                  "density. The rays of the last frame are still good measurements of the light, "
                  "but there are too many of them on one side and too few on the other.");
    html += paragraph(
        "Throwing them away is safe and wasteful. Using them as if nothing had happened paints the "
        "glint where it was. In between are the methods of this page: weight the old rays by how "
        "many of them the new density asks for (blue), and send new rays where they do not suffice "
        "(orange). A method is <em>unbiased</em> when it is right on average, with any number of "
        "rays; among those, the one with the least <em>variance</em>, the least grain, wins.");
    html += paragraph(
        "Three names come up all the time. <b>Discard</b> throws the old samples away. "
        "<b>MIS</b>, multiple importance sampling by the balance heuristic, draws new samples as "
        "Discard does and weights them together with the old ones. <b>R-A</b>, "
        "Reweighting-Augmentation, also steers the new ones to where old ones are missing: each is "
        "picked among <b>k</b> candidates. <a href=\"#methods\">All methods</a>.");
    html += "</div><figure>" + ideaPicture() +
            "<figcaption>A lobe that moved from .45 to .55. The scale c decides how much the old "
            "samples count for.</figcaption>" +
            dataLine("densities.csv", {"formula", "c"}, "row " + pairLabel(pairs()[1].id)) +
            "</figure></div>\n";
    html += paragraph(
        "Throughout, q is the old density with N samples x, p the new one with n "
        "samples y, f the function to integrate, c the scale on q. A change of density goes by "
        "a name and a code, as in " +
        rowWords({"D2", "F6"}) +
        "; "
        "<a href=\"#densities\">all of them</a> are drawn below. A <em>row</em> is "
        "one function under one change. <b>N·Var</b> is "
        "the variance of the estimate times N: the number to compare, smaller is "
        "better; half of it means half the rays for the same grain. The estimate of "
        "each cell is repeated from scratch with new random numbers in every trial.");
    return section("idea", "The idea", html);
}

}  // namespace app::lab
