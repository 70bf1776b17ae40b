// Where things stand in the window: the picture has what the panel and the line of status leave, so
// that nothing is rendered which cannot be seen. Nothing but numbers in it.
#pragma once

#include <glm/glm.hpp>

#include "app/pictures/view_params.h"
#include "core/scene/camera.h"

namespace app {

/// A rectangle of the window, in the units of the mouse: x to the right, y down.
struct Area {
    glm::vec2 corner{0}, size{0};

    glm::vec2 end() const { return corner + size; }
    bool empty() const { return size.x <= 0 || size.y <= 0; }
    bool contains(glm::vec2 point) const;
    /// [0,1]^2 inside; beyond it outside. Zero in an empty area.
    glm::dvec2 fraction(glm::vec2 point) const;

    friend bool operator==(const Area&, const Area&) = default;
};

/// Whole units. Areas that are not there are empty; the picture has at least one unit.
struct WindowLayout {
    glm::vec2 window{0};
    float letter = 0;  // height of one
    Area picture, panel, status;

    friend bool operator==(const WindowLayout&, const WindowLayout&) = default;
};

/// `letter`: the height of a letter. A window with room for hardly a letter shows the picture
/// alone; a narrow one begins with a folded panel.
WindowLayout layOut(glm::vec2 window, float letter, const PanelParams& panels);

/// Whether anything but the picture has room in the window.
bool hasRoomForText(glm::vec2 window, float letter);

/// The size of a window in which a question can be read, whole units.
glm::uvec2 roomForQuestion(float letter);

/// The width of a panel, in letters, whose inner edge is at `x`.
float panelWidthAt(float x, float window, float letter, PanelSide side);

/// Where a bar that wants `size` stands in `area`, `gap` from its edges, so that it does not lie
/// under `taken` (which may be empty): at the lower left, narrower down to `least` beside it, else
/// at the lower right, else above it; at the lower left all the same where nothing else is left.
Area placeBar(const Area& area, glm::vec2 size, float least, const Area& taken, float gap);

/// Where a picture stands in an area of another shape, in fractions of the area: whole and in the
/// middle. The whole area when the shapes differ by no more than a pixel.
Area whole(glm::uvec2 picture, glm::vec2 area);

/// The same for a picture that was made for another area, of which this one shows a narrower or a
/// wider view: what is in both is where it will be in the next picture. `of` made the picture,
/// `next` makes the next one.
Area kept(glm::uvec2 picture, const core::Camera& of, glm::vec2 area, const core::Camera& next);

}  // namespace app
