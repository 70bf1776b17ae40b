// Cameras under the hand. See navigation.h. Directions are split into heading, pitch and roll about
// +Y, changed there, and put together again with sines and cosines: nothing drifts.
#include "app/camera/navigation.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/constants.hpp>

namespace app {

namespace {

constexpr double kPi = glm::pi<double>();
constexpr double kSteepest = 0.5 * kPi - kPi / 360;  // of orbits and looks, half a degree left
constexpr double kLargestInput = 1000;               // picture heights, steps of the wheel
constexpr double kLongestArc = kPi / 16;             // that counts as straight
constexpr double kStep = 0.9;                        // of the distance that is left per step
// In scene radii.
constexpr double kNearest = 1e-5, kFarthest = 1e4;          // of the pivot
constexpr double kSmallestView = 1e-6, kLargestView = 1e4;  // half the height of orthographic ones
constexpr double kFarthestEye = 1e6;                        // from the origin
constexpr double kSlowest = 1e-5, kFastest = 100;           // per second
constexpr double kSmallestAngle = 1e-4, kLargestAngle = 3.1398;  // those of core/scene/camera.cpp

bool finite(glm::dvec3 v)
{
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

bool saneInput(double a, double b = 0)
{
    return std::abs(a) <= kLargestInput && std::abs(b) <= kLargestInput;  // false for NaN
}

/// Clamps to [low, high]; a value that is outside already may only come nearer.
double clampFrom(double before, double after, double low, double high)
{
    return std::clamp(after, std::min(low, before), std::max(high, before));
}

glm::dvec3 rightOf(const core::Camera& camera)
{
    return glm::cross(camera.forward, camera.up);
}

/// Where a camera points. Heading 0 looks along -Z, a quarter turn along +X; pitch is positive
/// above the horizon; roll turns the camera about its direction of view, to the right when
/// positive.
struct Direction {
    double heading = 0, pitch = 0, roll = 0;
};

/// The axes of a direction without its roll.
glm::dmat3 uprightAxes(const Direction& d)
{
    const double sh = std::sin(d.heading), ch = std::cos(d.heading), sp = std::sin(d.pitch),
                 cp = std::cos(d.pitch);
    return {{ch, 0, sh}, {-sp * sh, cp, sp * ch}, {cp * sh, sp, -cp * ch}};  // right, up, forward
}

/// Right, up, forward.
glm::dmat3 axes(const Direction& d)
{
    const glm::dmat3 upright = uprightAxes(d);
    const double s = std::sin(d.roll), c = std::cos(d.roll);
    return {c * upright[0] - s * upright[1], s * upright[0] + c * upright[1], upright[2]};
}

Direction directionOf(const core::Camera& camera)
{
    const glm::dvec3 f = camera.forward, up = camera.up;
    Direction d;
    const double level = std::hypot(f.x, f.z);
    d.pitch = std::atan2(f.y, level);
    if (level > 1e-6) {
        d.heading = std::atan2(f.x, -f.z);
        const glm::dmat3 upright = uprightAxes(d);
        d.roll = std::atan2(glm::dot(up, upright[0]), glm::dot(up, upright[1]));
    } else {
        // Straight up or down, the heading is where the upper edge of the picture points.
        const double sign = f.y > 0 ? -1 : 1;
        d.heading = std::atan2(sign * up.x, -sign * up.z);
    }
    return d;
}

/// A drag as an upright camera would see it.
glm::dvec2 upright(glm::dvec2 drag, double roll)
{
    const double s = std::sin(roll), c = std::cos(roll);
    // The picture's x axis is c right - s up, its y axis (down) is -(s right + c up).
    return {c * drag.x - s * drag.y, s * drag.x + c * drag.y};
}

/// `direction` turned by heading and pitch, short of the poles.
Direction turned(Direction direction, double heading, double pitch)
{
    direction.heading = std::remainder(direction.heading + heading, 2 * kPi);
    direction.pitch = clampFrom(direction.pitch, direction.pitch + pitch, -kSteepest, kSteepest);
    return direction;
}

void point(core::Camera& camera, const glm::dmat3& to)
{
    camera.up = to[1];
    camera.forward = to[2];
}

double tangent(const core::Camera& camera)
{
    return std::tan(0.5 * std::clamp(camera.yfov, kSmallestAngle, kLargestAngle));
}

/// The camera with finite position and orthonormal axes; one that has them is not touched.
core::Camera repaired(core::Camera camera)
{
    if (!finite(camera.position)) camera.position = core::Camera().position;
    const auto unit = [](glm::dvec3 v) { return std::abs(glm::dot(v, v) - 1) < 1e-9; };
    if (unit(camera.forward) && unit(camera.up) &&
        std::abs(glm::dot(camera.forward, camera.up)) < 1e-9)
        return camera;
    const core::Camera safe = core::lookAt({0, 0, 0}, camera.forward, camera.up, camera.yfov);
    camera.forward = safe.forward;
    camera.up = safe.up;
    return camera;
}

double reachOf(const Reach& reach, const glm::dvec3& from, const glm::dvec3& to)
{
    return reach && from != to ? std::clamp(reach(from, to), 0.0, 1.0) : 1.0;
}

bool focusedAt(const core::Camera& camera, double depth)
{
    return camera.apertureRadius > 0 && std::abs(camera.focusDistance - depth) <= 1e-6 * depth;
}

}  // namespace

core::Camera framed(const core::Camera& camera, double aspect)
{
    // A picture of whole pixels is a little narrower or wider than it should be.
    constexpr double kTolerance = 1.005;
    if (!(aspect > 0) || !(camera.aspect > kTolerance * aspect) || !std::isfinite(camera.aspect))
        return camera;
    core::Camera wider = camera;
    const double ratio = camera.aspect / aspect;
    wider.yfov = std::min(2 * std::atan(ratio * tangent(camera)), kLargestAngle);
    wider.ymag = ratio * camera.ymag;
    wider.aspect = aspect;
    return wider;
}

void Navigation::setAspect(double aspect)
{
    if (std::isfinite(aspect) && aspect >= 0) aspect_ = aspect;
}

void Navigation::go(const Viewpoint& viewpoint)
{
    take(repaired(viewpoint.camera), viewpoint.pivot);
    beginWay();
}

void Navigation::set(const core::Camera& camera, double sceneRadius)
{
    const double radius = std::isfinite(sceneRadius) && sceneRadius > 0 ? sceneRadius : 1;
    if (radius != radius_) speed_ = radius / 4;
    radius_ = radius;
    camera_ = repaired(camera);
    // A lens knows what is looked at; else it is probably the middle of the scene, the origin.
    double ahead = camera_.focusDistance, nearest = kNearest * radius_;
    if (!(camera_.apertureRadius > 0)) {
        ahead = -glm::dot(camera_.position, camera_.forward);
        nearest = 0.05 * radius_;
    }
    if (!(ahead >= nearest && ahead <= kFarthest * radius_)) ahead = radius_;
    pivot_ = camera_.position + ahead * camera_.forward;
    beginWay();
}

void Navigation::take(const core::Camera& camera, glm::dvec3 pivot)
{
    const double farthest = std::max(kFarthestEye * radius_, glm::length(camera_.position));
    if (!finite(pivot) || !finite(camera.position) || !(glm::length(camera.position) <= farthest))
        return;
    camera_ = camera;
    pivot_ = pivot;
}

/// By hand, on the straight way.
void Navigation::move(const core::Camera& camera, glm::dvec3 pivot)
{
    take(camera, pivot);
    way_.go(camera_.position);
}

double Navigation::pivotDepth() const
{
    const double depth = glm::dot(pivot_ - camera_.position, camera_.forward);
    // Behind the eye there is none: the distance serves as well.
    return std::max(depth > 0 ? depth : glm::distance(pivot_, camera_.position),
                    kNearest * radius_);
}

void Navigation::setPivot(glm::dvec3 point)
{
    if (!finite(point) || glm::distance(point, camera_.position) < kNearest * radius_) return;
    pivot_ = point;
    if (camera_.apertureRadius > 0) camera_.focusDistance = pivotDepth();
}

void Navigation::setSpeed(double perSecond)
{
    if (std::isnan(perSecond)) return;
    speed_ = std::clamp(perSecond, kSlowest * radius_, kFastest * radius_);
}

bool Navigation::orbit(double dx, double dy, const Reach& reach)
{
    if (!saneInput(dx, dy) || (dx == 0 && dy == 0)) return false;
    const Direction before = directionOf(camera_);
    const glm::dvec2 drag = upright({dx, dy}, before.roll);
    // In the camera's own axes the pivot stays where it is, so it stays under the cursor.
    const glm::dvec3 offset = glm::transpose(axes(before)) * (camera_.position - pivot_);
    const double turns = std::min(glm::length(drag), 2.0) * kPi;
    const int parts = std::max(static_cast<int>(std::ceil(turns / kLongestArc)), 1);
    core::Camera camera = camera_;
    for (int i = 1; i <= parts; ++i) {
        const glm::dvec2 turn = kPi * (double(i) / parts) * drag;
        const glm::dmat3 to = axes(turned(before, turn.x, -turn.y));
        const glm::dvec3 from = camera_.position, wanted = pivot_ + to * offset;
        if (const double free = reachOf(reach, from, wanted); free < 1) {
            const glm::dmat3 end = axes(turned(before, kPi * drag.x, -kPi * drag.y));
            camera.position = glm::mix(from, wanted, free);
            point(camera, end);
            move(camera, camera.position - end * offset);
            return true;
        }
        camera.position = wanted;
        point(camera, to);
        move(camera, pivot_);
    }
    return false;
}

bool Navigation::pan(double dx, double dy, const Reach& reach)
{
    if (!saneInput(dx, dy)) return false;
    const double height =
        2 * (camera_.orthographic ? std::abs(view().ymag) : pivotDepth() * tangent(view()));
    const glm::dvec3 wanted = height * (-dx * rightOf(camera_) + dy * camera_.up);
    const double free = reachOf(reach, camera_.position, camera_.position + wanted);
    core::Camera camera = camera_;
    camera.position += free * wanted;
    move(camera, pivot_ + free * wanted);
    return free < 1;
}

bool Navigation::dolly(double steps, const Reach& reach)
{
    if (!saneInput(steps)) return false;
    core::Camera camera = camera_;
    const double factor = std::pow(kStep, steps);
    if (camera.orthographic) {
        camera.ymag = clampFrom(camera.ymag, factor * camera.ymag, kSmallestView * radius_,
                                kLargestView * radius_);
        move(camera, pivot_);
        return false;
    }
    return approach(pivot_, factor, reach);
}

/// Goes to `factor` of the distance to a point, of which the pivot goes to the same share.
bool Navigation::approach(glm::dvec3 point, double factor, const Reach& reach)
{
    core::Camera camera = camera_;
    const glm::dvec3 offset = camera_.position - point;
    const double before = glm::length(offset);
    if (!(before > 0)) return false;
    const double after =
        clampFrom(before, factor * before, kNearest * radius_, kFarthest * radius_);
    const double free = reachOf(reach, camera_.position, point + (after / before) * offset);
    const double share = glm::mix(1.0, after / before, free);
    camera.position = point + share * offset;
    if (focusedAt(camera_, pivotDepth())) camera.focusDistance *= share;
    move(camera, point + share * (pivot_ - point));
    return free < 1;
}

glm::dvec3 Navigation::pointAt(glm::dvec2 position) const
{
    const core::Camera camera = view();
    const double aspect = aspect_ > 0 ? aspect_ : camera.aspect > 0 ? camera.aspect : 1;
    const double depth = pivotDepth();
    const double height = camera.orthographic ? std::abs(camera.ymag) : depth * tangent(camera);
    return camera.position + depth * camera.forward +
           height *
               ((2 * position.x - 1) * aspect * rightOf(camera) + (1 - 2 * position.y) * camera.up);
}

bool Navigation::dollyTo(glm::dvec3 point, double steps, const Reach& reach)
{
    if (!saneInput(steps) || !finite(point)) return false;
    core::Camera camera = camera_;
    const double factor = std::pow(kStep, steps);
    if (camera.orthographic) {
        camera.ymag = clampFrom(camera.ymag, factor * camera.ymag, kSmallestView * radius_,
                                kLargestView * radius_);
        const glm::dvec3 offset = point - camera.position;
        const glm::dvec3 aside = offset - glm::dot(offset, camera.forward) * camera.forward;
        const glm::dvec3 shift = (1 - camera.ymag / camera_.ymag) * aside;
        camera.position += shift;
        move(camera, pivot_ + shift);
        return false;
    }
    return approach(point, factor, reach);
}

void Navigation::look(double dx, double dy)
{
    if (!saneInput(dx, dy) || (dx == 0 && dy == 0)) return;
    const double turn = camera_.orthographic ? 0.5 * kPi : 4 * std::atan(tangent(view()));
    const Direction before = directionOf(camera_);
    const glm::dvec2 drag = upright({dx, dy}, before.roll);
    const Direction after = turned(before, turn * drag.x, -turn * drag.y);
    const glm::dmat3 from = axes(before), to = axes(after);
    core::Camera camera = camera_;
    point(camera, to);
    take(camera, camera_.position + to * (glm::transpose(from) * (pivot_ - camera_.position)));
}

void Navigation::fly(const FlyInput& input, double seconds)
{
    if (!(seconds > 0 && seconds <= 60)) return;
    glm::dvec3 wish(input.right, input.up, input.forward);
    if (!finite(wish)) return;
    wish = glm::clamp(wish, -1.0, 1.0);
    if (glm::length(wish) > 1) wish = glm::normalize(wish);
    const double speed = speed_ * (input.fast ? 4 : 1) * (input.slow ? 0.25 : 1);
    const glm::dvec3 shift =
        speed * seconds *
        (wish.x * rightOf(camera_) + wish.y * glm::dvec3(0, 1, 0) + wish.z * camera_.forward);
    core::Camera camera = camera_;
    camera.position += shift;
    move(camera, pivot_ + shift);
}

double Navigation::framingDistance(double radius) const
{
    const double aspect = aspect_ > 0 ? aspect_ : camera_.aspect > 0 ? camera_.aspect : 1;
    const double angle = std::atan(tangent(view()) * std::min(aspect, 1.0));
    return camera_.orthographic ? 2 * radius : radius / std::sin(angle);
}

void Navigation::frame(glm::dvec3 centre, double radius)
{
    if (!finite(centre) || !std::isfinite(radius)) return;
    const double wanted = std::clamp(radius, 1e-3 * radius_, kFarthest * radius_);
    const double distance = framingDistance(wanted);
    core::Camera camera = camera_;
    camera.position = centre - distance * camera.forward;
    if (camera.orthographic) {
        const double aspect = aspect_ > 0 ? aspect_ : camera.aspect > 0 ? camera.aspect : 1;
        // What view() makes of it
        const double grown = framed(camera, aspect_).ymag / camera.ymag;
        camera.ymag = wanted / (std::min(aspect, 1.0) * grown);
    }
    if (camera.apertureRadius > 0) camera.focusDistance = distance;
    take(camera, centre);
    beginWay();
}

void Navigation::stand(glm::dvec3 position, glm::dvec3 target)
{
    if (!finite(position) || !finite(target) || position == target) return;
    core::Camera camera = camera_;
    camera.position = position;
    Direction direction;
    const glm::dvec3 ahead = glm::normalize(target - position);
    camera.forward = ahead;
    direction = directionOf(camera);
    direction.roll = 0;
    direction.pitch = std::clamp(direction.pitch, -kSteepest, kSteepest);
    point(camera, axes(direction));
    const double distance = glm::distance(position, target);
    if (camera.apertureRadius > 0) camera.focusDistance = std::max(distance, kNearest * radius_);
    take(camera, position + distance * camera.forward);
    beginWay();
}

}  // namespace app
