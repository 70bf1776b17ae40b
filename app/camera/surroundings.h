// What is around a place: whether one stands in a room, or inside something solid. A few dozen rays
// through core::pick, on the thread that asks: see quickToLook().
#pragma once

#include <optional>
#include <span>
#include <stop_token>

#include <glm/glm.hpp>

#include "core/scene/world.h"

namespace app {

/// Whether so many rays are answered within a frame: through a hierarchy, or because there is not
/// much to look through. Else a window leaves them to a thread of their own.
bool quickToLook(const core::World& world, size_t rays = 64);

/// Metres from `position` along `direction` (of length 1) to the first surface; nothing when there
/// is none. Alpha is not looked at.
std::optional<double> distanceAlong(const core::World& world, glm::dvec3 position,
                                    glm::dvec3 direction);

/// Whether the place is inside a closed surface: all of 64 directions meet something, and at least
/// three quarters of them its back. (Of 12 cameras in 8 interiors as they are found, whatever their
/// materials say of sides, none sees more than one seventh of backs.) A ray that leads outside, or
/// enough fronts, end it early: outside it costs next to nothing. An empty room whose walls are
/// wound the wrong way round cannot be told from a solid, nor a place in two solids at once from
/// the open.
/// A stop ends it early, with whatever answer.
bool insideSolid(const core::World& world, glm::dvec3 position, std::stop_token stop = {});

/// Whether the line through these points leads through a surface: not if it goes through an open
/// door. Alpha is not looked at, nor that glass can be seen through. A stop ends it early, with
/// whatever answer.
bool leadsThrough(const core::World& world, std::span<const glm::dvec3> way,
                  std::stop_token stop = {});

/// A room as it is seen from within.
struct Room {
    glm::dvec3 middle{0};  // mean of what is seen in all directions
    double radius = 0;     // mean distance of that from the middle, metres
};

/// How much of the straight way, from 0 to 1, can be gone without coming closer than `margin` to
/// the front of the first surface. Its back stops nobody, so that what one is inside of can be
/// left. Alpha is not looked at.
double freeShare(const core::World& world, glm::dvec3 from, glm::dvec3 to, double margin);

/// The margin of a camera that is moved by hand, in the world's units: a hundredth of the scene's
/// radius, but no more than five centimetres, for rooms may stand in a wide landscape.
double wallMargin(const core::World& world);

/// The room around the place; nothing when it is not in the scene's bounds or more than a quarter
/// of 64 directions lead out into the open, or when it is stopped.
std::optional<Room> roomAround(const core::World& world, glm::dvec3 position,
                               std::stop_token stop = {});

/// Where to stand to see as much of a room as can be seen without leaving it, and what to look at.
struct Standpoint {
    glm::dvec3 position{0}, target{0};
};

/// The one that is reached from the camera by turning and stepping back; nothing outside of rooms.
/// `distance`: from which a sphere of radius 1 is seen whole. Nothing when it is stopped.
std::optional<Standpoint> standpointInRoom(const core::World& world, const core::Camera& camera,
                                           double distance, std::stop_token stop = {});

}  // namespace app
