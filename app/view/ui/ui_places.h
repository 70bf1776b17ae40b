// Where the hand has put the windows over the picture. A place is kept as it was given, relative to
// the corner of the picture that the window belongs to; what a small window or a narrow picture
// make of it counts for showing alone.
#pragma once

#include <map>
#include <string>

#include "app/session/window_layout.h"

namespace app {

class WindowPlaces {
public:
    /// A window's own corner from that of the picture, and its size, in pixels.
    struct Place {
        glm::vec2 offset{0}, size{0};
        friend bool operator==(const Place&, const Place&) = default;
    };

    /// Where the window is to stand now: where the hand has put it or, if it has not, at `usual`
    /// size in the corner `corner` (each coordinate 0 or 1, or between) of the picture, `gap` away
    /// from its edges; in any case inside `window`.
    Area placeOf(const std::string& name, const Area& picture, glm::vec2 window, glm::vec2 usual,
                 glm::vec2 corner, float gap);

    /// What Dear ImGui made of the place that placeOf() gave before: if it is another, the hand has
    /// moved the window or changed its size.
    void seen(const std::string& name, const Area& window, const Area& picture, glm::vec2 corner);

    /// As lines of text, if the hand has given a place since the last call; else empty.
    std::string changes();

    /// What changes() wrote in another run. What cannot be read is left out.
    void read(const std::string& text);

private:
    std::map<std::string, Place> given_;
    std::map<std::string, Area> shown_;  // where placeOf() has put them
    bool changed_ = false;
};

}  // namespace app
