// Triangles written out as the arrays of a world hold them. Private to world*.cpp.
#pragma once

#include <cmath>
#include <vector>

#include "core/scene/world_parts.h"

namespace core {

inline bool isFinite(const glm::dvec3& v)
{
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Transposed matrix of cofactors: takes normals as the matrix takes points; works without an
/// inverse.
inline glm::dmat3 cofactors(const glm::dmat3& m)
{
    return {glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1])};
}

/// What the vertices of a world hold; the features that the scene needs decide.
struct Stored {
    bool attributes, extra, normals, tangents;

    explicit Stored(uint32_t features)
    {
        extra = (features & shared::kFeatureVertexExtra) != 0;
        normals = (features & shared::kFeatureShadingNormals) != 0;
        tangents = (features & shared::kFeatureNormalMaps) != 0;
        attributes = extra || normals || tangents || (features & shared::kFeatureTextures) != 0;
    }
};

/// Instances written out: a piece of a world, or all of it.
struct Geometry {
    uint32_t firstVertex = 0;  // index of the piece's first vertex in the world
    std::vector<glm::vec3> positions;
    std::vector<shared::VertexAttributes> attributes;
    std::vector<shared::VertexExtra> extra;
    std::vector<WorldTriangle> triangles;

    uint32_t vertexCount() const { return static_cast<uint32_t>(positions.size()); }
    uint32_t triangleCount() const { return static_cast<uint32_t>(triangles.size()); }
};

/// Appends the vertices of a mesh.
void appendVertices(Geometry& geometry, const Mesh& mesh, const Mapping& mapping,
                    const Stored& stored);

/// Appends what the world has of the vertices of a mesh in `extra`: no pose changes it.
void appendExtra(Geometry& geometry, const Mesh& mesh, const Stored& stored);

/// The direction of `n` as it is stored; kNoNormal where it has none.
uint32_t packedNormal(const glm::dvec3& n);

/// Appends the triangles of a mesh whose vertices begin at `first` in the piece.
Dropped appendTriangles(Geometry& geometry, const Mesh& mesh, bool mirrored, uint32_t first,
                        Extent& extent);

/// Appends the meshes of the planned prototypes, and fills what the world says of them and of their
/// instances, which belong to the extent of what is still. Throws core::Error when instances show
/// more triangles than slots can name.
void appendPrototypes(World& world, Topology& topology, Geometry& geometry, const Scene& scene,
                      const std::vector<PrototypePlan>& plans, const Stored& stored);

}  // namespace core
