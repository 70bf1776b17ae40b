// Cameras under the hand: orbit, pan, dolly and fly. Plain mathematics, no window.
#pragma once

#include <glm/glm.hpp>

#include "core/camera.h"

namespace app {

/// What is held down while flying: each in [-1, 1].
struct FlyInput {
    double right = 0, up = 0, forward = 0;
    bool fast = false, slow = false;  // four times, a quarter
};

class Navigation {
public:
    /// Takes a camera as it is; `sceneRadius` (metres) sets speeds, limits and, when nothing better is known, how far
    /// ahead the pivot lies. `worldUp` is +Y.
    void set(const core::Camera& camera, double sceneRadius);
    const core::Camera& camera() const { return camera_; }
    core::Camera& edit() { return camera_; }  // lens, angle of view: what motion does not touch

    glm::dvec3 pivot() const { return pivot_; }
    void setPivot(glm::dvec3 point);  // double click: the point under the cursor; also the focus of a thin lens
    double speed() const { return speed_; }  // metres per second
    void setSpeed(double metresPerSecond);   // clamped to sensible values of the scene

    /// Drags in fractions of the picture's height; y down. Orbiting turns about the pivot with +Y staying upright and
    /// stops short of the poles; a camera that is rolled, or looks from below, stays usable.
    void orbit(double dx, double dy);
    void pan(double dx, double dy);  // the point under the cursor at the pivot's depth follows the cursor
    void dolly(double steps);        // wheel: towards the pivot, never through it; orthographic: magnifies
    void look(double dx, double dy); // fly mode: turns about the eye
    void fly(const FlyInput& input, double seconds);

    /// Looks at the whole of a sphere from where the camera points.
    void frame(glm::dvec3 centre, double radius);

private:
    core::Camera camera_;
    glm::dvec3 pivot_{0};
    double radius_ = 1, speed_ = 0.25;
};

}  // namespace app
