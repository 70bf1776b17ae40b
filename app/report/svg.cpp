// Elements of a drawing, and the plot made of them. See svg.h.
#include "app/report/svg.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "app/report/text.h"

namespace app::report {

namespace {

constexpr double kLetter = 5.9;   // mean width of a letter at the size of labels, in pixels
constexpr double kFontSize = 11;  // as in the style sheet
constexpr double kMarker = 3;     // radius

/// Coordinates: hundredths of a pixel are more than anyone sees.
std::string coordinate(double value)
{
    char text[32];
    const double rounded = std::round(std::clamp(value, -1e6, 1e6) * 100) / 100;
    const auto end = std::to_chars(text, text + sizeof text, rounded + 0.0);
    return {text, end.ptr};
}

std::string pair(Point p)
{
    return coordinate(p.x) + ',' + coordinate(p.y);
}

std::string attribute(const char* name, double value)
{
    return std::string(" ") + name + "=\"" + coordinate(value) + '"';
}

std::string classAttribute(std::string_view style)
{
    return style.empty() ? std::string() : " class=\"" + escapeMarkup(style) + '"';
}

bool finite(Point p)
{
    return std::isfinite(p.x) && std::isfinite(p.y);
}

}  // namespace

// Bytes that continue a letter do not count.
double textWidth(std::string_view text)
{
    const auto letters = std::count_if(text.begin(), text.end(), [](char c) {
        return (static_cast<unsigned char>(c) & 0xC0u) != 0x80u;
    });
    return kLetter * static_cast<double>(letters);
}

// --- drawing

void Drawing::line(Point a, Point b, std::string_view style)
{
    if (!finite(a) || !finite(b)) return;
    svg_ += "<line" + attribute("x1", a.x) + attribute("y1", a.y) + attribute("x2", b.x) +
            attribute("y2", b.y) + classAttribute(style) + "/>";
}

void Drawing::polyline(const std::vector<Point>& points, std::string_view style)
{
    std::string path;
    bool pen = false;
    for (const Point& p : points) {
        if (finite(p)) {
            path += pen ? 'L' : 'M';
            path += pair(p);
        }
        pen = finite(p);
    }
    if (!path.empty()) svg_ += "<path d=\"" + path + '"' + classAttribute(style) + "/>";
}

void Drawing::polygon(const std::vector<Point>& points, std::string_view style)
{
    if (points.empty() || !std::all_of(points.begin(), points.end(), finite)) return;
    std::string path;
    for (const Point& p : points) {
        path += path.empty() ? 'M' : 'L';
        path += pair(p);
    }
    svg_ += "<path d=\"" + path + "Z\"" + classAttribute(style) + "/>";
}

void Drawing::rectangle(Point corner, double width, double height, std::string_view style)
{
    if (!finite(corner) || !std::isfinite(width) || !std::isfinite(height)) return;
    svg_ += "<rect" + attribute("x", corner.x) + attribute("y", corner.y) +
            attribute("width", std::max(0.0, width)) + attribute("height", std::max(0.0, height)) +
            classAttribute(style) + "/>";
}

void Drawing::circle(Point centre, double radius, std::string_view style)
{
    if (!finite(centre)) return;
    svg_ += "<circle" + attribute("cx", centre.x) + attribute("cy", centre.y) +
            attribute("r", radius) + classAttribute(style) + "/>";
}

void Drawing::marker(Point centre, Shape shape, std::string_view style)
{
    const double r = kMarker, s = 0.85 * r, x = centre.x, y = centre.y;
    const std::string dot = "dot " + std::string(style);
    switch (shape) {
    case Shape::circle:
        circle(centre, r, dot);
        break;
    case Shape::square:
        polygon({{x - s, y - s}, {x + s, y - s}, {x + s, y + s}, {x - s, y + s}}, dot);
        break;
    case Shape::diamond:
        polygon({{x, y - 1.3 * r}, {x + 1.3 * r, y}, {x, y + 1.3 * r}, {x - 1.3 * r, y}}, dot);
        break;
    case Shape::triangle:
        polygon({{x, y - 1.2 * r}, {x + 1.15 * r, y + 0.9 * r}, {x - 1.15 * r, y + 0.9 * r}}, dot);
        break;
    case Shape::cross:
        line({x - s, y - s}, {x + s, y + s}, "curve " + std::string(style));
        line({x - s, y + s}, {x + s, y - s}, "curve " + std::string(style));
        break;
    }
}

void Drawing::text(Point at, std::string_view text, std::string_view style, Anchor anchor,
                   double degrees)
{
    if (!finite(at) || text.empty()) return;
    svg_ += "<text" + attribute("x", at.x) + attribute("y", at.y) + classAttribute(style);
    if (anchor != Anchor::start)
        svg_ += anchor == Anchor::middle ? " text-anchor=\"middle\"" : " text-anchor=\"end\"";
    if (degrees != 0)
        svg_ += " transform=\"rotate(" + coordinate(degrees) + ' ' + coordinate(at.x) + ' ' +
                coordinate(at.y) + ")\"";
    svg_ += '>' + escapeMarkup(text) + "</text>";
}

void Drawing::image(Point corner, double width, double height, const GreyImage& pixels)
{
    if (!finite(corner) || pixels.width == 0 || pixels.values.empty()) return;
    svg_ += "<image class=\"pixels\" preserveAspectRatio=\"none\"" + attribute("x", corner.x) +
            attribute("y", corner.y) + attribute("width", width) + attribute("height", height) +
            " href=\"" + pngData(pixels) + "\"/>";
}

std::string Drawing::element(double width, double height, std::string_view title) const
{
    return "<svg viewBox=\"0 0 " + coordinate(width) + ' ' + coordinate(height) + "\" width=\"" +
           coordinate(width) + "\" height=\"" + coordinate(height) +
           "\" role=\"img\" aria-label=\"" + escapeMarkup(title) + "\">" + svg_ + "</svg>\n";
}

// --- plot

Plot::Plot(std::string title, Axis x, Axis y, double width, double height)
    : title_(std::move(title)), x_(std::move(x)), y_(std::move(y)), width_(width), height_(height)
{
    double labels = 0;
    for (const Tick& tick : y_.ticks) labels = std::max(labels, textWidth(tick.label));
    left_ = labels + 9 + (y_.label.empty() ? 0 : 1.6 * kFontSize);
    right_ = x_.ticks.empty() ? 6 : std::max(6.0, textWidth(x_.ticks.back().label) / 2 + 2);
    top_ = 0.8 * kFontSize;
    bottom_ = 1.7 * kFontSize + (x_.label.empty() ? 0 : 1.5 * kFontSize);
}

Point Plot::place(Point p) const
{
    return {left_ + x_.at(p.x) * (width_ - left_ - right_),
            height_ - bottom_ - y_.at(p.y) * (height_ - top_ - bottom_)};
}

std::vector<Point> Plot::place(const std::vector<Point>& points) const
{
    std::vector<Point> placed;
    for (const Point& p : points) placed.push_back(place(p));
    return placed;
}

void Plot::curve(const std::vector<Point>& points, const std::string& style)
{
    inside_.polyline(place(points), "curve " + style);
}

void Plot::markers(const std::vector<Point>& points, Shape shape, const std::string& style)
{
    for (const Point& p : place(points))
        if (finite(p)) above_.marker(p, shape, style);
}

void Plot::errorBars(const std::vector<Point>& points, const std::vector<double>& errors,
                     const std::string& style)
{
    for (size_t i = 0; i < points.size() && i < errors.size(); ++i) {
        if (!finite(points[i]) || !(errors[i] > 0)) continue;
        // A bar that leaves a logarithmic axis downwards ends at the axis.
        const double bottom = points[i].y - errors[i];
        const Point low = place({points[i].x, y_.log && bottom <= 0 ? y_.low : bottom});
        const Point high = place({points[i].x, points[i].y + errors[i]});
        if (low.y - high.y < 1) continue;  // hidden by its marker
        inside_.polyline({low, high}, "bar " + style);
        inside_.polyline({{low.x - 2.5, low.y}, {low.x + 2.5, low.y}}, "bar " + style);
        inside_.polyline({{high.x - 2.5, high.y}, {high.x + 2.5, high.y}}, "bar " + style);
    }
}

void Plot::band(const std::vector<Point>& lower, const std::vector<Point>& upper,
                const std::string& style)
{
    std::vector<Point> outline;
    for (const Point& p : place(lower))
        if (finite(p)) outline.push_back(p);
    const std::vector<Point> back = place(upper);
    for (auto p = back.rbegin(); p != back.rend(); ++p)
        if (finite(*p)) outline.push_back(*p);
    inside_.polygon(outline, "band " + style);
}

void Plot::bars(const std::vector<Point>& tops, double width, double baseline,
                const std::string& style)
{
    for (const Point& top : tops) {
        const Point a = place({top.x - width / 2, top.y}), b = place({top.x + width / 2, baseline});
        inside_.rectangle(a, b.x - a.x, b.y - a.y, "block " + style);
    }
}

void Plot::vertical(double x, const std::string& label, const std::string& style)
{
    const Point low = place({x, y_.low}), high = place({x, y_.high});
    inside_.line(low, high, "rule " + style);
    above_.text({high.x + 4, high.y + kFontSize}, label, "note");
}

void Plot::horizontal(double y, const std::string& label, const std::string& style)
{
    const Point start = place({x_.low, y}), end = place({x_.high, y});
    inside_.line(start, end, "rule " + style);
    above_.text({end.x - 4, end.y - 4}, label, "note", Anchor::end);
}

void Plot::note(Point at, const std::string& text, Anchor anchor)
{
    above_.text(place(at), text, "note", anchor);
}

void Plot::drawAxes(Drawing& drawing) const
{
    const Point corner = place({x_.low, y_.high}), origin = place({x_.low, y_.low}),
                end = place({x_.high, y_.low});
    for (const Tick& tick : y_.ticks) {
        const Point p = place({x_.low, tick.value});
        drawing.line(p, {end.x, p.y}, "grid");
        drawing.text({p.x - 5, p.y + 0.35 * kFontSize}, tick.label, "tick", Anchor::end);
    }
    for (const Tick& tick : x_.ticks) {
        const Point p = place({tick.value, y_.low});
        drawing.line(p, {p.x, p.y + 4}, "axis");
        drawing.text({p.x, p.y + 4 + kFontSize}, tick.label, "tick", Anchor::middle);
    }
    drawing.polyline({corner, origin, end}, "axis");
    drawing.text({(origin.x + end.x) / 2, height_ - 4}, x_.label, "label", Anchor::middle);
    drawing.text({0.9 * kFontSize, (origin.y + corner.y) / 2}, y_.label, "label", Anchor::middle,
                 -90);
}

/// The title, and below it the entries side by side, as many in a row as fit. Returns the height
/// taken.
double Plot::drawHead(Drawing& drawing) const
{
    const double title = title_.empty() ? 0 : 1.5 * kFontSize;
    drawing.text({0, 1.1 * kFontSize}, title_, "heading");
    constexpr double kRow = 1.5 * kFontSize, kSample = 20;
    double x = 0, y = title + kRow;
    for (const LegendEntry& entry : legend_) {
        const double needed = kSample + 5 + textWidth(entry.label) + 16;
        if (x > 0 && x + needed > width_) {
            x = 0;
            y += kRow;
        }
        const double middle = y - 0.35 * kFontSize;
        if (entry.band) drawing.rectangle({x, middle - 5}, kSample, 10, "band " + entry.style);
        if (entry.line) drawing.line({x, middle}, {x + kSample, middle}, "curve " + entry.style);
        if (entry.marker) drawing.marker({x + kSample / 2, middle}, entry.shape, entry.style);
        drawing.text({x + kSample + 5, y}, entry.label, "key");
        x += needed;
    }
    return legend_.empty() ? title : y + 0.5 * kFontSize;
}

std::string Plot::element() const
{
    Drawing whole;
    const double head = drawHead(whole);
    Drawing frame;
    drawAxes(frame);
    const Point corner = place({x_.low, y_.high}), end = place({x_.high, y_.low});
    // An inner svg clips what is in it; a margin keeps the ends of thick lines whole.
    constexpr double kMargin = 1.5;
    const double width = end.x - corner.x + 2 * kMargin, height = end.y - corner.y + 2 * kMargin;
    const double x = corner.x - kMargin, y = corner.y - kMargin;
    frame.add("<svg" + attribute("x", x) + attribute("y", y) + attribute("width", width) +
              attribute("height", height) + " viewBox=\"" + coordinate(x) + ' ' + coordinate(y) +
              ' ' + coordinate(width) + ' ' + coordinate(height) + "\">" + inside_.content() +
              "</svg>" + above_.content());
    whole.add("<g transform=\"translate(0 " + coordinate(head) + ")\">" + frame.content() + "</g>");
    return whole.element(width_, height_ + head, description_.empty() ? title_ : description_);
}

}  // namespace app::report
