// Plots on Dear ImGui's draw lists. See plot.h.
#include "app/view/ui/plot.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "app/report/text.h"
#include "app/view/ui/ui_text.h"

namespace app {
namespace {

bool usable(const PlotPoint& p)
{
    return p.x > 0 && p.y > 0 && std::isfinite(p.x) && std::isfinite(p.y);
}

/// The plot's place on the screen and its axes.
struct PlotFrame {
    ImVec2 low, high;  // corners: left top, right bottom
    LogRange x, y;
    ImVec2 place(double px, double py) const
    {
        return {low.x + static_cast<float>(x.fraction(px)) * (high.x - low.x),
                high.y - static_cast<float>(y.fraction(py)) * (high.y - low.y)};
    }
};

float legendLine()
{
    return 1.15f * ImGui::GetFontSize();
}

void growRange(LogRange& range, double value, bool& any)
{
    if (!(value > 0) || !std::isfinite(value)) return;
    range.low = any ? std::min(range.low, value) : value;
    range.high = any ? std::max(range.high, value) : value;
    any = true;
}

void addRoom(LogRange& range, bool any)
{
    if (!any) range = {0.1, 10};
    const double middle = std::sqrt(range.low) * std::sqrt(range.high);
    const double half = std::max(std::sqrt(range.high / range.low), std::sqrt(2.0)) * 1.12;
    range = {middle / half, middle * half};
}

void dashed(ImDrawList& list, ImVec2 a, ImVec2 b, ImU32 colour, float dash)
{
    const float length = b.x - a.x;
    for (float s = 0; s < length; s += 2 * dash) {
        const float e = std::min(s + dash, length);
        const auto at = [&](float d) { return ImVec2(a.x + d, a.y + (b.y - a.y) * d / length); };
        list.AddLine(at(s), at(e), colour, 1);
    }
}

void drawGrid(ImDrawList& list, const PlotFrame& f)
{
    const ImU32 strong = ImGui::GetColorU32(ImGuiCol_Text, 0.16f),
                weak = ImGui::GetColorU32(ImGuiCol_Text, 0.06f);
    const ImU32 text = ImGui::GetColorU32(ImGuiCol_TextDisabled);
    const float letter = ImGui::GetFontSize();
    const auto most = [&](float length, float room) {
        return std::max(2, static_cast<int>(length / room));
    };
    for (const LogTick& tick : logTicks(f.x, most(f.high.x - f.low.x, 4 * letter))) {
        const float x = f.place(tick.value, f.y.low).x;
        list.AddLine({x, f.low.y}, {x, f.high.y}, tick.major ? strong : weak);
        if (!tick.major) continue;
        const float half = ImGui::CalcTextSize(tick.text.c_str()).x / 2;
        const float left = std::clamp(x - half, f.low.x, std::max(f.low.x, f.high.x - 2 * half));
        list.AddText({left, f.high.y + letter * 0.2f}, text, tick.text.c_str());
    }
    for (const LogTick& tick : logTicks(f.y, most(f.high.y - f.low.y, 2 * letter))) {
        const float y = f.place(f.x.low, tick.value).y;
        list.AddLine({f.low.x, y}, {f.high.x, y}, tick.major ? strong : weak);
        if (!tick.major) continue;
        const ImVec2 size = ImGui::CalcTextSize(tick.text.c_str());
        list.AddText({f.low.x - size.x - letter * 0.4f, y - size.y / 2}, text, tick.text.c_str());
    }
}

void drawCurve(ImDrawList& list, const PlotFrame& f, const PlotCurve& curve)
{
    const ImU32 colour = ImGui::GetColorU32(curve.colour);
    std::vector<ImVec2> line;
    for (const PlotPoint& p : curve.points) {
        if (!usable(p)) continue;
        line.push_back(f.place(p.x, p.y));
        if (p.se > 0) {
            const float top = f.place(p.x, p.y + p.se).y;
            const float bottom = f.place(p.x, std::max(p.y - p.se, f.y.low)).y;
            list.AddLine({line.back().x, top}, {line.back().x, bottom},
                         ImGui::GetColorU32(curve.colour), 1);
        }
    }
    if (line.empty()) return;
    list.AddPolyline(line.data(), static_cast<int>(line.size()), colour, 0,
                     curve.bold ? 2.0f : 1.2f);
    if (curve.bold) list.AddCircleFilled(line.back(), 3.0f, colour);
}

/// A line of the guide's slope through the last point there is, from edge to edge.
void drawGuide(ImDrawList& list, const PlotFrame& f, const LogPlot& plot)
{
    if (plot.guideSlope == 0 || plot.curves.empty()) return;
    const PlotCurve& curve = plot.curves.back();
    const auto last = std::find_if(curve.points.rbegin(), curve.points.rend(), usable);
    if (last == curve.points.rend()) return;
    const auto at = [&](double x) {
        return f.place(x, last->y * std::pow(x / last->x, plot.guideSlope));
    };
    dashed(list, at(f.x.low), at(f.x.high), ImGui::GetColorU32(ImGuiCol_TextDisabled), 3);
}

bool levelIsSeen(const PlotFrame& f, double value)
{
    return value > 0 && value >= f.y.low && value <= f.y.high;
}

void drawLevel(ImDrawList& list, const PlotFrame& f, double value, ImU32 colour, bool dashes)
{
    if (!levelIsSeen(f, value)) return;
    const float y = f.place(f.x.low, value).y;
    if (dashes)
        dashed(list, {f.low.x, y}, {f.high.x, y}, colour, 5);
    else
        list.AddLine({f.low.x, y}, {f.high.x, y}, colour, 1);
}

/// What a level is, at its right end, above the line or below it where there is no room; on a
/// ground of its own, for curves run there. True when the mouse is at a text that had to be
/// shortened: its tool-tip is the whole.
bool drawLevelText(ImDrawList& list, const PlotFrame& f, double value, const std::string& label,
                   ImU32 colour)
{
    if (label.empty() || !levelIsSeen(f, value)) return false;
    const float y = f.place(f.x.low, value).y, letter = ImGui::GetFontSize();
    const std::string text = shortenedLabel(label, f.high.x - f.low.x - letter * 0.6f);
    const float width = ImGui::CalcTextSize(text.c_str()).x;
    const float top = y - letter * 1.2f > f.low.y ? y - letter * 1.2f : y + letter * 0.2f;
    const ImVec2 corner(std::max(f.low.x + 2, f.high.x - width - letter * 0.3f), top);
    const ImVec2 end(corner.x + width, corner.y + letter);
    list.AddRectFilled({corner.x - 2, corner.y}, {end.x + 2, end.y},
                       ImGui::GetColorU32(ImGuiCol_WindowBg, 0.9f), 2);
    list.AddText(corner, colour, text.c_str());
    return text != label && ImGui::IsMouseHoveringRect(corner, end);
}

/// The curves that the legend has room for below the axes: it takes at most a third of the height.
std::vector<size_t> legendRows(const LogPlot& plot, float height)
{
    const float rows = std::clamp(height / 3 / legendLine(), 0.0f, 5.0f);
    return legendOrder(plot, static_cast<size_t>(rows));
}

/// Below the axes, where no curve runs. Returns the curve under the mouse whose name had to be
/// shortened, or null.
const PlotCurve* drawLegend(ImDrawList& list, const PlotFrame& f, const LogPlot& plot,
                            ImVec2 corner, const std::vector<size_t>& rows)
{
    const float letter = ImGui::GetFontSize(), dash = 1.6f * letter, gap = 0.4f * letter;
    const PlotCurve* cut = nullptr;
    float y = corner.y;
    for (const size_t index : rows) {
        const PlotCurve& curve = plot.curves[index];
        const float left = corner.x + dash + gap;
        const std::string label = shortenedLabel(curve.label, f.high.x - left);
        list.AddLine({corner.x, y + 0.5f * letter}, {corner.x + dash, y + 0.5f * letter},
                     ImGui::GetColorU32(curve.colour), curve.bold ? 2.0f : 1.2f);
        list.AddText({left, y}, ImGui::GetColorU32(ImGuiCol_Text), label.c_str());
        if (label != curve.label &&
            ImGui::IsMouseHoveringRect({corner.x, y}, {f.high.x, y + legendLine()}))
            cut = &curve;
        y += legendLine();
    }
    return cut;
}

/// The point nearest to the mouse in x, of the curve nearest in y.
void drawCursor(ImDrawList& list, const PlotFrame& f, const LogPlot& plot)
{
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    const PlotPoint* best = nullptr;
    const PlotCurve* owner = nullptr;
    float nearest = INFINITY;
    for (const PlotCurve& curve : plot.curves) {
        for (const PlotPoint& p : curve.points) {
            if (!usable(p)) continue;
            const ImVec2 at = f.place(p.x, p.y);
            const float distance = std::hypot(at.x - mouse.x, 0.4f * (at.y - mouse.y));
            if (distance >= nearest) continue;
            nearest = distance;
            best = &p;
            owner = &curve;
        }
    }
    if (best == nullptr) return;
    const ImVec2 at = f.place(best->x, best->y);
    list.AddLine({at.x, f.low.y}, {at.x, f.high.y}, ImGui::GetColorU32(ImGuiCol_Text, 0.25f));
    list.AddCircle(at, 4, ImGui::GetColorU32(ImGuiCol_Text), 12, 1.5f);
    ImGui::SetTooltip("%s\n%s: %s\n%s: %s", owner->label.c_str(), plot.xLabel.c_str(),
                      digitsText(best->x).c_str(), plot.yLabel.c_str(),
                      report::measured(best->y, best->se).c_str());
}

/// Which ticks carry a text: powers of ten; where those are fewer than two, also 2 and 5 times
/// them; where even those are, all.
void chooseMajor(std::vector<LogTick>& ticks, int most)
{
    const auto count = [&] { return std::ranges::count(ticks, true, &LogTick::major); };
    const auto decadeOf = [](const LogTick& tick) {
        return static_cast<int>(std::floor(std::log10(tick.value) + 1e-9));
    };
    const auto choose = [&](std::initializer_list<double> leading) {
        for (LogTick& tick : ticks) {
            const double lead = tick.value / std::pow(10.0, decadeOf(tick));
            tick.major =
                std::ranges::any_of(leading, [&](double l) { return std::abs(lead - l) < 1e-6; });
        }
        return count() >= 2;
    };
    if (!choose({1}) && !choose({1, 2, 5}))
        for (LogTick& tick : ticks) tick.major = true;
    // Every so manieth, counted from the lowest one: two are left at least.
    const auto all = static_cast<int>(count());
    const int every = std::max(1, (all + most - 1) / std::max(most, 1));
    int index = 0;
    for (LogTick& tick : ticks)
        if (tick.major) tick.major = index++ % every == 0;
}

/// Everything within the axes. Returns the text under the mouse that had to be shortened, or null.
const std::string* drawCurves(ImDrawList& list, const PlotFrame& f, const LogPlot& plot)
{
    const ImU32 dim = ImGui::GetColorU32(ImGuiCol_TextDisabled);
    const ImU32 strong = ImGui::GetColorU32(ImVec4(0.98f, 0.75f, 0.33f, 1));
    list.PushClipRect(f.low, f.high, true);
    drawGuide(list, f, plot);
    drawLevel(list, f, plot.floor, dim, true);
    for (const PlotCurve& curve : plot.curves) drawCurve(list, f, curve);
    drawLevel(list, f, plot.target, strong, false);
    const bool atFloor = drawLevelText(list, f, plot.floor, plot.floorLabel, dim);
    const bool atTarget = drawLevelText(list, f, plot.target, plot.targetLabel, strong);
    list.PopClipRect();
    return atTarget ? &plot.targetLabel : atFloor ? &plot.floorLabel : nullptr;
}

}  // namespace

void CurveColours::keep(std::span<const double> curves)
{
    for (std::optional<double>& owner : owners_)
        if (owner && std::ranges::find(curves, *owner) == curves.end()) owner.reset();
    for (const double curve : curves) {
        if (std::ranges::find(owners_, std::optional(curve)) != owners_.end()) continue;
        const auto free = std::ranges::find(owners_, std::optional<double>());
        if (free != owners_.end())
            *free = curve;
        else
            owners_.emplace_back(curve);
    }
}

size_t CurveColours::of(double curve) const
{
    return static_cast<size_t>(std::ranges::find(owners_, std::optional(curve)) - owners_.begin());
}

std::vector<size_t> legendOrder(const LogPlot& plot, size_t most)
{
    std::vector<size_t> order;
    for (size_t i = plot.curves.size(); i-- > 0 && order.size() < most;)
        if (std::ranges::any_of(plot.curves[i].points, usable)) order.push_back(i);
    return order;
}

double LogRange::fraction(double value) const
{
    return std::log(value / low) / std::log(high / low);
}
double LogRange::value(double fraction) const
{
    return low * std::pow(high / low, fraction);
}

std::vector<LogTick> logTicks(const LogRange& range, int most)
{
    const int first = static_cast<int>(std::floor(std::log10(range.low)));
    const int last = static_cast<int>(std::ceil(std::log10(range.high)));
    std::vector<LogTick> ticks;
    // Halves, too, where whole multiples of a power would be a single one: from 1.1 to 2.8.
    for (const int step : {2, 1}) {
        ticks.clear();
        for (int decade = first; decade <= last; ++decade) {
            for (int half = 2; half < 20; half += step) {
                const double value = 0.5 * half * std::pow(10.0, decade);
                if (value >= range.low && value <= range.high) ticks.push_back({value, false, {}});
            }
        }
        if (ticks.size() >= 2) break;
    }
    chooseMajor(ticks, most);
    for (LogTick& tick : ticks)
        if (tick.major) tick.text = format("%g", tick.value);
    return ticks;
}

void logRanges(const LogPlot& plot, LogRange& x, LogRange& y)
{
    bool anyX = false, anyY = false;
    for (const PlotCurve& curve : plot.curves) {
        for (const PlotPoint& p : curve.points) {
            if (!usable(p)) continue;
            growRange(x, p.x, anyX);
            growRange(y, p.y, anyY);
        }
    }
    growRange(y, plot.floor, anyY);
    growRange(y, plot.target, anyY);
    addRoom(x, anyX);
    addRoom(y, anyY);
}

void drawLogPlot(const char* id, const LogPlot& plot, ImVec2 size)
{
    const float letter = ImGui::GetFontSize();
    size = {std::max(size.x, 8 * letter), std::max(size.y, 6 * letter)};
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    ImGui::InvisibleButton(id, size);
    const bool hovered = ImGui::IsItemHovered();
    PlotFrame f;
    logRanges(plot, f.x, f.y);
    const std::vector<size_t> rows = legendRows(plot, size.y);
    const float below = rows.empty() ? 0 : legendLine() * static_cast<float>(rows.size()) + 4;
    f.low = {corner.x + 4.2f * letter, corner.y + letter * 1.3f};
    f.high = {corner.x + size.x - letter * 0.4f, corner.y + size.y - letter * 1.4f - below};
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.AddText(corner, ImGui::GetColorU32(ImGuiCol_TextDisabled), plot.yLabel.c_str());
    const ImVec2 unit = ImGui::CalcTextSize(plot.xLabel.c_str());
    list.AddText({f.high.x - unit.x, corner.y}, ImGui::GetColorU32(ImGuiCol_TextDisabled),
                 plot.xLabel.c_str());
    drawGrid(list, f);
    const PlotCurve* cut =
        drawLegend(list, f, plot, {corner.x, corner.y + size.y - below + 4}, rows);
    const std::string* said = drawCurves(list, f, plot);
    if (!hovered) return;
    if (said != nullptr || cut != nullptr)
        ImGui::SetTooltip("%s", said != nullptr ? said->c_str() : cut->label.c_str());
    else
        drawCursor(list, f, plot);
}

void drawFrameTimes(const char* id, std::span<const float> seconds, double budget, ImVec2 size)
{
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    size = {std::max(size.x, 8.0f), std::max(size.y, 8.0f)};
    ImGui::InvisibleButton(id, size);
    const bool hovered = ImGui::IsItemHovered();
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.AddRectFilled(corner, {corner.x + size.x, corner.y + size.y},
                       ImGui::GetColorU32(ImGuiCol_FrameBg), ImGui::GetStyle().FrameRounding);
    const size_t shown = std::min(seconds.size(), static_cast<size_t>(size.x / 2));
    const std::span<const float> last = seconds.last(shown);
    const double top = std::max(
        2 * budget,
        last.empty() ? 0.0 : static_cast<double>(*std::max_element(last.begin(), last.end())));
    if (!(top > 0) || !std::isfinite(top)) return;
    const auto height = [&](double s) {
        return static_cast<float>(std::clamp(s / top, 0.0, 1.0)) * (size.y - 2);
    };
    for (size_t i = 0; i < shown; ++i) {
        const float x = corner.x + size.x - 2.0f * static_cast<float>(shown - i);
        const double s = static_cast<double>(last[i]);
        const ImU32 colour =
            ImGui::GetColorU32(s > 2 * budget ? ImVec4(0.98f, 0.75f, 0.33f, 1)
                                              : ImGui::GetStyleColorVec4(ImGuiCol_PlotHistogram));
        list.AddRectFilled({x, corner.y + size.y - height(s)}, {x + 1, corner.y + size.y}, colour);
    }
    const float line = corner.y + size.y - height(budget);
    list.AddLine({corner.x, line}, {corner.x + size.x, line},
                 ImGui::GetColorU32(ImGuiCol_Text, 0.3f));
    if (!hovered) return;
    const auto under = static_cast<ptrdiff_t>((corner.x + size.x - ImGui::GetIO().MousePos.x) / 2);
    const ptrdiff_t index = static_cast<ptrdiff_t>(shown) - 1 - under;
    if (index >= 0 && index < static_cast<ptrdiff_t>(shown)) {
        ImGui::SetTooltip(
            "%s", secondsText(static_cast<double>(last[static_cast<size_t>(index)])).c_str());
    }
}

double quantile(std::span<const float> values, double p)
{
    if (values.empty()) return 0;
    std::vector<float> sorted(values.begin(), values.end());
    const double rank = std::ceil(std::clamp(p, 0.0, 1.0) * static_cast<double>(sorted.size()));
    const auto index = static_cast<ptrdiff_t>(std::max(rank, 1.0)) - 1;
    std::nth_element(sorted.begin(), sorted.begin() + index, sorted.end());
    return static_cast<double>(sorted[static_cast<size_t>(index)]);
}

}  // namespace app
