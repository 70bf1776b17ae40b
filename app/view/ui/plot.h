// Plots on Dear ImGui's draw lists: curves over logarithmic axes, and bars of frame times. They
// know nothing of the program.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <imgui.h>

namespace app {

struct PlotPoint {
    double x = 0, y = 0;
    double se = 0;  // standard error of y; 0: none is drawn
};

struct PlotCurve {
    std::string label;
    std::vector<PlotPoint> points;  // x increasing; those not above zero are left out
    ImVec4 colour{1, 1, 1, 1};
    bool bold = false;
};

struct LogPlot {
    std::vector<PlotCurve> curves;
    std::string xLabel, yLabel;
    // 0: no guide; else a line of that slope through the last point of the last curve
    double guideSlope = 0;
    double floor = 0;  // dashed across, with `floorLabel`; 0: none
    std::string floorLabel;
    double target = 0;  // across, with `targetLabel`; 0: none
    std::string targetLabel;
};

/// A step of a logarithmic axis. Minor ones carry no text.
struct LogTick {
    double value = 0;
    bool major = false;
    std::string text;
};

/// The range of a logarithmic axis.
struct LogRange {
    double low = 1, high = 10;
    /// Where a value lies between low (0) and high (1).
    double fraction(double value) const;
    double value(double fraction) const;
};

/// Ticks of 1 to 9 times powers of ten within the range; major ones at powers of ten, or, where
/// fewer than two powers lie within, at 1, 2 and 5 times them. Two are major at least, over a
/// factor of 2.5: where the range is narrow all are, and halves are ticks, too. Over many decades
/// only so many are major that `most` texts have room, from two on.
std::vector<LogTick> logTicks(const LogRange& range, int most);

/// Which colour each curve has, by the number that tells curves apart: it keeps its colour as long
/// as it is drawn, and no two share one.
class CurveColours {
public:
    /// The curves that are drawn now; the others' colours are free again.
    void keep(std::span<const double> curves);
    /// 0, 1, ..., of one that was named to keep().
    size_t of(double curve) const;

private:
    std::vector<std::optional<double>> owners_;
};

/// Which curves the legend names: those with points to draw, the last one (the present) first, then
/// newest first, at most so many.
std::vector<size_t> legendOrder(const LogPlot& plot, size_t most);

/// The ranges that hold every curve, the target and the floor, with a little room and at least a
/// factor of two.
void logRanges(const LogPlot& plot, LogRange& x, LogRange& y);

/// Draws into `size` pixels at the cursor. The mouse over it shows values.
void drawLogPlot(const char* id, const LogPlot& plot, ImVec2 size);

/// Bars of the last frames (seconds, oldest first) with a line at `budget` seconds.
void drawFrameTimes(const char* id, std::span<const float> seconds, double budget, ImVec2 size);

/// The value below which the fraction `p` of the values lies (nearest rank); 0 for none.
double quantile(std::span<const float> values, double p);

}  // namespace app
