// Flatland with its picture, and the traps. See report_parts.h.
#include <cmath>

#include "app/lab/flatland.h"
#include "app/lab/report_parts.h"

namespace app::lab {

namespace {

constexpr const char* kBiasHead =
    "<th class=\"n\">bias</th><th class=\"n\">expected</th><th class=\"n\">z</th>";

/// A bias is worth showing where chance does not explain it; else its size is chance.
std::string biasCells(double bias, double expected, double z)
{
    const bool seen = std::abs(z) > kMeanBound;
    return numberCell(percent(bias), seen) + numberCell(percent(expected)) +
           numberCell(shortNumber(z, 2), seen);
}

/// The ground, both cameras with the rays through the sides of their pixels, and what the old
/// camera does not see.
std::string flatlandPicture()
{
    // Units of the scene to pixels: x from -.7 to .35, y from 0 to 1.1.
    const auto at = [](double x, double y) { return Point{40 + (x + 0.7) * 440, 290 - y * 240}; };
    struct Eye {
        FlatCamera camera;
        double pixelLow, pixelHigh;
        const char* name;
        const char* style;
    };
    const FlatlandSettings usual;
    const Eye eyes[] = {{kOldCamera, 0.5, 0.7, "old camera (−.5, 1)", "c-grey"},
                        {kNewCamera, usual.pixelLow, usual.pixelLow + usual.pixelWidth,
                         "new camera (0, .8)", "c-blue"}};
    Drawing drawing;
    for (const Eye& e : eyes) {
        const Point eye = at(e.camera.x, e.camera.height);
        const Point low = at(e.camera.ground(e.pixelLow), 0);
        const Point high = at(e.camera.ground(e.pixelHigh), 0);
        const std::string style = e.style;
        drawing.polygon({eye, low, high}, "band " + style);
        drawing.line(eye, low, "curve thin " + style);
        drawing.line(eye, high, "curve thin " + style);
        drawing.circle(eye, 6, "dot " + style);
        drawing.text({eye.x + 10, eye.y - 6}, e.name, "label");
    }
    drawing.line(at(-0.7, 0), at(0.35, 0), "axis");
    drawing.rectangle({at(kHiddenFromOld.low, 0).x, at(0, 0).y - 4},
                      (kHiddenFromOld.high - kHiddenFromOld.low) * 440, 8, "dot c-red");
    const Point hidden = at((kHiddenFromOld.low + kHiddenFromOld.high) / 2, 0);
    drawing.line({hidden.x, hidden.y + 5}, {hidden.x, hidden.y + 25}, "curve thin c-red");
    drawing.text({hidden.x, hidden.y + 37}, "hidden from the old camera", "note", Anchor::middle);
    for (const double x : {-0.5, -0.25, 0.0, 0.25})
        drawing.text({at(x, 0).x, at(x, 0).y + 17}, shortNumber(x, 2), "tick", Anchor::middle);
    drawing.text({at(-0.7, 0).x, at(0, 0).y - 7}, "ground", "note");
    return drawing.element(
        560, 335,
        "Flatland: the ground, two cameras, their pixels, and what the old camera does not see");
}

}  // namespace

std::string flatlandSection(const LabResults& results)
{
    if (results.flatland.empty()) return {};
    std::string rows;
    for (const FlatlandResult& f : results.flatland) {
        rows += "<tr><td><b>" + escapeMarkup(f.variant) + "</b><br><span class=\"small\">" +
                escapeMarkup(f.meaning) + "</span></td><td>" +
                (f.unbiased ? "unbiased" : "biased") + "</td>" +
                numberCell(shortNumber(f.mean, 6)) + biasCells(f.bias, f.expectedBias, f.z) +
                numberCell(measured(f.variance, f.varianceError)) +
                numberCell(shortNumber(f.expectedVariance, 4)) +
                numberCell(shortNumber(f.meanWeight, 4)) + "</tr>\n";
    }
    std::string html = paragraph(
        "A world with one dimension less: a glossy ground, seen by a camera that moved. Samples of "
        "two old pixels are projected back to the ground and into the pixel of the new camera, "
        "where the same light is seen at another angle. Being right takes two things that are "
        "easily forgotten: the Jacobian, because a pixel covers another stretch of ground from the "
        "new place, and visibility, because a part of the ground was hidden. The true value is " +
        shortNumber(results.flatland.front().truth, 6) + ".");
    html += "<figure>" + flatlandPicture() +
            "<figcaption>The pixel of the new camera sees [.08, .16] of the ground; from the old "
            "one, [.10, .13] of it was hidden.</figcaption></figure>\n";
    html += tableMarkup("<th>variant</th><th></th>" + numberHead("mean") + kBiasHead +
                            numberHead("variance") + numberHead("expected") + numberHead("mean Σv"),
                        rows) +
            dataLine("flatland.csv", {"variant", "mean", "bias", "expected_bias", "z", "variance",
                                      "expected_variance", "mean_weight"});
    return section("flatland", "Flatland: samples from another camera", html);
}

std::string trapsSection(const LabResults& results)
{
    if (results.traps.empty()) return {};
    std::string rows;
    for (const Trap& t : results.traps)
        rows += "<tr><td rowspan=\"2\"><b>" + escapeMarkup(t.name) +
                "</b></td><td>Wrong: " + escapeMarkup(t.wrong) + "</td>" +
                biasCells(t.wrongBias, t.expectedBias, t.wrongZ) +
                "</tr>\n<tr><td>Right: " + escapeMarkup(t.right) + "</td>" +
                biasCells(t.rightBias, 0, t.rightZ) + "</tr>\n";
    std::string html =
        paragraph("Things that look right and are not. Each was run the wrong way and the right "
                  "way, often enough for the difference to show beyond doubt.");
    html += tableMarkup(std::string("<th>trap</th><th>way</th>") + kBiasHead, rows) +
            dataLine("traps.csv",
                     {"name", "wrong_bias", "expected_bias", "wrong_z", "right_bias", "right_z"});
    return section("traps", "Traps", html);
}

}  // namespace app::lab
