// Where meshes are used, and where the world lies around them. Placement follows Waechter and
// Binder's offset, which is at its best for coordinates near one: recentred, and rescaled by a
// power of two (so that no bit changes) where the scene is very small or very large.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/check.h"
#include "core/scene/deformation.h"
#include "core/scene/features.h"
#include "core/scene/world_geometry.h"

namespace core {

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

void Extent::addPoint(const glm::vec3& p)
{
    low = glm::min(low, p);
    high = glm::max(high, p);
    radius2 = std::max(radius2, glm::dot(p, p));
}

std::array<glm::vec3, 8> Extent::corners() const
{
    std::array<glm::vec3, 8> points;
    for (size_t i = 0; i < 8; ++i)
        points[i] = {i & 1 ? low.x : high.x, i & 2 ? low.y : high.y, i & 4 ? low.z : high.z};
    return points;
}

glm::dmat4x3 Instance::toFile() const
{
    if (placement == nullptr) return *nodeToFile;
    glm::dmat4 local = glm::dmat4(glm::mat3_cast(glm::dquat(placement->rotation)));
    for (int column = 0; column < 3; ++column)
        local[column] *= static_cast<double>(placement->scale[column]);
    local[3] = glm::dvec4(glm::dvec3(placement->translation), 1);
    return *nodeToFile * local;
}

namespace {

/// Whether there is something to see; warns where not.
bool isShown(const Scene& scene, const Instance& instance, Warnings& warnings)
{
    const glm::dmat4x3 toFile = instance.toFile();
    const glm::dmat3 normals = cofactors(glm::dmat3(toFile));
    const double size = glm::dot(normals[0], normals[0]) + glm::dot(normals[1], normals[1]) +
                        glm::dot(normals[2], normals[2]);
    const bool finite = std::isfinite(size) && isFinite(glm::dvec3(toFile[3]));
    if (finite && size > 0) return true;
    warnings.add(finite ? "NODE_SCALE_ZERO" : "NODE_NOT_FINITE",
                 nodePointer(scene, static_cast<size_t>(instance.node)),
                 finite ? "scale is zero along two axes or more: nothing to see — instance dropped"
                        : "transform is not finite — instance dropped");
    return false;
}

size_t usesOfMeshes(const Scene& scene)
{
    size_t uses = 0;
    for (const Node& node : scene.nodes) {
        const auto places = static_cast<size_t>(node.placements);
        uses += node.meshes.size() * (node.placements < 0 ? 1 : scene.placements[places].size());
    }
    return uses;
}

}  // namespace

std::vector<Instance> findInstances(const Scene& scene, const Pose& pose, Warnings& warnings)
{
    std::vector<Instance> instances;
    instances.reserve(usesOfMeshes(scene));  // growing takes twice the memory
    const DeformingUses deforming(scene);
    for (size_t i = 0; i < scene.nodes.size(); ++i) {
        const Node& node = scene.nodes[i];
        if (node.meshes.empty()) continue;
        CHECK(node.meshes.end <= scene.meshes.size());
        const auto n = static_cast<int>(i);
        Instance instance{0, n, deforming.moves(n), false, &pose.toFile[i], nullptr};
        const auto addMeshes = [&] {
            std::optional<bool> shown;  // of what is where the node is
            for (uint32_t mesh = node.meshes.begin; mesh < node.meshes.end; ++mesh) {
                instance.mesh = static_cast<int>(mesh);
                const Instance use = deforming.of(instance);
                const bool apart = use.nodeToFile != instance.nodeToFile;
                if (!apart && !shown) shown = isShown(scene, instance, warnings);
                if (apart || *shown) instances.push_back(use);
            }
        };
        if (node.placements < 0) {
            addMeshes();
            continue;
        }
        for (const MeshPlacement& p : scene.placements[static_cast<size_t>(node.placements)]) {
            instance.placement = &p;
            addMeshes();
        }
    }
    return instances;
}

namespace {

/// The vertices that triangles use, or the corners of their bounds.
std::vector<glm::vec3> usedPoints(const Mesh& mesh, bool corners)
{
    std::vector<bool> used(mesh.positions.size(), false);
    for (const glm::uvec3& t : mesh.triangles) used[t.x] = used[t.y] = used[t.z] = true;
    std::vector<glm::vec3> points;
    Extent box;
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
        if (!used[v] || !isFinite(glm::dvec3(mesh.positions[v]))) continue;
        points.push_back(mesh.positions[v]);
        box.addPoint(mesh.positions[v]);
    }
    if (!corners || points.size() <= 8) return points;
    const std::array<glm::vec3, 8> eight = box.corners();
    return {eight.begin(), eight.end()};
}

}  // namespace

Placement placeScene(const Scene& scene, const std::vector<Instance>& instances, const Pose& pose)
{
    constexpr uint64_t kMostVertices = 1 << 24;  // to look at one by one: a tenth of a second
    uint64_t vertices = 0;
    for (const Instance& instance : instances)
        vertices += scene.meshes[static_cast<size_t>(instance.mesh)].positions.size();
    const double infinity = std::numeric_limits<double>::infinity();
    glm::dvec3 low(infinity), high(-infinity);
    const auto add = [&](const glm::dvec3& p) {
        if (!isFinite(p)) return;
        low = glm::min(low, p);
        high = glm::max(high, p);
    };
    std::vector<std::optional<std::vector<glm::vec3>>> points(scene.meshes.size());
    for (const Instance& instance : instances) {
        const auto index = static_cast<size_t>(instance.mesh);
        if (instance.deforms) {
            const std::vector<glm::dvec3> deformed = deformedPositions(scene, instance, pose);
            for (const glm::uvec3& t : scene.meshes[index].triangles)
                for (int k = 0; k < 3; ++k) add(deformed[t[k]]);
            continue;
        }
        if (!points[index])
            points[index] = usedPoints(scene.meshes[index], vertices > kMostVertices);
        const glm::dmat4x3 toFile = instance.toFile();
        for (const glm::vec3& point : *points[index])
            add(glm::dvec3(toFile * glm::dvec4(glm::dvec3(point), 1)));
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
    const auto place = [&](const Instance& instance) {
        const Mesh& mesh = scene.meshes[static_cast<size_t>(instance.mesh)];
        const Material& material = scene.materials[static_cast<size_t>(mesh.material)];
        const bool tested = alpha && hasAlphaTest(material.data);
        return tested ? (instance.moves ? 2 : 3) : (instance.moves ? 1 : 0);
    };
    const auto before = [&](const Instance& a, const Instance& b) { return place(a) < place(b); };
    if (!std::ranges::is_sorted(instances, before))  // sorting takes as much memory again
        std::ranges::stable_sort(instances, before);
}

}  // namespace core
