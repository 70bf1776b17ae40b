// See window_layout.h.
#include "app/session/window_layout.h"

#include <algorithm>
#include <cmath>

namespace app {

namespace {

// In letters.
const glm::vec2 kLeastWindow{14, 8};  // a smaller one shows the picture alone
const glm::vec2 kQuestion{40, 20};    // the box before quitting and what stands around it
constexpr float kNarrow = 32;         // a narrower one has its panel folded, unless it is told
constexpr float kLeastPanel = 14, kUsualPanel = 25, kLeastPicture = 8;
constexpr float kStatus = 2;
constexpr float kUsualShare = 0.38f;  // of the window, at most

float panelWidth(float window, float letter, const PanelParams& panels)
{
    const float most = std::max(window - kLeastPicture * letter, letter);
    const float least = std::min(kLeastPanel * letter, most);
    const float usual = std::clamp(kUsualShare * window, least,
                                   std::max(least, std::min(kUsualPanel * letter, most)));
    return std::round(panels.width > 0 ? std::clamp(panels.width * letter, least, most) : usual);
}

double halfHeight(const core::Camera& camera)
{
    return camera.orthographic ? camera.ymag : std::tan(0.5 * camera.yfov);
}

}  // namespace

bool Area::contains(glm::vec2 point) const
{
    return point.x >= corner.x && point.y >= corner.y && point.x < end().x && point.y < end().y;
}

glm::dvec2 Area::fraction(glm::vec2 point) const
{
    return empty() ? glm::dvec2(0) : glm::dvec2(point - corner) / glm::dvec2(size);
}

bool hasRoomForText(glm::vec2 window, float letter)
{
    return letter > 0 && window.x >= kLeastWindow.x * letter && window.y >= kLeastWindow.y * letter;
}

glm::uvec2 roomForQuestion(float letter)
{
    return glm::ceil(kQuestion * letter);
}

WindowLayout layOut(glm::vec2 window, float letter, const PanelParams& panels)
{
    WindowLayout layout;
    layout.window = window = glm::max(glm::floor(window), glm::vec2(1));
    layout.picture = {{0, 0}, window};
    layout.letter = letter;
    if (!panels.panel || !hasRoomForText(window, letter)) return layout;
    const bool open = panels.fold == PanelFold::automatic ? window.x >= kNarrow * letter
                                                          : panels.fold == PanelFold::open;
    const float width = open ? panelWidth(window.x, letter, panels) : 0;
    const bool left = panels.side == PanelSide::left;
    const float status = std::round(kStatus * letter);
    layout.picture = {{left ? width : 0, 0}, {window.x - width, window.y - status}};
    layout.status = {{layout.picture.corner.x, window.y - status}, {window.x - width, status}};
    if (open) layout.panel = {{left ? 0 : window.x - width, 0}, {width, window.y}};
    return layout;
}

float panelWidthAt(float x, float window, float letter, PanelSide side)
{
    const float width = side == PanelSide::left ? x : window - x;
    return std::clamp(width / std::max(letter, 1.0f), kLeastPanel, 400.0f);
}

Area placeBar(const Area& area, glm::vec2 size, float least, const Area& taken, float gap)
{
    const Area inside{area.corner + gap, area.size - 2 * gap};
    size = glm::max(glm::min(size, inside.size), glm::vec2(0));
    const Area usual{{inside.corner.x, inside.end().y - size.y}, size};
    const auto free = [&](const Area& bar) {
        const bool apart =
            bar.end().x + gap <= taken.corner.x || bar.corner.x >= taken.end().x + gap ||
            bar.end().y + gap <= taken.corner.y || bar.corner.y >= taken.end().y + gap;
        return taken.empty() || apart;
    };
    if (free(usual)) return usual;
    const float left = std::min(size.x, taken.corner.x - gap - inside.corner.x);
    if (left >= least) return {usual.corner, {left, size.y}};
    const float right = std::min(size.x, inside.end().x - taken.end().x - gap);
    if (right >= least) return {{inside.end().x - right, usual.corner.y}, {right, size.y}};
    const float above = taken.corner.y - gap - size.y;
    if (above >= inside.corner.y) return {{inside.corner.x, above}, size};
    return usual;
}

Area whole(glm::uvec2 picture, glm::vec2 area)
{
    const glm::vec2 p = glm::max(glm::vec2(picture), glm::vec2(1));
    const glm::vec2 a = glm::max(area, glm::vec2(1));
    const glm::vec2 size = p * std::min(a.x / p.x, a.y / p.y);
    // A picture has whole pixels: its shape may be off by one of them.
    const glm::vec2 pixel = glm::max(a / p, glm::vec2(1));
    if (a.x - size.x <= pixel.x && a.y - size.y <= pixel.y) return {{0, 0}, {1, 1}};
    return {0.5f * (glm::vec2(1) - size / a), size / a};
}

Area kept(glm::uvec2 picture, const core::Camera& of, glm::vec2 area, const core::Camera& next)
{
    const Area fit = whole(picture, area);
    const double before = halfHeight(of), after = halfHeight(next);
    const bool same = of.position == next.position && of.forward == next.forward &&
                      of.up == next.up && of.orthographic == next.orthographic;
    if (fit.size == glm::vec2(1) || !same || !(before > 0) || !(after > 0)) return fit;
    const auto height = static_cast<float>(std::clamp(before / after, 0.1, 10.0));
    const glm::vec2 size(height * area.y * static_cast<float>(picture.x) /
                             static_cast<float>(picture.y) / area.x,
                         height);
    return {0.5f * (glm::vec2(1) - size), size};
}

}  // namespace app
