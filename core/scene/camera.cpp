// Axes and angles of a camera, made safe: any input gives finite, orthonormal axes.
#include "core/scene/camera.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"

namespace core {

namespace {

// Angles outside this interval make tan(angle / 2) useless in single precision.
constexpr double kSmallestAngle = 1e-4, kLargestAngle = 3.1398;  // radians: 0.006 and 179.9 degrees

/// Unit vector, or `fallback` when the length is zero or not finite.
glm::dvec3 unitOr(glm::dvec3 v, glm::dvec3 fallback)
{
    const double length = glm::length(v);
    return std::isfinite(length) && length > 1e-150 ? v / length : fallback;
}

/// Any unit vector orthogonal to the unit vector `n`, as upright as possible.
glm::dvec3 orthogonalTo(glm::dvec3 n)
{
    const glm::dvec3 upright = std::abs(n.y) < 0.999 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, -1);
    return glm::normalize(upright - glm::dot(upright, n) * n);
}

/// The part of `up` orthogonal to `forward`, of unit length; any orthogonal vector when they are
/// parallel.
glm::dvec3 orthogonalUp(glm::dvec3 forward, glm::dvec3 up)
{
    const glm::dvec3 direction = unitOr(up, forward);
    const glm::dvec3 part = direction - glm::dot(direction, forward) * forward;
    return glm::length(part) > 1e-9 ? glm::normalize(part) : orthogonalTo(forward);
}

}  // namespace

shared::CameraData cameraData(const Camera& camera, uint32_t width, uint32_t height)
{
    CHECK(width > 0 && height > 0);
    const glm::dvec3 forward = unitOr(camera.forward, {0, 0, -1});
    const glm::dvec3 up = orthogonalUp(forward, camera.up);
    const double angle = std::clamp(camera.yfov, kSmallestAngle, kLargestAngle);
    shared::CameraData data{};
    data.position = glm::vec3(camera.position);
    data.forward = glm::vec3(forward);
    data.up = glm::vec3(up);
    data.right = glm::vec3(glm::cross(forward, up));
    data.tanHalfHeight =
        static_cast<float>(camera.orthographic ? camera.ymag : std::tan(0.5 * angle));
    data.aspect = static_cast<float>(double(width) / double(height));
    data.apertureRadius = static_cast<float>(std::max(camera.apertureRadius, 0.0));
    data.focusDistance = static_cast<float>(camera.focusDistance > 0 ? camera.focusDistance : 1.0);
    data.orthographic = camera.orthographic ? 1u : 0u;
    return data;
}

Camera lookAt(glm::dvec3 position, glm::dvec3 target, glm::dvec3 up, double yfov)
{
    Camera camera;
    camera.position = position;
    camera.forward = unitOr(target - position, {0, 0, -1});
    camera.up = orthogonalUp(camera.forward, up);
    camera.yfov = yfov;
    return camera;
}

glm::uvec2 sizeForWidth(const Camera& camera, uint32_t width)
{
    const double aspect =
        std::isfinite(camera.aspect) && camera.aspect > 0 ? camera.aspect : 16.0 / 9.0;
    const double height = std::clamp(std::round(double(width) / aspect), 1.0, 65536.0);
    return {width, static_cast<uint32_t>(height)};
}

}  // namespace core
