// Plots as inline SVG: axes with round ticks, curves, markers, error bars, bands, a legend that
// takes the room it needs. Colours come from the classes of the page's style sheet, so that one
// drawing serves light, dark and paper. Points that are not finite are left out.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "app/report/pixels.h"

namespace app::report {

struct Point {
    double x = 0, y = 0;
};

struct Tick {
    double value = 0;
    std::string label;
};

/// Width of a text at the size of labels, in pixels; precise enough for margins.
double textWidth(std::string_view text);

/// At least three ticks at multiples of 1, 2 or 5 times a power of ten, about `wanted` of them; the
/// first is not above `low`, the last not below `high`. Any order and any numbers are accepted.
std::vector<Tick> linearTicks(double low, double high, int wanted = 5);

/// The same for a logarithmic axis; bounds that are not positive are corrected.
std::vector<Tick> logTicks(double low, double high);

/// From values to positions in [0, 1].
struct Axis {
    std::string label;
    std::vector<Tick> ticks;
    double low = 0, high = 1;
    bool log = false;

    double at(double value) const;
};

/// Axes from the first to the last of their ticks.
Axis linearAxis(std::string label, double low, double high, int wanted = 5);
Axis logAxis(std::string label, double low, double high);
/// A logarithmic axis with ticks at `values`, a little wider than they are; positive and ascending.
Axis logAxisAt(std::string label, const std::vector<Tick>& ticks);

enum class Anchor { start, middle, end };
enum class Shape { circle, square, diamond, triangle, cross };

/// Elements of one picture in pixels, y downwards.
class Drawing {
public:
    void line(Point a, Point b, std::string_view style);
    /// Broken where a point is not finite.
    void polyline(const std::vector<Point>& points, std::string_view style);
    /// Nothing unless all points are finite.
    void polygon(const std::vector<Point>& points, std::string_view style);
    void rectangle(Point corner, double width, double height, std::string_view style);
    void circle(Point centre, double radius, std::string_view style);
    void marker(Point centre, Shape shape, std::string_view style);
    void text(Point at, std::string_view text, std::string_view style,
              Anchor anchor = Anchor::start, double degrees = 0);
    /// Stretched to the rectangle, its pixels with hard edges.
    void image(Point corner, double width, double height, const GreyImage& pixels);
    /// SVG made elsewhere.
    void add(std::string_view svg) { svg_ += svg; }

    /// The whole as an svg element with `title` as its text for screen readers.
    std::string element(double width, double height, std::string_view title) const;
    const std::string& content() const { return svg_; }

private:
    std::string svg_;
};

/// One entry of a legend: a piece of curve, a marker, or both.
struct LegendEntry {
    std::string label, style;  // style: a colour class
    bool line = true, marker = false, band = false;
    Shape shape = Shape::circle;
};

/// A frame with two axes; what is put in it is clipped to it.
class Plot {
public:
    /// `width` and `height` of the frame with its labels, in pixels; title and legend come on top.
    Plot(std::string title, Axis x, Axis y, double width, double height);

    /// `style` is a colour class throughout, with more classes if need be.
    void curve(const std::vector<Point>& points, const std::string& style);
    void markers(const std::vector<Point>& points, Shape shape, const std::string& style);
    /// From y - error to y + error, with caps.
    void errorBars(const std::vector<Point>& points, const std::vector<double>& errors,
                   const std::string& style);
    /// Between two curves with the same x.
    void band(const std::vector<Point>& lower, const std::vector<Point>& upper,
              const std::string& style);
    /// Bars from `baseline`, `width` wide in x.
    void bars(const std::vector<Point>& tops, double width, double baseline,
              const std::string& style);
    void vertical(double x, const std::string& label, const std::string& style);
    void horizontal(double y, const std::string& label, const std::string& style);
    /// A few words at a place of the plot.
    void note(Point at, const std::string& text, Anchor anchor = Anchor::start);
    /// What the picture shows, for screen readers; the title when not given.
    void describe(std::string text) { description_ = std::move(text); }
    void legend(LegendEntry entry) { legend_.push_back(std::move(entry)); }

    std::string element() const;

private:
    Point place(Point p) const;
    std::vector<Point> place(const std::vector<Point>& points) const;
    void drawAxes(Drawing& drawing) const;
    double drawHead(Drawing& drawing) const;

    std::string title_, description_;
    Axis x_, y_;
    double width_, height_, left_ = 0, right_ = 0, top_ = 0, bottom_ = 0;  // of the frame
    Drawing inside_;
    Drawing above_;  // not clipped
    std::vector<LegendEntry> legend_;
};

}  // namespace app::report
