// Cameras of tests that move them by hand, and what such tests ask of them.
#pragma once

#include <algorithm>
#include <cmath>

#include <glm/glm.hpp>

#include "core/scene/camera.h"

namespace tests {

inline core::Camera someCamera(bool orthographic = false)
{
    core::Camera camera = core::lookAt({3, 1.5, 4}, {0.2, 0.5, -0.3}, {0, 1, 0}, 0.8);
    camera.orthographic = orthographic;
    camera.ymag = 1.7;
    return camera;
}

/// Where a point appears: fractions of the picture's height from its middle, y down.
inline glm::dvec2 shown(const core::Camera& camera, glm::dvec3 point)
{
    const glm::dvec3 offset = point - camera.position,
                     right = glm::cross(camera.forward, camera.up);
    const double half = camera.orthographic
                            ? camera.ymag
                            : glm::dot(offset, camera.forward) * std::tan(0.5 * camera.yfov);
    return {0.5 * glm::dot(offset, right) / half, -0.5 * glm::dot(offset, camera.up) / half};
}

/// By how much the axes are not orthonormal.
inline double axisError(const core::Camera& camera)
{
    return std::max({std::abs(glm::length(camera.forward) - 1),
                     std::abs(glm::length(camera.up) - 1),
                     std::abs(glm::dot(camera.forward, camera.up))});
}

}  // namespace tests
