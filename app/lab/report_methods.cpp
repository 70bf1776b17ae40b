// What is compared, on what: cards of methods, of changes of density and of functions. See
// report_parts.h.
#include <algorithm>
#include <cmath>

#include "app/lab/functions.h"
#include "app/lab/methods.h"
#include "app/lab/pairs.h"
#include "app/lab/report_parts.h"

namespace app::lab {

namespace {

constexpr int kCurveSteps = 240;  // of a drawn curve

/// An end of a support is a jump: both sides of it are drawn.
std::vector<double> abscissas(const Pair& pair)
{
    constexpr double kEdge = 1e-9;
    std::vector<double> xs;
    for (int i = 0; i <= kCurveSteps; ++i) xs.push_back(static_cast<double>(i) / kCurveSteps);
    for (const double x : {pair.q.low(), pair.q.high(), pair.p.low(), pair.p.high()})
        for (const double side : {x - kEdge, x + kEdge})
            if (side > 0 && side < 1) xs.push_back(side);
    std::sort(xs.begin(), xs.end());
    return xs;
}

std::string pairPicture(const Pair& pair)
{
    const double c = pair.bestC(1, 1);
    std::vector<Point> old, fresh, kept, zero;
    double highest = 0;
    for (const double x : abscissas(pair)) {
        const double q = pair.q.pdf(x), p = pair.p.pdf(x);
        old.push_back({x, q});
        fresh.push_back({x, p});
        kept.push_back({x, std::min(c * q, p)});
        zero.push_back({x, 0});
        highest = std::max({highest, q, p});
    }
    Plot plot("", linearAxis("", 0, 1), linearAxis("", 0, highest, 3), 280, 150);
    plot.band(zero, kept, "c-blue");
    plot.band(kept, fresh, "c-orange");
    plot.curve(old, "c-grey dashed");
    plot.curve(fresh, "ink");
    plot.describe("Old and new density of " + pairLabel(pair.id));
    return plot.element();
}

std::string pairCard(const Pair& pair)
{
    const double c = pair.bestC(1, 1);
    std::string html = "<article class=\"card\"><h3>" + escapeMarkup(pairLabel(pair.id)) +
                       "</h3><span class=\"small\">" + escapeMarkup(pair.formula) + "<br>" +
                       escapeMarkup(pair.meaning) + "</span>" + pairPicture(pair);
    html += "<p class=\"small\">b = " + shortNumber(pair.rejectionConstant(), 4) +
            " &#160; a = " + shortNumber(pair.augmentationConstant(), 4) +
            " &#160; TV = " + shortNumber(pair.residual(1)) +
            "<br>at n = N: c* = " + shortNumber(c, 4) + " &#160; M*/N = " + shortNumber(1 / c, 4) +
            "</p></article>\n";
    return html;
}

std::string functionCard(size_t index)
{
    std::vector<Point> curve;
    double highest = 0;
    for (int i = 0; i <= kCurveSteps; ++i) {
        const double x = (i + 0.5) / (kCurveSteps + 1);  // F8 is infinite at 0
        curve.push_back({x, evaluateFunctions(x)[index]});
        highest = std::max(highest, curve.back().y);
    }
    const TestFunction& f = functions()[index];
    Plot plot("", linearAxis("", 0, 1, 2), linearAxis("", 0, highest, 3), 215, 110);
    plot.curve(curve, "ink");
    plot.describe("Graph of " + functionLabel(f.id));
    return "<article class=\"card\"><h3>" + escapeMarkup(functionLabel(f.id)) +
           "</h3><span class=\"small\">" + escapeMarkup(f.formula) +
           "<br>∫ = " + shortNumber(integrateFunctions(0, 1)[index], 4) + "</span>" +
           plot.element() + "</article>\n";
}

}  // namespace

std::string methodsSection()
{
    std::string cards;
    for (const Method& m : methods()) {
        const Column column{m.id};
        cards += "<article class=\"card\"><h3><span class=\"" + column.style() +
                 "\"><span class=\"swatch\"></span></span>" + escapeMarkup(m.name) +
                 "<span class=\"tag\">" + (m.unbiased ? "unbiased" : "biased") +
                 "</span></h3><span class=\"formula\">" + escapeMarkup(m.formula) + "</span><p>" +
                 escapeMarkup(m.meaning) + "</p>";
        if (*m.needs) cards += "<p class=\"small\">Needs: " + escapeMarkup(m.needs) + ".</p>";
        cards += "</article>\n";
    }
    std::string html =
        paragraph("Old samples x of density q, N of them; new samples y of density p, n of them; "
                  "candidates z. W is the mean weight of the k candidates among which one was "
                  "resampled, c the scale on q, R(c) the mass of p that c·q does not cover.");
    html += "<div class=\"cards\">\n" + cards + "</div>\n" +
            dataLine("methods.csv", {"id", "name", "formula", "needs", "unbiased"});
    html +=
        paragraph("<b>The correction β.</b> Most of these can be written as a sum of weights v "
                  "times f/p, where the weights sum to one on average. Subtracting β (Σv − 1) "
                  "changes nothing on average and removes the noise of that sum. <em>β ideal</em> "
                  "uses the integral itself, the best that can be done; <em>β own</em> uses the "
                  "estimate, which is self-normalisation and biased by an amount of order 1/N.");
    return section("methods", "The methods", html);
}

std::string pairsSection()
{
    std::string html =
        paragraph("The nine changes of density. Dashed: the old density q; line: the new one p. "
                  "Blue: what c·q covers of p at the best c for n = N; orange: the residual, what "
                  "new samples must supply. b = sup p/q and a = sup q/p are the majorisation "
                  "constants that Rejection and Augmentation need; TV is the share of p outside of "
                  "q; C is a Cauchy lobe (centre, width), U uniform.");
    html += "<div class=\"cards\">\n";
    for (const Pair& pair : pairs()) html += pairCard(pair);
    html += "</div>\n" +
            dataLine("densities.csv",
                     {"pair", "name", "formula", "rejection", "augmentation", "total_variation",
                      "c", "growth"},
                     "curves by the formulas") +
            "<h3>The functions</h3>\n<div class=\"cards narrow\">\n";
    for (size_t i = 0; i < kFunctions; ++i) html += functionCard(i);
    html += "</div>\n" + dataLine("functions.csv", {"f", "name", "formula", "integral"},
                                  "curves by the formulas");
    return section("densities", "The changes of density and the functions", html);
}

}  // namespace app::lab
