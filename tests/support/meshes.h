// Triangle meshes for the tests of the acceleration structures: closed surfaces, soups and the
// shapes that break builders (N24).
#pragma once

#include <cstdint>
#include <vector>

#include "core/scene/world.h"

namespace tests {

struct Mesh {
    std::vector<glm::vec3> positions;
    std::vector<core::WorldTriangle> triangles;

    void add(glm::vec3 a, glm::vec3 b, glm::vec3 c);
};

/// A closed sphere of shared vertices, 4 * rings * (rings - 1) triangles; `bump` displaces it
/// radially by that fraction.
Mesh sphereMesh(uint32_t rings, float radius, float bump, glm::vec3 centre);

/// Triangles of random size and place in the unit cube.
Mesh soupMesh(uint32_t count, float size, uint32_t seed);

/// Ribbons of long thin triangles, as hair.
Mesh hairMesh(uint32_t strands, uint32_t seed);

/// A room with boxes, spheres and finely tessellated things beside walls of two triangles.
Mesh roomMesh(uint32_t seed);

/// All boxes about the origin, each larger than the last.
Mesh nestedMesh(uint32_t count);

/// `count` copies of one triangle.
Mesh identicalMesh(uint32_t count);

/// Small triangles along a line, spaced geometrically so that every balanced guess is wrong.
Mesh lineMesh(uint32_t count, float ratio);

}  // namespace tests
