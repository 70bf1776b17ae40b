// Every use of every mesh written out into one list of triangles, in double until the last step.
// Placement follows Waechter and Binder's offset, which is at its best for coordinates near one:
// recentred, and rescaled by a power of two (so that no bit changes) where the scene is very small
// or very large.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "core/base/check.h"
#include "core/base/parallel.h"
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
        toWorld = glm::dmat4(*instance.toFile);
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
    if (!stored.extra) return;
    const shared::VertexExtra white{0, 0, 0x3c003c00u, 0x3c003c00u};
    if (mesh.extra.empty()) {
        geometry.extra.insert(geometry.extra.end(), count, white);
    } else {
        geometry.extra.insert(geometry.extra.end(), mesh.extra.begin(), mesh.extra.end());
    }
}

/// Appends the triangles of a mesh whose vertices begin at `first` in the piece.
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

Dropped appendInstance(Geometry& geometry, const Scene& scene, const Instance& instance,
                       const Placement& placement, const Stored& stored, Extent& extent)
{
    const Mesh& mesh = scene.meshes[static_cast<size_t>(instance.mesh)];
    const Mapping mapping(instance, placement);
    const uint32_t first = geometry.vertexCount();
    appendVertices(geometry, mesh, mapping, stored);
    return appendTriangles(geometry, mesh, mapping.mirrored, first, extent);
}

void reserve(Geometry& geometry, const Scene& scene, const std::vector<Instance>& instances,
             const Stored& stored)
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
    geometry.positions.reserve(vertices + 1);
    geometry.triangles.reserve(triangles);
    if (stored.attributes) geometry.attributes.reserve(vertices + 1);
    if (stored.extra) geometry.extra.reserve(vertices + 1);
}

/// Puts `values` in the place of array[range], unless they are there already.
template <class T>
void replacePiece(SharedArray<T>& array, IndexRange range, const std::vector<T>& values)
{
    if (values.empty() ||
        std::memcmp(array.data() + range.begin, values.data(), values.size() * sizeof(T)) == 0)
        return;
    std::vector<T> changed = array.toVector();
    std::copy(values.begin(), values.end(), changed.begin() + range.begin);
    array = std::move(changed);
}

std::vector<glm::dmat4> movingTransforms(const std::vector<Instance>& instances)
{
    std::vector<glm::dmat4> transforms;
    for (const Instance& instance : instances) {
        if (instance.moves) transforms.emplace_back(*instance.toFile);
    }
    return transforms;
}

/// Bounds and radius of everything.
void setBounds(World& world, const Extent& extent)
{
    world.boundsLow = world.boundsHigh = glm::vec3(0);
    world.radius = 1;
    if (extent.empty()) return;
    world.boundsLow = extent.low;
    world.boundsHigh = extent.high;
    world.radius = std::sqrt(extent.radius2) * 1.00001f;
}

/// Where the moving instances are at samples of the animation's time, by the corners of their
/// meshes' bounds. What lies between samples may leave it: nothing depends on it but how well a
/// grid that is laid over it fits.
Extent findReach(const Scene& scene, const std::vector<Instance>& instances,
                 const Placement& placement)
{
    constexpr int kSamples = 32;
    Extent reach;
    std::vector<std::pair<Instance, Extent>> moving;
    for (const Instance& instance : instances) {
        if (!instance.moves) continue;
        Extent box;
        for (const glm::vec3& p : scene.meshes[static_cast<size_t>(instance.mesh)].positions) {
            if (isFinite(glm::dvec3(p))) box.add(p, p, p);
        }
        if (!box.empty()) moving.emplace_back(instance, box);
    }
    const double duration = scene.animations.empty() ? 0 : scene.animations.front().duration;
    for (int i = 0; i <= kSamples && !moving.empty(); ++i) {
        const Pose pose = poseAt(scene, duration * i / kSamples);
        for (auto& [instance, box] : moving) {
            instance.toFile = &pose.toFile[static_cast<size_t>(instance.node)];
            const Mapping mapping(instance, placement);
            for (int corner = 0; corner < 8; ++corner) {
                const glm::vec3 p = mapping.point({corner & 1 ? box.low.x : box.high.x,
                                                   corner & 2 ? box.low.y : box.high.y,
                                                   corner & 4 ? box.low.z : box.high.z});
                if (isFinite(glm::dvec3(p))) reach.add(p, p, p);
            }
        }
    }
    return reach;
}

}  // namespace

void Extent::add(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c)
{
    low = glm::min(low, glm::min(a, glm::min(b, c)));
    high = glm::max(high, glm::max(a, glm::max(b, c)));
    radius2 = std::max({radius2, glm::dot(a, a), glm::dot(b, b), glm::dot(c, c)});
    const glm::vec3 ab = b - a, bc = c - b, ca = a - c;
    // By the longest edge: a sliver is as thin as it should be, to within what nobody sees.
    const float longest2 = std::max({glm::dot(ab, ab), glm::dot(bc, bc), glm::dot(ca, ca)});
    const glm::vec3 far = glm::max(glm::abs(a), glm::max(glm::abs(b), glm::abs(c)));
    const float place = std::max({far.x, far.y, far.z});
    rough += longest2 * 0x1p40f < place * place ? 1 : 0;
}

void Extent::add(const Extent& other)
{
    low = glm::min(low, other.low);
    high = glm::max(high, other.high);
    radius2 = std::max(radius2, other.radius2);
    rough += other.rough;
}

