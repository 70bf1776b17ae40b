// One primitive of a mesh on its way into the scene: plain arrays, then packed.
#pragma once

#include <vector>

#include "core/scene/scene.h"

namespace core::gltf {

// Modes of primitives; below are points and lines.
inline constexpr uint64_t kTriangles = 4, kStrip = 5, kFan = 6;

/// Vertices as floats; every array is empty or as long as `positions`.
struct Primitive {
    std::vector<glm::vec3> positions, normals;
    std::vector<glm::vec4> tangents, colors;  // tangents: w is the handedness
    std::vector<glm::vec2> uv0, uv1;
    std::vector<glm::uvec3> triangles;
    // Of the vertices that makeTangents appends, those that they are copies of
    std::vector<uint32_t> twins;
};

/// Triangles of a list, strip or fan of `count` vertices or indices. `indices` may be null: 0, 1,
/// 2, ... A rest of less than a triangle is left out.
std::vector<glm::uvec3> assembleTriangles(uint64_t mode, const uint32_t* indices, size_t count);

/// Removes triangles with a vertex that is not finite or beyond 1e18; returns how many.
size_t dropNonFinite(Primitive& primitive);

/// Makes normals unit length; those without a direction become the area-weighted normal of their
/// faces. Returns how many had to be replaced; `rescaled` counts those of a wrong length.
size_t repairNormals(Primitive& primitive, double tolerance, size_t& rescaled);

/// Tangents from texture coordinates: per vertex the direction of growing u, averaged over its
/// triangles weighted by angle. Vertices between triangles of different handedness (mirrored
/// halves) are doubled, as Mikkelsen's "Simulation of Wrinkled Surfaces Revisited" (2008) has it;
/// unlike his reference code, vertices are joined where the file joins them and nowhere else.
void makeTangents(Primitive& primitive, const std::vector<glm::vec2>& uv);

/// Replaces tangents that are not finite, zero or parallel to the normal by an arbitrary one.
/// Returns how many.
size_t repairTangents(Primitive& primitive);

/// The mesh in the form that renderers read; `primitive` is consumed.
Mesh packMesh(Primitive&& primitive);

}  // namespace core::gltf
