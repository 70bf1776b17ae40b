// A map: a matrix of coloured cells, each with a number or a sign in it, so that nothing rests on
// colour alone; more about a cell is in its tooltip.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace app::report {

struct MapCell {
    std::string text;       // a few letters
    std::string style;      // classes of the cell: "fill c-blue", "b2", "none"
    std::string textStyle;  // more classes of its text
    std::string title;      // in the tooltip
};

/// What stands over a column: a code and a name below it, or beside it where heads are slanted.
struct MapHead {
    std::string code, name;
};

struct Map {
    std::string title;
    std::vector<std::string> rows;
    std::vector<MapHead> columns;
    double cellWidth = 50, cellHeight = 21;
    bool slanted = false;  // heads: for cells that are narrower than names
    std::function<MapCell(size_t row, size_t column)> cell;
};

/// An svg element; takes the room that its labels need.
std::string mapElement(const Map& map);

/// The style of a cell by a ratio of variances, a / b: blue where a is smaller, orange where it is
/// larger, in three steps; 1.02 and less is no difference.
std::string ratioStyle(double ratio);

}  // namespace app::report
