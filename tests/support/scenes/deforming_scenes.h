// Scenes whose meshes change their shape, and where their vertices are in closed form.
#pragma once

#include "tests/support/scenes/animated_scenes.h"

namespace tests {

/// What bends a strip.
struct Bends {
    bool skin = true, targets = false;
};

/// Nodes of a strip.
struct Strip {
    int node = -1, lower = -1, upper = -1;  // of its mesh, of its joints
};

/// Adds a strip in the plane z = 0, from y = 0 to 2 in eight rows, x from -0.2 to 0.2, normals
/// along +z. In the first second the upper joint, at y = 1, turns by 90 degrees about x, in the
/// next by another 60, and both move along x; vertices below y = 0.5 follow the lower one,
/// above 1.5 the upper one, between a blend. A first target leans the strip towards +z (z += 0.3
/// y), a second moves its upper half by 0.2 along x: the weights go from (0, 0) over (1, 0) to (1,
/// -2). A node with a skin stands somewhere else, turned and scaled, which must not show. All of it
/// is moved by `place`.
Strip addStrip(SceneBuilder& builder, int material, const Bends& bends,
               const glm::dvec3& place = glm::dvec3(0));

/// Where the vertex (x, y, 0) of a strip that was not moved is at `time`, 0 to 2, in the file's
/// space, and its normal.
struct StripVertex {
    glm::dvec3 position, normal;
};
StripVertex stripVertex(const Bends& bends, glm::dvec2 xy, double time);

/// Weight of the upper joint at height `y`.
double upperWeight(double y);

/// A room in which a strip bends by joints, another by targets, and one that shines by both, beside
/// what moves rigidly.
SceneBuilder deformingRoom();

}  // namespace tests
