// Triangle meshes for the tests of the acceleration structures: closed surfaces, soups and the
// shapes that break builders (N24).
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/scene/world.h"
#include "core/trace/bvh.h"

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

/// A scene far larger than what is looked at in it, both about the origin.
struct FarScene {
    const char* name;
    Mesh mesh;
    float nearRadius, farRadius;
};

/// A room on a ground of 10 km, of two triangles or of many; under a dome of 2.5 km; a ball of 1 mm
/// that touches one of 1 m on a ground of 20 km.
std::vector<FarScene> farScenes();

/// A square ground below the mesh, `half` to each side, of 2 * cells^2 triangles.
Mesh onGround(Mesh mesh, float half, uint32_t cells);

/// A sphere around the mesh.
Mesh underDome(Mesh mesh, float radius, uint32_t rings);

/// How much two ways to compute a ray's distance to a triangle in single precision may differ: some
/// units in the last place of its vertices, seen from the origin, over the cosine. `direction` is
/// of unit length.
float distanceError(const Mesh& mesh, uint32_t triangle, glm::vec3 origin, glm::vec3 direction);

/// A world of these triangles, of one material.
std::shared_ptr<const core::World> worldOf(const Mesh& mesh);

/// The tree over its triangles.
core::Bvh bvhOf(const Mesh& mesh, const core::BvhOptions& options = {});

}  // namespace tests
