// Every use of every mesh written out into one list of triangles, in double until the last step.
// Placement follows Waechter and Binder's offset, which is at its best for coordinates near one:
// recentred, and rescaled by a power of two (so that no bit changes) where the scene is very small
// or very large.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/check.h"
#include "core/scene/world_parts.h"
#include "shared/warp.h"

namespace core {

namespace {

bool isFinite(const glm::dvec3& v)
{
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Transposed matrix of cofactors: takes normals as the matrix takes points; works without an
/// inverse.
glm::dmat3 cofactors(const glm::dmat3& m)
{
    return {glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1])};
}

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
    const glm::dvec3 n = normalMatrix * glm::dvec3(shared::unpackOct(packed));
    const double length = glm::length(n);
    if (!(length > 0) || !std::isfinite(length)) return shared::kNoNormal;
    return shared::packOct(glm::vec3(n / length));
}

uint32_t packedTangent(const glm::dmat3& matrix, double mirror, uint32_t packed)
{
    const glm::vec4 unpacked = shared::unpackTangent(packed);
    const glm::dvec3 t = matrix * glm::dvec3(unpacked.x, unpacked.y, unpacked.z);
    const double length = glm::length(t);
    if (!(length > 0) || !std::isfinite(length)) return packed;
    return shared::packTangent(glm::vec3(t / length), static_cast<float>(mirror) * unpacked.w);
}

/// What an instance does to points, normals and handedness.
struct Mapping {
    glm::dmat4 toWorld;
    glm::dmat3 linear, normals;
    bool mirrored;

    Mapping(const Instance& instance, const Placement& placement)
    {
        toWorld = instance.toFile;
        toWorld[3] = glm::dvec4(glm::dvec3(toWorld[3]) - placement.centre, 1);
        for (int column = 0; column < 4; ++column) {
            for (int row = 0; row < 3; ++row) toWorld[column][row] *= placement.scale;
        }
        linear = glm::dmat3(toWorld);
        mirrored = glm::determinant(linear) < 0;
        normals = cofactors(linear) * (mirrored ? -1.0 : 1.0);
    }

    glm::vec3 point(const glm::vec3& p) const
    {
        return glm::vec3(glm::dvec3(toWorld * glm::dvec4(glm::dvec3(p), 1)));
    }
};

void appendVertices(World& world, const Mesh& mesh, const Mapping& mapping, bool attributes,
                    bool extra)
{
    for (const glm::vec3& p : mesh.positions) world.positions.push_back(mapping.point(p));
    if (attributes) {
        const bool normals =
            mesh.hasNormals && (world.features & shared::kFeatureShadingNormals) != 0;
        const bool tangents = (world.features & shared::kFeatureNormalMaps) != 0;
        for (size_t v = 0; v < mesh.positions.size(); ++v) {
            shared::VertexAttributes a{shared::kNoNormal, 0, 0, 0};
            if (!mesh.attributes.empty()) {
                a = mesh.attributes[v];
                a.normal = normals ? packedNormal(mapping.normals, a.normal) : shared::kNoNormal;
                if (tangents)
                    a.tangent = packedTangent(mapping.linear, mapping.mirrored ? -1 : 1, a.tangent);
            }
            world.attributes.push_back(a);
        }
    }
    if (extra) {
        const shared::VertexExtra white{0, 0, 0x3c003c00u, 0x3c003c00u};
        if (mesh.extra.empty()) {
            world.extra.insert(world.extra.end(), mesh.positions.size(), white);
        } else {
            world.extra.insert(world.extra.end(), mesh.extra.begin(), mesh.extra.end());
        }
    }
}

struct Dropped {
    uint64_t degenerate = 0, notFinite = 0;
};

Dropped appendTriangles(World& world, const Mesh& mesh, bool mirrored, uint32_t firstVertex)
{
    Dropped dropped;
    for (const glm::uvec3& t : mesh.triangles) {
        WorldTriangle w{firstVertex + t.x, firstVertex + t.y, firstVertex + t.z,
                        static_cast<uint32_t>(mesh.material)};
        if (mirrored) std::swap(w.v1, w.v2);
        const glm::vec3 a = world.positions[w.v0], b = world.positions[w.v1],
                        c = world.positions[w.v2];
        if (!isFinite(a) || !isFinite(b) || !isFinite(c)) {
            ++dropped.notFinite;
        } else if (!hasNormal(a, b, c)) {
            ++dropped.degenerate;
        } else {
            world.triangles.push_back(w);
            world.boundsLow = glm::min(world.boundsLow, glm::min(a, glm::min(b, c)));
            world.boundsHigh = glm::max(world.boundsHigh, glm::max(a, glm::max(b, c)));
        }
    }
    return dropped;
}

void reserve(World& world, const Scene& scene, const std::vector<Instance>& instances,
             bool attributes, bool extra)
{
    uint64_t vertices = 0, triangles = 0;
    for (const Instance& instance : instances) {
        const Mesh& mesh = scene.meshes[static_cast<size_t>(instance.mesh)];
        vertices += mesh.positions.size();
        triangles += mesh.triangles.size();
    }
    if (3 * triangles > (1ull << 31) || vertices > (1ull << 31)) {
        throw Error(scene.file.string() + ": " + std::to_string(triangles) + " triangles and " +
                    std::to_string(vertices) +
                    " vertices once instances are written out, at most 2^31 indices fit — use "
                    "fewer instances");
    }
    world.positions.reserve(vertices + 1);
    world.triangles.reserve(triangles);
    if (attributes) world.attributes.reserve(vertices + 1);
    if (extra) world.extra.reserve(vertices + 1);
}

