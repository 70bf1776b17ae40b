// Cameras under the hand: orbit, pan, dolly and fly. Plain mathematics, no window.
// Input that is not finite or absurdly large is ignored; the axes stay orthonormal whatever is
// done. Lengths are in the world's units, which are metres but in worlds that are scaled: see
// core::Placement.
#pragma once

#include <functional>

#include <glm/glm.hpp>

#include "app/camera/way.h"
#include "core/scene/camera.h"

namespace app {

/// What is held down while flying: each in [-1, 1].
struct FlyInput {
    double right = 0, up = 0, forward = 0;
    bool fast = false, slow = false;  // four times, a quarter
};

/// The camera as a picture of that shape (width over height) shows it. Its own frame, where it has
/// one, is seen whole: in a narrower picture the vertical angle grows, in a wider one it is kept
/// and more is seen at the sides.
core::Camera framed(const core::Camera& camera, double aspect);

/// Where one is and what one turns about.
struct Viewpoint {
    core::Camera camera;
    glm::dvec3 pivot{0};

    friend bool operator==(const Viewpoint&, const Viewpoint&) = default;
};

/// How much of the straight way between two points is free, from 0 to 1: where the eye stops.
/// Empty: all of every way.
using Reach = std::function<double(const glm::dvec3& from, const glm::dvec3& to)>;

class Navigation {
public:
    /// Takes a camera as it is; `sceneRadius` (about the origin) sets speeds, limits and,
    /// when nothing better is known, how far ahead the pivot lies. `worldUp` is +Y. A speed that
    /// was set stays while the radius does.
    void set(const core::Camera& camera, double sceneRadius);
    const core::Camera& camera() const { return camera_; }

    /// Back to where one has been.
    void go(const Viewpoint& viewpoint);
    Viewpoint viewpoint() const { return {camera_, pivot_}; }

    /// Where the eye has gone by hand (orbit, pan, dolly, fly) since it was put somewhere, or since
    /// the way began anew. Straight between its points; arcs have one each eleven degrees.
    const Way& way() const { return way_; }
    void beginWay() { way_.begin(camera_.position); }

    /// The shape of the picture, width over height; 0: the camera's own.
    void setAspect(double aspect);
    /// The camera as the picture shows it: what is rendered.
    core::Camera view() const { return framed(camera_, aspect_); }

    /// Lens, angle of view: what motion does not touch.
    core::Camera& edit() { return camera_; }

    glm::dvec3 pivot() const { return pivot_; }

    /// Along the direction of view; what a lens would focus on.
    double pivotDepth() const;

    /// Double click: the point under the cursor. An open lens is focused on it; a pinhole stays as
    /// it is, so that its picture need not begin anew.
    void setPivot(glm::dvec3 point);

    double speed() const { return speed_; }  // per second
    void setSpeed(double perSecond);         // clamped to sensible values of the scene

    /// Turns about the pivot. The drag, here and below, is in fractions of the picture's height
    /// with y down; one height is half a turn. What is under the hand goes where the hand goes,
    /// also when the camera is rolled or upside down, and its roll stays. Stops half a degree short
    /// of the poles. Where something is in the way the eye stays before it and turns on the spot;
    /// the pivot stays where it is in the picture. Returns whether something was; so do pan, dolly
    /// and dollyTo, which stop before it.
    bool orbit(double dx, double dy, const Reach& reach = {});

    /// Shifts camera and pivot: the point under the cursor at the pivot's depth follows the cursor.
    bool pan(double dx, double dy, const Reach& reach = {});

    /// The wheel: a tenth nearer to the pivot per step, never through it; orthographic: magnifies.
    /// A lens that was focused on the pivot stays so.
    bool dolly(double steps, const Reach& reach = {});

    /// The same towards `point`, which stays where it is in the picture and is never reached. The
    /// pivot comes along.
    bool dollyTo(glm::dvec3 point, double steps, const Reach& reach = {});

    /// The point at the pivot's depth that is seen at `position` in [0,1]^2 of the picture, y down.
    glm::dvec3 pointAt(glm::dvec2 position) const;

    /// Fly mode: turns about the eye, to where the drag points; one height is twice the angle of
    /// view. The pivot stays where it is in the picture.
    void look(double dx, double dy);

    /// Moves along the camera's axes, but up is the world's. At most a minute at a time.
    void fly(const FlyInput& input, double seconds);

    /// Looks at the whole of a sphere from where the camera points.
    void frame(glm::dvec3 centre, double radius);

    /// Turns to `target` from `position`, upright.
    void stand(glm::dvec3 position, glm::dvec3 target);

    /// How far away a sphere of that radius is seen whole.
    double framingDistance(double radius) const;

private:
    void take(const core::Camera& camera, glm::dvec3 pivot);
    void move(const core::Camera& camera, glm::dvec3 pivot);
    bool approach(glm::dvec3 point, double factor, const Reach& reach);

    core::Camera camera_;
    Way way_;
    glm::dvec3 pivot_{0};
    double radius_ = 1, speed_ = 0.25, aspect_ = 0;
};

}  // namespace app
