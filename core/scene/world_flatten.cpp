// Every use of every mesh written out into one list of triangles, in double until the last step;
// those that are to be instances are left to appendPrototypes.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

#include "core/base/check.h"
#include "core/scene/deformation.h"
#include "core/scene/world_geometry.h"

namespace core {

namespace {

Dropped appendInstance(Geometry& geometry, const Scene& scene, const Instance& instance,
                       const Pose& pose, const Placement& placement, const Stored& stored,
                       Extent& extent)
{
    const Mesh& mesh = scene.meshes[static_cast<size_t>(instance.mesh)];
    const uint32_t first = geometry.vertexCount();
    if (instance.deforms) {
        const bool mirrored = appendDeformed(geometry, scene, instance, pose, placement, stored);
        return appendTriangles(geometry, mesh, mirrored, first, extent);
    }
    const Mapping mapping(instance, placement);
    appendVertices(geometry, mesh, mapping, stored);
    return appendTriangles(geometry, mesh, mapping.mirrored, first, extent);
}

void reserve(Geometry& geometry, const Scene& scene, const std::vector<Instance>& instances,
             const std::vector<PrototypePlan>& prototypes, const Stored& stored)
{
    uint64_t vertices = 0, triangles = 0;
    const auto count = [&](int index) {
        const Mesh& mesh = scene.meshes[static_cast<size_t>(index)];
        vertices += mesh.positions.size();
        triangles += mesh.triangles.size();
    };
    for (const Instance& instance : instances) count(instance.mesh);
    for (const PrototypePlan& prototype : prototypes)
        for (const int mesh : prototype.meshes) count(mesh);
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

/// Bounds of the vertices, of which the file may have some that are not finite.
Extent boundsOf(const Mesh& mesh)
{
    Extent box;
    for (const glm::vec3& p : mesh.positions)
        if (isFinite(glm::dvec3(p))) box.addPoint(p);
    return box;
}

/// Where the moving instances are at samples of the animation's time, by the corners of their
/// meshes' bounds, of those that deform by those of each joint. What lies between samples may leave
/// it: nothing depends on it but how well a grid that is laid over it fits. So there are fewer
/// samples of very many nodes. They lie in the memory of `pose`, which is made anew then.
Extent findReach(const Scene& scene, const std::vector<Instance>& instances,
                 const Placement& placement, Pose& pose)
{
    constexpr size_t kFewestSamples = 4, kMostSamples = 32,
                     kMostPlaces = 1 << 20;  // in all samples
    std::vector<std::optional<Extent>> boxes(scene.meshes.size());
    std::vector<DeformedBounds> deforming;
    size_t moving = 0;
    for (const Instance& instance : instances) {
        if (!instance.moves) continue;
        ++moving;
        const auto mesh = static_cast<size_t>(instance.mesh);
        if (instance.deforms)
            deforming.emplace_back(scene, instance);
        else if (!boxes[mesh])
            boxes[mesh] = boundsOf(scene.meshes[mesh]);
    }
    Extent reach;
    if (moving == 0) return reach;
    const size_t samples =
        std::clamp(kMostPlaces / (moving + scene.nodes.size()), kFewestSamples, kMostSamples);
    const double duration = scene.animations.empty() ? 0 : scene.animations.front().duration;
    const double time = pose.time;
    for (size_t i = 0; i <= samples; ++i) {
        poseAt(scene, duration * static_cast<double>(i) / static_cast<double>(samples), pose);
        for (const DeformedBounds& bounds : deforming) bounds.add(pose, placement, reach);
        for (const Instance& instance : instances) {  // whose matrices lie in the pose
            if (!instance.moves || instance.deforms) continue;
            const Extent& box = *boxes[static_cast<size_t>(instance.mesh)];
            if (box.empty()) continue;
            const Mapping mapping(instance, placement);
            for (const glm::vec3& corner : box.corners()) {
                const glm::vec3 p = mapping.point(corner);
                if (isFinite(glm::dvec3(p))) reach.addPoint(p);
            }
        }
    }
    poseAt(scene, time, pose);
    return reach;
}

}  // namespace

Extent flattenInstances(World& world, Topology& topology, const Scene& scene, Pose& pose,
                        std::vector<Instance> instances,
                        const std::vector<PrototypePlan>& prototypes)
{
    const Stored stored(world.features);
    Geometry geometry;
    reserve(geometry, scene, instances, prototypes, stored);
    Extent moving;
    std::vector<IndexRange> pieces;
    topology.dropped.reserve(instances.size());
    for (const Instance& instance : instances) {
        const uint32_t vertex = geometry.vertexCount(), triangle = geometry.triangleCount();
        topology.dropped.push_back(appendInstance(geometry, scene, instance, pose, world.placement,
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
    appendPrototypes(world, topology, geometry, scene, prototypes, stored);
    // Embree reads 16 bytes per vertex: one more keeps the last read inside the array.
    geometry.positions.emplace_back(0.0f);
    if (stored.attributes) geometry.attributes.push_back({shared::kNoNormal, 0, 0, 0});
    if (stored.extra) geometry.extra.push_back({0, 0, 0x3c003c00u, 0x3c003c00u});
    world.positions = std::move(geometry.positions);
    world.attributes = std::move(geometry.attributes);
    world.extra = std::move(geometry.extra);
    world.triangles = std::move(geometry.triangles);
    world.movingPieces = std::move(pieces);
    if (!moving.empty()) {
        Extent reach = findReach(scene, instances, world.placement, pose);
        reach.add(moving);
        world.reachLow = reach.low;
        world.reachHigh = reach.high;
    }
    for (Instance& instance : instances) {
        instance.nodeToFile = nullptr;
        instance.placement = nullptr;
    }
    topology.instances = std::move(instances);
    Extent extent = topology.still;
    extent.add(moving);
    setBounds(world, extent);
    return extent;
}

std::optional<Extent> moveInstances(World& world, const Scene& scene, const Pose& pose,
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
            appendInstance(piece, scene, instances[i], pose, world.placement, stored, moving);
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
    Extent extent = topology.still;
    extent.add(moving);
    setBounds(world, extent);
    return extent;
}

namespace {

void warnAbout(Warnings& warnings, const Scene& scene, const Instance& instance,
               const Dropped& dropped)
{
    if (dropped == Dropped{}) return;
    const std::string where = nodePointer(scene, static_cast<size_t>(instance.node));
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

void warnAboutDropped(Warnings& warnings, const Scene& scene, const Topology& topology)
{
    for (size_t i = 0; i < topology.instances.size(); ++i)
        warnAbout(warnings, scene, topology.instances[i], topology.dropped[i]);
    for (const auto& [instance, dropped] : topology.prototypes)
        warnAbout(warnings, scene, instance, dropped);
}

}  // namespace core
