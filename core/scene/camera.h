// Pinhole and thin-lens camera, perspective or orthographic, in world space.
#pragma once

#include <string>

#include <glm/glm.hpp>

#include "shared/layout.h"

namespace core {

/// Position and orthonormal axes in world space (right-handed: right x up = -forward).
struct Camera {
    std::string name;
    glm::dvec3 position{0, 0, 3};
    glm::dvec3 forward{0, 0, -1};
    glm::dvec3 up{0, 1, 0};
    double yfov = 0.7;                             // radians, full vertical angle
    double aspect = 0;                             // width / height; 0: that of the image
    double apertureRadius = 0, focusDistance = 1;  // metres
    bool orthographic = false;
    double ymag = 1;  // half the height when orthographic

    /// Whether rays begin on a lens. The parallel rays of an orthographic camera never do.
    bool hasLens() const { return apertureRadius > 0 && !orthographic; }

    friend bool operator==(const Camera&, const Camera&) = default;
};

/// The camera as rays are made from it. `width`, `height` in pixels decide the aspect: the vertical
/// angle is kept.
shared::CameraData cameraData(const Camera& camera, uint32_t width, uint32_t height);

/// A camera at `position` looking at `target`.
Camera lookAt(glm::dvec3 position, glm::dvec3 target, glm::dvec3 up, double yfov);

/// Image size for a camera: `width` given, height from its own aspect (at least 1).
glm::uvec2 sizeForWidth(const Camera& camera, uint32_t width);

}  // namespace core
