// Circles that end at a given camera, tried until one is free of walls. See flight.h.
#include "app/bench/flight.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/gtc/constants.hpp>

#include "app/base/read_value.h"
#include "core/trace/accel.h"
#include "core/trace/pick.h"

namespace app::flight {

namespace {

using glm::dvec3;

constexpr double kOpening = 10;  // degrees; half of what the circle's views are apart
constexpr int kPieces = 24;      // of the circle, when it is looked at for walls

/// `v` turned about the unit vector `axis` (Rodrigues).
dvec3 turned(const dvec3& v, const dvec3& axis, double angle)
{
    return v * std::cos(angle) + glm::cross(axis, v) * std::sin(angle) +
           axis * glm::dot(axis, v) * (1 - std::cos(angle));
}

/// Metres from the camera to what it looks at: what the middle of the picture shows, or else the
/// middle of the scene.
double targetDistance(const core::World& world, const core::Camera& camera, glm::uvec2 size)
{
    const auto seen = core::pick(world, camera, size, {0.5, 0.5});
    if (seen) return seen->distance;
    const dvec3 middle = 0.5 * dvec3(world.boundsLow + world.boundsHigh);
    const double ahead = glm::dot(middle - camera.position, camera.forward);
    const auto radius = static_cast<double>(world.radius);
    return ahead > 0.05 * radius ? ahead : radius;
}

/// Whether nothing stands between any two neighbours of the places.
bool isFree(const core::Accel& accel, const std::vector<dvec3>& places)
{
    for (size_t i = 0; i + 1 < places.size(); ++i)
        if (accel.occluded({places[i], 1, places[i + 1] - places[i]})) return false;
    return true;
}

}  // namespace

Flight Flight::around(const std::shared_ptr<const core::World>& world, const core::Camera& end,
                      glm::uvec2 size, double widest)
{
    Flight flight;
    flight.last_ = end;
    flight.reach_ = targetDistance(*world, end, size);
    flight.target_ = end.position + flight.reach_ * end.forward;
    const dvec3 right = glm::normalize(glm::cross(end.forward, end.up));
    // So few rays that a hierarchy which is quickly built is best.
    const core::Accel accel(world, {}, {}, core::AccelQuality::medium);
    const double wished = std::min(std::max(kOpening, 0.55 * widest), 80.0);
    for (const double part : {1.0, 0.5, 0.25, 0.1, 0.03}) {
        // The circle lies to the right of the camera, to the left, above, below.
        for (const dvec3& about : {end.up, -end.up, right, -right}) {
            flight.opening_ = glm::radians(part * wished);
            flight.axis_ = turned(-end.forward, about, flight.opening_);
            std::vector<dvec3> places;
            for (int i = 0; i <= kPieces; ++i)
                places.push_back(flight.placeAt(glm::two_pi<double>() * i / kPieces));
            if (isFree(accel, places)) return flight;
        }
    }
    return flight;
}

Flight Flight::along(CameraPath path)
{
    Flight flight;
    flight.path_ = std::move(path);
    return flight;
}

glm::dvec3 Flight::placeAt(double azimuth) const
{
    return target_ + reach_ * turned(-last_.forward, axis_, azimuth);
}

core::Camera Flight::before(double step, uint32_t frames) const
{
    if (path_) return path_->at(path_->keys.back().frame - step * frames);
    if (frames == 0) return last_;
    // On a circle that is seen under `opening_` from its axis, this turn is `step` seen from the
    // target.
    const double sine = std::sin(glm::radians(step) / 2) / std::sin(opening_);
    core::Camera camera = last_;
    camera.position = placeAt(-2 * std::asin(std::min(sine, 1.0)) * frames);
    const core::Camera looking = core::lookAt(camera.position, target_, last_.up, last_.yfov);
    camera.forward = looking.forward;
    camera.up = looking.up;
    return camera;
}

double Flight::distance(double step) const
{
    return glm::length(before(step, 0).position - before(step, 1).position);
}

std::string Flight::whyNot(double step, uint32_t frames) const
{
    if (path_) {
        const double length = path_->keys.back().frame - path_->keys.front().frame,
                     needed = step * (frames - 1);
        if (needed <= length * (1 + 1e-9)) return {};
        return "the path is " + numberText(length) + " frames long, and " + std::to_string(frames) +
               " frames with a step of " + numberText(step) + " need " + numberText(needed) +
               " — give fewer --frames or a smaller step";
    }
    const double widest = glm::degrees(2 * opening_);
    if (step <= widest * (1 + 1e-9)) return {};
    return "something stands in the camera's way: steps of up to " + numberText(widest) +
           " degrees fit, not of " + numberText(step);
}

std::string Flight::words() const
{
    if (path_) return "along the given path, to its end";
    char text[160];
    std::snprintf(text, sizeof text,
                  "on a circle about what the middle of the picture shows, %.3g m away, whose "
                  "views are up to %.3g degrees apart",
                  reach_, glm::degrees(2 * opening_));
    return text;
}

}  // namespace app::flight
