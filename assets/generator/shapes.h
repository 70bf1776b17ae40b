// Simple closed and open shapes as triangles with flat or smooth normals.
#pragma once

#include "assets/generator/gltf_writer.h"

namespace assets {

/// Parallelogram with a corner and two edges; the front is where edgeU x edgeV points. Texture
/// coordinates: u along edgeU, the image upright along edgeV.
MeshData makeQuad(glm::vec3 corner, glm::vec3 edgeU, glm::vec3 edgeV);

/// Box between two corners, turned by `degrees` about the vertical through its middle. `inward`
/// makes it a room.
MeshData makeBox(glm::vec3 low, glm::vec3 high, float degrees = 0, bool inward = false);

/// Sphere of latitude rings and longitude segments; smooth normals and texture coordinates, or
/// neither.
MeshData makeSphere(glm::vec3 centre, float radius, uint32_t segments, uint32_t rings, bool smooth);

/// Regular tetrahedron about the origin, flat normals.
MeshData makeTetrahedron(float radius);

/// Adds the triangles of `part`, which has the same attributes.
void append(MeshData& mesh, const MeshData& part);

}  // namespace assets