void report(Warnings& warnings, const Scene& scene, const Instance& instance,
            const Dropped& dropped)
{
    const std::string where = nodePointer(instance.node);
    const std::string& name = scene.meshes[static_cast<size_t>(instance.mesh)].name;
    if (dropped.degenerate > 0) {
        warnings.add("TRIANGLES_DEGENERATE", where,
                     std::to_string(dropped.degenerate) + " triangles of mesh '" + name +
                         "' have no area — dropped");
    }
    if (dropped.notFinite > 0) {
        warnings.add("TRIANGLES_NOT_FINITE", where,
                     std::to_string(dropped.notFinite) + " triangles of mesh '" + name +
                         "' have a vertex that is not finite — dropped");
    }
}

}  // namespace

std::vector<Instance> findInstances(const Scene& scene, const Pose& pose, Warnings& warnings)
{
    std::vector<Instance> instances;
    for (const int n : pose.order) {
        const Node& node = scene.nodes[static_cast<size_t>(n)];
        if (node.meshes.empty()) continue;
        const glm::dmat4& toFile = pose.toFile[static_cast<size_t>(n)];
        const glm::dmat3 normals = cofactors(glm::dmat3(toFile));
        const double size = glm::dot(normals[0], normals[0]) + glm::dot(normals[1], normals[1]) +
                            glm::dot(normals[2], normals[2]);
        const bool finite = std::isfinite(size) && isFinite(glm::dvec3(toFile[3]));
        if (!finite || !(size > 0)) {
            warnings.add(
                finite ? "NODE_SCALE_ZERO" : "NODE_NOT_FINITE", nodePointer(n),
                finite ? "scale is zero along two axes or more: nothing to see — instance dropped"
                       : "transform is not finite — instance dropped");
            continue;
        }
        for (const int mesh : node.meshes) {
            if (mesh >= 0 && static_cast<size_t>(mesh) < scene.meshes.size()) {
                instances.push_back({mesh, n, toFile});
            }
        }
    }
    return instances;
}

Placement placeScene(const Scene& scene, const std::vector<Instance>& instances)
{
    const double infinity = std::numeric_limits<double>::infinity();
    glm::dvec3 low(infinity), high(-infinity);
    std::vector<bool> used;
    for (const Instance& instance : instances) {
        const Mesh& mesh = scene.meshes[static_cast<size_t>(instance.mesh)];
        used.assign(mesh.positions.size(), false);
        for (const glm::uvec3& t : mesh.triangles) used[t.x] = used[t.y] = used[t.z] = true;
        for (size_t v = 0; v < mesh.positions.size(); ++v) {
            if (!used[v]) continue;
            const glm::dvec3 p(instance.toFile * glm::dvec4(glm::dvec3(mesh.positions[v]), 1));
            if (!isFinite(p)) continue;
            low = glm::min(low, p);
            high = glm::max(high, p);
        }
    }
    Placement placement;
    if (!(low.x <= high.x)) return placement;
    const double radius = 0.5 * glm::length(high - low);
    if (!(radius > 0) || !std::isfinite(radius)) return placement;
    // A centre of few bits: subtracting it leaves round coordinates round.
    const double grain = std::exp2(std::floor(std::log2(radius)) - 6);
    placement.centre = glm::round(0.5 * (low + high) / grain) * grain;
    if (radius < 1) placement.scale = std::exp2(std::ceil(-std::log2(radius)));
    if (radius > 100) placement.scale = std::exp2(std::floor(std::log2(100 / radius)));
    return placement;
}

void flattenInstances(World& world, const Scene& scene, const std::vector<Instance>& instances)
{
    const uint32_t needAttributes =
        shared::kFeatureShadingNormals | shared::kFeatureTextures | shared::kFeatureNormalMaps;
    const bool extra = (world.features & shared::kFeatureVertexExtra) != 0;
    const bool attributes = extra || (world.features & needAttributes) != 0;
    reserve(world, scene, instances, attributes, extra);
    const float infinity = std::numeric_limits<float>::infinity();
    world.boundsLow = glm::vec3(infinity);
    world.boundsHigh = glm::vec3(-infinity);
    for (const Instance& instance : instances) {
        const Mesh& mesh = scene.meshes[static_cast<size_t>(instance.mesh)];
        const Mapping mapping(instance, world.placement);
        const uint32_t firstVertex = static_cast<uint32_t>(world.positions.size());
        appendVertices(world, mesh, mapping, attributes, extra);
        const Dropped dropped = appendTriangles(world, mesh, mapping.mirrored, firstVertex);
        report(world.warnings, scene, instance, dropped);
    }
    // Embree reads 16 bytes per vertex: one more keeps the last read inside the array.
    world.positions.emplace_back(0.0f);
    if (attributes) world.attributes.push_back({shared::kNoNormal, 0, 0, 0});
    if (extra) world.extra.push_back({0, 0, 0x3c003c00u, 0x3c003c00u});

    if (world.triangles.empty()) {
        world.boundsLow = world.boundsHigh = glm::vec3(0);
        return;
    }
    float radius2 = 0;
    for (const WorldTriangle& t : world.triangles) {
        for (const uint32_t v : {t.v0, t.v1, t.v2}) {
            radius2 = std::max(radius2, glm::dot(world.positions[v], world.positions[v]));
        }
    }
    world.radius = std::sqrt(radius2) * 1.00001f;
}

}  // namespace core
