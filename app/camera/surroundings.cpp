// See surroundings.h.
#include "app/camera/surroundings.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <glm/gtc/constants.hpp>

#include "core/trace/pick.h"
#include "core/trace/world_bvh.h"

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

bool quickToLook(const core::World& world, size_t rays)
{
    constexpr size_t kFew = 3'200'000;  // triangles and instances; 50,000 take about .15 ms
    return rays * (world.triangles.size() + world.instances.size()) < kFew ||
           core::bvhIfMade(world);
}

std::optional<double> distanceAlong(const core::World& world, glm::dvec3 position,
                                    glm::dvec3 direction)
{
    const std::optional<core::Picked> hit = look(world, position, direction);
    return hit ? std::optional(hit->distance) : std::nullopt;
}

bool insideSolid(const core::World& world, glm::dvec3 position, std::stop_token stop)
{
    int fronts = 0;
    for (int i = 0; i < kRays; ++i) {
        if (stop.stop_requested()) return false;
        const glm::dvec3 along = direction(i);
        const std::optional<core::Picked> hit = look(world, position, along);
        if (!hit) return false;
        const bool front = !(glm::dot(hit->normal, along) > 0);
        if (front && ++fronts > kMostFronts) return false;
    }
    return true;
}

bool leadsThrough(const core::World& world, std::span<const glm::dvec3> way, std::stop_token stop)
{
    for (size_t i = 1; i < way.size() && !stop.stop_requested(); ++i) {
        const double length = glm::distance(way[i - 1], way[i]);
        if (!(length > 0)) continue;
        const auto hit = look(world, way[i - 1], (way[i] - way[i - 1]) / length);
        if (hit && glm::distance(hit->position, way[i - 1]) < length) return true;
    }
    return false;
}

double freeShare(const core::World& world, glm::dvec3 from, glm::dvec3 to, double margin)
{
    const double length = glm::distance(from, to);
    if (!(length > 0)) return 1;
    const glm::dvec3 along = (to - from) / length;
    const std::optional<core::Picked> hit = look(world, from, along);
    if (!hit || glm::dot(hit->normal, along) > 0) return 1;
    return std::clamp((glm::distance(hit->position, from) - margin) / length, 0.0, 1.0);
}

double wallMargin(const core::World& world)
{
    constexpr double kOfRadius = 0.01, kMostMetres = 0.05;
    return std::min(kOfRadius * static_cast<double>(world.radius),
                    kMostMetres * world.placement.scale);
}

std::optional<Room> roomAround(const core::World& world, glm::dvec3 position, std::stop_token stop)
{
    const glm::dvec3 low(world.boundsLow), high(world.boundsHigh);
    if (glm::any(glm::lessThan(position, low)) || glm::any(glm::greaterThan(position, high)))
        return {};
    std::vector<glm::dvec3> seen;
    for (int i = 0; i < kRays && !stop.stop_requested(); ++i)
        if (const auto hit = look(world, position, direction(i))) seen.push_back(hit->position);
    if (stop.stop_requested()) return {};
    if (static_cast<double>(seen.size()) < kLeastWalls * kRays) return {};
    Room room;
    const auto count = static_cast<double>(seen.size());
    for (const glm::dvec3& point : seen) room.middle += point / count;
    for (const glm::dvec3& point : seen) room.radius += glm::distance(point, room.middle) / count;
    return room;
}

std::optional<Standpoint> standpointInRoom(const core::World& world, const core::Camera& camera,
                                           double distance, std::stop_token stop)
{
    if (camera.orthographic) return {};
    const glm::dvec3 eye = camera.position;
    const std::optional<Room> room = roomAround(world, eye, std::move(stop));
    if (!room) return {};
    // Looks at the middle of what is around and steps back from it as far as the wall behind.
    const double ahead = glm::distance(room->middle, eye);
    const glm::dvec3 to =
        ahead > 0.1 * room->radius ? (room->middle - eye) / ahead : camera.forward;
    const double wanted = distance * room->radius - ahead;
    const double wall = distanceAlong(world, eye, -to).value_or(wanted);
    const double step = std::clamp(wanted, 0.0, std::max(wall - 0.1 * room->radius, 0.0));
    return Standpoint{eye - step * to, eye + std::max(ahead, 0.1 * room->radius) * to};
}

}  // namespace app
