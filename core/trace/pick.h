// What lies under the cursor: the nearest triangle along one ray, found through the hierarchy that
// a renderer has made, or by looking at all triangles while there is none.
#pragma once

#include <optional>

#include <glm/glm.hpp>

#include "core/scene/camera.h"
#include "core/scene/world.h"

namespace core {

struct Picked {
    glm::dvec3 position{0};  // world space
    double distance = 0;     // from the camera, metres
    uint32_t triangle = 0, material = 0;
    uint32_t instance = shared::kNone;  // index into World::instances of what shows the triangle
    glm::dvec3 normal{0};               // of its front, of no particular length
};

/// The surface seen through the middle of the picture's point `position` in [0,1]^2 (y down) by the
/// camera without its lens. Alpha is not looked at. Of equally near triangles it is the one with
/// the lowest number, whichever way it was found. A click does not wait for a hierarchy: a million
/// triangles take some milliseconds.
std::optional<Picked> pick(const World& world, const Camera& camera, glm::uvec2 imageSize,
                           glm::dvec2 position);

}  // namespace core
