// See surroundings.h.
#include "app/session/surroundings.h"

#include <cmath>
#include <vector>

#include <glm/gtc/constants.hpp>

#include "core/trace/pick.h"

namespace app {

namespace {

constexpr int kRays = 64;
constexpr int kMostFronts = kRays / 4;  // of what a solid stands on, or what juts into it
constexpr double kLeastWalls = 0.75;

/// Direction i of kRays that cover the sphere evenly (a Fibonacci lattice; Swinbank and Purser
/// 2006).
glm::dvec3 direction(int i)
{
    const double y = 1 - (2.0 * i + 1) / kRays;
    const double level = std::sqrt(1 - y * y);
    const double turn = 2 * glm::pi<double>() * i / glm::golden_ratio<double>();
    return {level * std::cos(turn), y, level * std::sin(turn)};
}

std::optional<core::Picked> look(const core::World& world, glm::dvec3 position, glm::dvec3 along)
{
    core::Camera camera;
    camera.position = position;
    camera.forward = along;
    camera.up = std::abs(along.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
    return core::pick(world, camera, {1, 1}, {0.5, 0.5});
}

}  // namespace

std::optional<double> distanceAlong(const core::World& world, glm::dvec3 position,
                                    glm::dvec3 direction)
{
    const std::optional<core::Picked> hit = look(world, position, direction);
    return hit ? std::optional(hit->distance) : std::nullopt;
}

bool insideSolid(const core::World& world, glm::dvec3 position)
{
    int fronts = 0;
    for (int i = 0; i < kRays; ++i) {
        const glm::dvec3 along = direction(i);
        const std::optional<core::Picked> hit = look(world, position, along);
        if (!hit) return false;
        const bool front = !(glm::dot(hit->normal, along) > 0);
        if (front && ++fronts > kMostFronts) return false;
    }
    return true;
}

std::optional<Room> roomAround(const core::World& world, glm::dvec3 position)
{
    const glm::dvec3 low(world.boundsLow), high(world.boundsHigh);
    if (glm::any(glm::lessThan(position, low)) || glm::any(glm::greaterThan(position, high)))
        return {};
    std::vector<glm::dvec3> seen;
    for (int i = 0; i < kRays; ++i)
        if (const auto hit = look(world, position, direction(i))) seen.push_back(hit->position);
    if (static_cast<double>(seen.size()) < kLeastWalls * kRays) return {};
    Room room;
    const auto count = static_cast<double>(seen.size());
    for (const glm::dvec3& point : seen) room.middle += point / count;
    for (const glm::dvec3& point : seen) room.radius += glm::distance(point, room.middle) / count;
    return room;
}

}  // namespace app