std::vector<Instance> findInstances(const Scene& scene, const Pose& pose, Warnings& warnings)
{
    std::vector<Instance> instances;
    const std::vector<bool> moves = movingNodes(scene);
    for (const int n : pose.order) {
        const Node& node = scene.nodes[static_cast<size_t>(n)];
        if (node.meshes.empty()) continue;
        const glm::dmat4x3& toFile = pose.toFile[static_cast<size_t>(n)];
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
                instances.push_back({mesh, n, moves[static_cast<size_t>(n)], &toFile});
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
            const glm::dvec3 p(*instance.toFile * glm::dvec4(glm::dvec3(mesh.positions[v]), 1));
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

void orderInstances(const Scene& scene, bool alpha, std::vector<Instance>& instances)
{
    const uint32_t flags = shared::kMaterialAlphaMask | shared::kMaterialAlphaBlend;
    const auto place = [&](const Instance& instance) {
        const Mesh& mesh = scene.meshes[static_cast<size_t>(instance.mesh)];
        const Material& material = scene.materials[static_cast<size_t>(mesh.material)];
        const bool tested = alpha && (material.data.flags & flags) != 0;
        return tested ? (instance.moves ? 2 : 3) : (instance.moves ? 1 : 0);
    };
    std::stable_sort(instances.begin(), instances.end(),
                     [&](const Instance& a, const Instance& b) { return place(a) < place(b); });
}

Extent flattenInstances(World& world, Topology& topology, const Scene& scene,
                        std::vector<Instance> instances)
{
    const Stored stored(world.features);
    Geometry geometry;
    reserve(geometry, scene, instances, stored);
    Extent moving;
    std::vector<IndexRange> pieces;
    topology.dropped.reserve(instances.size());
    for (const Instance& instance : instances) {
        const uint32_t vertex = geometry.vertexCount(), triangle = geometry.triangleCount();
        topology.dropped.push_back(appendInstance(geometry, scene, instance, world.placement,
                                                  stored,
                                                  instance.moves ? moving : topology.still));
        if (!instance.moves) continue;
        if (world.movingVertices.empty()) {
            world.movingVertices.begin = vertex;
            world.movingTriangles.begin = triangle;
        }
        world.movingVertices.end = geometry.vertexCount();
        world.movingTriangles.end = geometry.triangleCount();
        if (triangle < geometry.triangleCount())
            pieces.push_back({triangle, geometry.triangleCount()});
    }
    // Embree reads 16 bytes per vertex: one more keeps the last read inside the array.
    geometry.positions.emplace_back(0.0f);
    if (stored.attributes) geometry.attributes.push_back({shared::kNoNormal, 0, 0, 0});
    if (stored.extra) geometry.extra.push_back({0, 0, 0x3c003c00u, 0x3c003c00u});
    world.positions = std::move(geometry.positions);
    world.attributes = std::move(geometry.attributes);
    world.extra = std::move(geometry.extra);
    world.triangles = std::move(geometry.triangles);
    world.movingPieces = std::move(pieces);
    world.movingTransforms = movingTransforms(instances);
    if (!moving.empty()) {
        Extent reach = findReach(scene, instances, world.placement);
        reach.add(moving);
        world.reachLow = reach.low;
        world.reachHigh = reach.high;
    }
    for (Instance& instance : instances) instance.toFile = nullptr;
    topology.instances = std::move(instances);
    Extent extent = topology.still;
    extent.add(moving);
    setBounds(world, extent);
    return extent;
}

std::optional<Extent> moveInstances(World& world, const Scene& scene,
                                    const std::vector<Instance>& instances)
{
    const Topology& topology = *world.topology;
    const Stored stored(topology.fixedFeatures);
    Geometry piece;
    piece.firstVertex = world.movingVertices.begin;
    piece.positions.reserve(world.movingVertices.size());
    piece.triangles.reserve(world.movingTriangles.size());
    Extent moving;
    for (size_t i = 0; i < instances.size(); ++i) {
        if (!instances[i].moves) continue;
        const Dropped dropped =
            appendInstance(piece, scene, instances[i], world.placement, stored, moving);
        if (dropped != topology.dropped[i]) return std::nullopt;
    }
    const auto sameTriangle = [](const WorldTriangle& a, const WorldTriangle& b) {
        return a.v0 == b.v0 && a.v1 == b.v1 && a.v2 == b.v2;  // of one mesh, so of one material
    };
    if (!std::equal(piece.triangles.begin(), piece.triangles.end(),
                    world.triangles.begin() + world.movingTriangles.begin,
                    world.triangles.begin() + world.movingTriangles.end, sameTriangle))
        return std::nullopt;

    replacePiece(world.positions, world.movingVertices, piece.positions);
    replacePiece(world.attributes, world.movingVertices, piece.attributes);
    replaceIfChanged(world.movingTransforms, movingTransforms(instances));
    Extent extent = topology.still;
    extent.add(moving);
    setBounds(world, extent);
    return extent;
}

void warnAboutDropped(Warnings& warnings, const Scene& scene, const Topology& topology)
{
    for (size_t i = 0; i < topology.instances.size(); ++i) {
        const Instance& instance = topology.instances[i];
        const Dropped& dropped = topology.dropped[i];
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
}

}  // namespace core
