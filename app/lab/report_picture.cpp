// What the laboratory is about, in one picture: flatland before and after the camera moved, what
// becomes of the samples, and the new image as each way to go on renders it. See report_parts.h.
#include <algorithm>
#include <cmath>

#include "app/lab/flatland.h"
#include "app/lab/report_parts.h"

namespace app::lab {

namespace {

constexpr double kWidth = 680, kGroundAt = 232, kHeight = 268, kUp = 185;  // pixels; kUp: of y = 1

/// From brightness to a grey value, proportionally: differences count, not the look.
uint8_t grey(double value)
{
    constexpr double kWhite = 2.2;  // a little above the glint, so that its grain is seen
    if (!(value > 0)) return 0;
    return static_cast<uint8_t>(std::lround(255 * std::min(value / kWhite, 1.0)));
}

std::string stripImage(const FlatlandPicture& picture, const FlatlandStrip& strip)
{
    constexpr double kThin = 34;  // of a strip with one row
    GreyImage image{picture.pixels, {}};
    for (const double value : strip.values) image.values.push_back(grey(value));
    if (image.width == 0 || image.values.empty() || image.values.size() % image.width != 0)
        return {};
    const double rows = static_cast<double>(image.values.size() / image.width);
    const double height = rows == 1 ? kThin : rows * kWidth / picture.pixels;
    Drawing drawing;
    drawing.image({0, 0}, kWidth, height, image);
    return drawing.element(kWidth, height, "Rendered: " + strip.name);
}

std::string biasText(const FlatlandStrip& strip)
{
    if (strip.biasSeen)
        return "<span class=\"bad\">wrong on average by " + percent(strip.bias) + "</span>.";
    return strip.unbiased ? "right on average, as far as can be seen."
                          : "its error on average does not show in so few rows.";
}

std::string stripNumbers(const FlatlandStrip& strip)
{
    if (strip.exact) return {};
    return "<br>Grain " + percent(strip.noise) + " of the mean brightness; " + biasText(strip);
}

std::string stripHtml(const FlatlandPicture& picture, const FlatlandStrip& strip)
{
    return "<div class=\"strip\"><div>" + stripImage(picture, strip) +
           "</div><p class=\"small\"><b>" + escapeMarkup(strip.name) +
           "</b>: " + escapeMarkup(strip.meaning) + stripNumbers(strip) + "</p></div>\n";
}

/// From the scene to pixels; heights are drawn shorter than they are.
class View {
public:
    explicit View(const FlatlandPicture& picture) : picture_(picture) {}
    Point at(double x, double y) const
    {
        return {(x - picture_.low) / picture_.width * kWidth, kGroundAt - y * kUp};
    }

private:
    const FlatlandPicture& picture_;
};

void drawCamera(Drawing& drawing, const View& view, const FlatCamera& camera, const char* name,
                const std::string& style)
{
    const FlatlandSettings usual;
    const Point eye = view.at(camera.x, camera.height);
    const Point low = view.at(kNewCamera.ground(usual.pixelLow), 0),
                high = view.at(kNewCamera.ground(usual.pixelLow + usual.pixelWidth), 0);
    drawing.polygon({eye, low, high}, "band " + style);
    drawing.circle(eye, 6, "dot " + style);
    drawing.text({eye.x + 11, eye.y + 1}, name, "");
}

/// Where the light comes from that a sample stands for: a line from the ground, whole as far as the
/// sample counts.
void drawSample(Drawing& drawing, const View& view, const FlatlandSample& s)
{
    constexpr double kLength = 0.62;
    const double up = std::sqrt(std::max(0.0, 1 - s.direction * s.direction));
    const auto along = [&](double length) {
        return view.at(s.ground + length * s.direction, length * up);
    };
    const Point start = view.at(s.ground, 0), end = along(kLength);
    if (s.fresh) {
        drawing.line(start, end, "curve c-orange");
        drawing.marker(end, Shape::triangle, "c-orange");
        return;
    }
    const double share = std::clamp(s.weight, 0.0, 1.0);
    drawing.line(along(share * kLength), end, "curve thin dashed c-grey");
    drawing.line(start, along(share * kLength), "curve c-blue");
    drawing.marker(end, Shape::circle, share > 0.5 ? "c-blue" : "c-grey");
}

/// The ground below the pixel of the strip that is brightest.
void drawGlint(Drawing& drawing, const View& view, const FlatlandPicture& picture,
               const std::vector<double>& brightness, const char* name)
{
    const auto brightest = std::max_element(brightness.begin(), brightness.end());
    if (brightest == brightness.end()) return;
    const double share = (static_cast<double>(brightest - brightness.begin()) + 0.5) /
                         static_cast<double>(brightness.size());
    const Point place = view.at(picture.low + share * picture.width, 0);
    drawing.polygon(
        {{place.x, place.y + 5}, {place.x + 6, place.y + 16}, {place.x - 6, place.y + 16}},
        "heat fill ink");
    drawing.text({place.x, place.y + 31}, name, "", Anchor::middle);
}

std::string scene(const FlatlandPicture& picture)
{
    const View view(picture);
    Drawing drawing;
    drawCamera(drawing, view, kOldCamera, "old camera", "c-grey");
    drawCamera(drawing, view, kNewCamera, "new camera", "c-sky");
    drawing.line({0, kGroundAt}, {kWidth, kGroundAt}, "axis");
    const Point low = view.at(kHiddenFromOld.low, 0), high = view.at(kHiddenFromOld.high, 0);
    drawing.rectangle({low.x, kGroundAt - 3}, high.x - low.x, 6, "dot c-red");
    for (const FlatlandSample& sample : picture.samples) drawSample(drawing, view, sample);
    for (const FlatlandStrip& strip : picture.strips)
        if (strip.name == "before")
            drawGlint(drawing, view, picture, strip.values, "glint, before");
    drawGlint(drawing, view, picture, picture.truth, "glint, now");
    drawing.text({4, kGroundAt - 6}, "glossy ground", "");
    return drawing.element(kWidth, kHeight,
                           "Flatland: the ground, the camera before and after it moved, and the "
                           "samples of one pixel");
}

std::string key(const char* style, const std::string& words)
{
    return std::string("<span class=\"") + style + "\"><span class=\"swatch\"></span>" + words +
           "</span>";
}

std::string sceneHtml(const FlatlandPicture& picture)
{
    return "<div class=\"strip scene\"><div>" + scene(picture) +
           "</div><p class=\"small\">The samples that one pixel of the new camera gets, and where "
           "their light comes from.<br>" +
           key("c-blue", "old sample, as far as it counts") + "<br>" +
           key("c-grey", "its rest, discarded (dashed)") + "<br>" +
           key("c-orange", "new sample (triangle)") + "<br>" +
           key("c-red", "ground that was hidden from the old camera") +
           "<br>Heights are drawn shorter than they are.</p></div>\n";
}

const FlatlandStrip* stripOf(const FlatlandPicture& picture, const std::string& name)
{
    for (const FlatlandStrip& strip : picture.strips)
        if (strip.name == name) return &strip;
    return nullptr;
}

/// How many times the rays the grain of R-A is worth.
std::string worth(const FlatlandPicture& picture)
{
    const FlatlandStrip *anew = stripOf(picture, "discard"),
                        *reuse = stripOf(picture, "exact, 32 old, corrected");
    if (!anew || !reuse || !(reuse->noise > 0)) return {};
    const double times = std::pow(anew->noise / reuse->noise, 2);
    if (!(times > 1)) return {};
    return paragraph("Both of the unbiased ones trace four new rays per pixel. To be as smooth as "
                     "the last strip, starting anew would need " +
                     shortNumber(times, 2) + " times as many.");
}

}  // namespace

std::string pictureSection(const LabResults& results)
{
    const FlatlandPicture& picture = results.picture;
    if (picture.strips.empty() || !(picture.width > 0) || picture.pixels == 0) return {};
    std::string html = paragraph(
        "A world with one dimension less: a glossy ground, and a camera that moved from the left "
        "to the middle; the glint on the ground moved with it. Samples traced for the old image "
        "are still there: what may be done with them? Below the scene is the new image, its pixels "
        "straight below the ground that they see. In the grainy strips every pixel of every row is "
        "an estimate of its own, by this run.");
    html += sceneHtml(picture);
    for (const FlatlandStrip& strip : picture.strips) html += stripHtml(picture, strip);
    html += worth(picture);
    html += dataLine("picture.csv", {"strip", "row", "pixel", "value", "truth"});
    html += dataLine("lab.json", {"picture.strips.noise", "picture.strips.bias"});
    html += dataLine("samples.csv", {"sample", "ground", "direction", "share"});
    html +=
        paragraph("One variant after another is measured in <a href=\"#flatland\">Flatland</a>; "
                  "all else on this page is about the same question in one dimension, where "
                  "every answer is known.");
    return section("picture", "At a glance", html);
}

}  // namespace app::lab
