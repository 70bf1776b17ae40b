// See ui_places.h.
#include "app/view/ui/ui_places.h"

#include <cmath>
#include <cstdio>
#include <sstream>

#include "app/view/ui/ui_text.h"

namespace app {
namespace {

glm::vec2 cornerOf(const Area& area, glm::vec2 corner)
{
    return area.corner + area.size * corner;
}

/// Of a file that anybody may have written.
bool isSensible(const WindowPlaces::Place& place)
{
    constexpr float kFarthest = 1e5f;
    const glm::vec2 far = glm::abs(place.offset), size = place.size;
    return far.x <= kFarthest && far.y <= kFarthest && size.x >= 1 && size.y >= 1 &&
           size.x <= kFarthest && size.y <= kFarthest;
}

}  // namespace

Area WindowPlaces::placeOf(const std::string& name, const Area& picture, glm::vec2 window,
                           glm::vec2 usual, glm::vec2 corner, float gap)
{
    const auto given = given_.find(name);
    const bool has = given != given_.end();
    const glm::vec2 offset = has ? given->second.offset : gap * (1.0f - 2.0f * corner);
    Area place;
    place.size = glm::floor(glm::min(has ? given->second.size : usual, window));
    place.corner = glm::round(cornerOf(picture, corner) + offset - place.size * corner);
    place.corner =
        glm::clamp(place.corner, glm::vec2(0), glm::max(window - place.size, glm::vec2(0)));
    place.corner = glm::floor(place.corner);
    shown_[name] = place;
    return place;
}

void WindowPlaces::seen(const std::string& name, const Area& window, const Area& picture,
                        glm::vec2 corner)
{
    const auto before = shown_.find(name);
    if (before == shown_.end() || before->second == window) return;
    const Place place{cornerOf(window, corner) - cornerOf(picture, corner), window.size};
    if (!isSensible(place)) return;
    given_[name] = place;
    changed_ = true;
}

std::string WindowPlaces::changes()
{
    std::string text;
    if (!changed_) return text;
    changed_ = false;
    for (const auto& [name, place] : given_)
        text += "[Place][" + name + "]\n" +
                format("%.9g %.9g %.9g %.9g\n", double(place.offset.x), double(place.offset.y),
                       double(place.size.x), double(place.size.y));
    return text;
}

void WindowPlaces::read(const std::string& text)
{
    std::istringstream lines(text);
    const std::string lead = "[Place][";
    for (std::string head, line; std::getline(lines, head);) {
        if (!head.starts_with(lead) || !head.ends_with(']') || !std::getline(lines, line)) continue;
        std::istringstream numbers(line);
        Place place;
        if (numbers >> place.offset.x >> place.offset.y >> place.size.x >> place.size.y &&
            isSensible(place))
            given_[head.substr(lead.size(), head.size() - lead.size() - 1)] = place;
    }
}

}  // namespace app
