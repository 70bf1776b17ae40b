// Vertices and triangles of meshes in the space of a world; see world_geometry.h.
#include "core/scene/world_geometry.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/parallel.h"
#include "shared/warp.h"

namespace core {

namespace {

/// A triangle's normal can be made in single precision exactly as renderers make it.
bool hasNormal(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c)
{
    const glm::vec3 n = glm::cross(b - a, c - a);
    const float length2 = glm::dot(n, n);
    return length2 > 1e-36f && length2 < 1e36f;
}

uint32_t packedNormal(const glm::dmat3& normalMatrix, uint32_t packed)
{
    if (packed == shared::kNoNormal) return packed;
    return core::packedNormal(normalMatrix * glm::dvec3(shared::unpackOct(packed)));
}

uint32_t packedTangent(const glm::dmat3& matrix, double mirror, uint32_t packed)
{
    const glm::vec4 unpacked = shared::unpackTangent(packed);
    const glm::dvec3 t = matrix * glm::dvec3(unpacked.x, unpacked.y, unpacked.z);
    const double length = glm::length(t);
    if (!(length > 0) || !std::isfinite(length)) return packed;
    return shared::packTangent(glm::vec3(t / length), static_cast<float>(mirror) * unpacked.w);
}

shared::VertexAttributes mappedAttributes(const Mesh& mesh, size_t v, const Mapping& mapping,
                                          const Stored& stored)
{
    shared::VertexAttributes a{shared::kNoNormal, 0, 0, 0};
    if (mesh.attributes.empty()) return a;
    a = mesh.attributes[v];
    a.normal = stored.normals && mesh.hasNormals ? packedNormal(mapping.normals, a.normal)
                                                 : shared::kNoNormal;
    if (stored.tangents)
        a.tangent = packedTangent(mapping.linear, mapping.mirrored ? -1 : 1, a.tangent);
    return a;
}

}  // namespace

uint32_t packedNormal(const glm::dvec3& n)
{
    const double length = glm::length(n);
    if (!(length > 0) || !std::isfinite(length)) return shared::kNoNormal;
    return shared::packOct(glm::vec3(n / length));
}

Mapping::Mapping(const Instance& instance, const Placement& placement)
    : toWorld(glm::dmat4(instance.toFile()))
{
    toWorld[3] = glm::dvec4(glm::dvec3(toWorld[3]) - placement.centre, 1);
    for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 3; ++row) toWorld[column][row] *= placement.scale;
    }
    linear = glm::dmat3(toWorld);
    mirrored = glm::determinant(linear) < 0;
    normals = cofactors(linear) * (mirrored ? -1.0 : 1.0);
}

Mapping::Mapping(const glm::dmat4& matrix, bool mirrors)
    : toWorld(matrix), linear(matrix), normals(cofactors(linear)), mirrored(mirrors)
{}

void appendVertices(Geometry& geometry, const Mesh& mesh, const Mapping& mapping,
                    const Stored& stored)
{
    const size_t first = geometry.positions.size(), count = mesh.positions.size();
    geometry.positions.resize(first + count);
    if (stored.attributes) geometry.attributes.resize(first + count);
    parallelFor(count, 1 << 14, [&](size_t begin, size_t end) {
        for (size_t v = begin; v < end; ++v) {
            geometry.positions[first + v] = mapping.point(mesh.positions[v]);
            if (stored.attributes)
                geometry.attributes[first + v] = mappedAttributes(mesh, v, mapping, stored);
        }
    });
    appendExtra(geometry, mesh, stored);
}

void appendExtra(Geometry& geometry, const Mesh& mesh, const Stored& stored)
{
    if (!stored.extra) return;
    const size_t count = mesh.positions.size();
    const shared::VertexExtra white{0, 0, 0x3c003c00u, 0x3c003c00u};
    if (mesh.extra.empty()) {
        geometry.extra.insert(geometry.extra.end(), count, white);
    } else {
        geometry.extra.insert(geometry.extra.end(), mesh.extra.begin(), mesh.extra.end());
    }
}

Dropped appendTriangles(Geometry& geometry, const Mesh& mesh, bool mirrored, uint32_t first,
                        Extent& extent)
{
    Dropped dropped;
    const uint32_t shift = geometry.firstVertex + first;
    for (const glm::uvec3& t : mesh.triangles) {
        const glm::vec3 a = geometry.positions[first + t.x], b = geometry.positions[first + t.y],
                        c = geometry.positions[first + t.z];
        if (!isFinite(a) || !isFinite(b) || !isFinite(c)) {
            ++dropped.notFinite;
        } else if (!(mirrored ? hasNormal(a, c, b) : hasNormal(a, b, c))) {
            ++dropped.degenerate;
        } else {
            WorldTriangle w{shift + t.x, shift + t.y, shift + t.z,
                            static_cast<uint32_t>(mesh.material)};
            if (mirrored) std::swap(w.v1, w.v2);
            geometry.triangles.push_back(w);
            extent.add(a, b, c);
        }
    }
    return dropped;
}

}  // namespace core
