// See map.h.
#include "app/report/map.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/report/svg.h"
#include "app/report/text.h"

namespace app::report {

namespace {

constexpr double kSlant = std::numbers::pi / 4;
constexpr double kLine = 12, kTitle = 20, kGap = 6;

std::string joined(const MapHead& head)
{
    return head.code + (head.code.empty() || head.name.empty() ? "" : " ") + head.name;
}

double longestHead(const Map& map)
{
    double longest = 0;
    for (const MapHead& head : map.columns) longest = std::max(longest, textWidth(joined(head)));
    return longest;
}

bool hasNames(const Map& map)
{
    return std::any_of(map.columns.begin(), map.columns.end(),
                       [](const MapHead& head) { return !head.name.empty(); });
}

void drawHead(Drawing& drawing, const Map& map, const MapHead& head, Point bottom)
{
    if (map.slanted) {
        drawing.text({bottom.x + 4, bottom.y}, joined(head), "label maphead", Anchor::start, -45);
        return;
    }
    const double up = hasNames(map) ? kLine : 0;
    drawing.text({bottom.x, bottom.y - up}, head.code, "label maphead", Anchor::middle);
    drawing.text({bottom.x, bottom.y}, head.name, "heattext mapname", Anchor::middle);
}

void drawCell(Drawing& drawing, const Map& map, const MapCell& cell, Point corner)
{
    drawing.add("<g><title>" + escapeMarkup(cell.title) + "</title>");
    drawing.rectangle(corner, map.cellWidth, map.cellHeight, "heat " + cell.style);
    drawing.text({corner.x + map.cellWidth / 2, corner.y + map.cellHeight / 2 + 4}, cell.text,
                 "heattext " + cell.textStyle, Anchor::middle);
    drawing.add("</g>");
}

}  // namespace

std::string mapElement(const Map& map)
{
    double left = 0;
    for (const std::string& row : map.rows) left = std::max(left, textWidth(row) + kGap);
    // Slanted text rises to the right of its column and leaves the map behind the last.
    const double slant = map.slanted ? (longestHead(map) + 8) * std::sin(kSlant) : 0;
    const double heads = map.slanted ? slant : hasNames(map) ? 2 * kLine : kLine;
    const double top = (map.title.empty() ? 0 : kTitle) + heads + kGap;
    Drawing drawing;
    drawing.text({0, 13}, map.title, "heading");
    for (size_t c = 0; c < map.columns.size(); ++c)
        drawHead(drawing, map, map.columns[c],
                 {left + map.cellWidth * (static_cast<double>(c) + 0.5), top - kGap});
    for (size_t r = 0; r < map.rows.size(); ++r) {
        const double y = top + map.cellHeight * static_cast<double>(r);
        drawing.text({left - kGap, y + map.cellHeight / 2 + 4}, map.rows[r], "label maprow",
                     Anchor::end);
        for (size_t c = 0; c < map.columns.size(); ++c)
            drawCell(drawing, map, map.cell(r, c),
                     {left + map.cellWidth * static_cast<double>(c), y});
    }
    const double width = left + map.cellWidth * static_cast<double>(map.columns.size()) + 2;
    return drawing.element(
        std::max(width + std::max(0.0, slant - map.cellWidth / 2), textWidth(map.title) * 1.1),
        top + map.cellHeight * static_cast<double>(map.rows.size()) + 2, map.title);
}

std::string ratioStyle(double ratio)
{
    const double size = std::abs(std::log(ratio));
    if (!(size > std::log(1.02))) return "none";
    const char* strength = size > std::log(3) ? "3" : size > std::log(1.4) ? "2" : "1";
    return std::string(ratio < 1 ? "b" : "w") + strength;
}

}  // namespace app::report
