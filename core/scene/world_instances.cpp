// What is stored once and shown by instances: which uses of meshes, in what space, under what
// slots.
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include "core/base/check.h"
#include "core/scene/features.h"
#include "core/scene/instances.h"
#include "core/scene/world_geometry.h"

namespace core {

namespace {

// A triangle takes some 120 bytes on a device and in a hierarchy, an instance about 200. Rays take
// longer through two levels, so all together must be worth it (about 120 MB), and each for itself.
constexpr uint64_t kWorth = 1 << 20;  // triangles less
constexpr uint64_t kWorthEach = kWorth / 64;
constexpr uint64_t kLeastTriangles = 8;

const Mesh& meshOf(const Scene& scene, int mesh)
{
    return scene.meshes[static_cast<size_t>(mesh)];
}

/// Lamps are sampled one by one, and panes looked for apart; what deforms has a shape for every
/// use. All are written out.
bool mayBeInstanced(const Scene& scene, const Mesh& mesh)
{
    const shared::Material& m = scene.materials[static_cast<size_t>(mesh.material)].data;
    const bool shines = m.emissive.x > 0 || m.emissive.y > 0 || m.emissive.z > 0;
    return !shines && !mayBePane(m) && !mesh.deformation && !mesh.triangles.empty();
}

bool hasAlpha(const Scene& scene, const Mesh& mesh)
{
    return hasAlphaTest(scene.materials[static_cast<size_t>(mesh.material)].data);
}

uint64_t triangleCount(const Scene& scene, const PrototypePlan& plan)
{
    uint64_t sum = 0;
    for (const int mesh : plan.meshes) sum += meshOf(scene, mesh).triangles.size();
    return sum;
}

/// A prototype that may be, and its uses, which are looked for where it is worth it.
struct Group {
    PrototypePlan plan;
    uint64_t uses = 0;
};

/// Triangles that need not be stored.
uint64_t saved(const Scene& scene, const Group& group)
{
    return triangleCount(scene, group.plan) * (group.uses - 1);
}

bool isMirrored(const Instance& use)
{
    return glm::determinant(glm::dmat3(use.toFile())) < 0;
}

/// The meshes of a use that may be instances, and whether it mirrors them.
using UsedMeshes = std::pair<std::vector<int>, bool>;

/// Calls take(meshes, use) for the still uses of meshes by one node each.
template <class Take>
void forEachUse(const std::vector<Instance>& uses, const std::vector<bool>& meshes,
                const Take& take)
{
    UsedMeshes key;
    for (size_t i = 0; i < uses.size();) {
        const Instance& here = uses[i];
        const Instance* first = nullptr;  // of those that may be instances
        key.first.clear();
        for (; i < uses.size() && uses[i].node == here.node && uses[i].placement == here.placement;
             ++i) {
            if (!meshes[static_cast<size_t>(uses[i].mesh)]) continue;
            if (first == nullptr) first = &uses[i];
            key.first.push_back(uses[i].mesh);
        }
        if (first == nullptr || first->moves) continue;
        key.second = isMirrored(*first);
        take(key, *first);
    }
}

/// Leaves only what is worth it.
void chooseWorthy(const Scene& scene, Instancing instancing, std::vector<Group>& groups)
{
    std::erase_if(groups, [&](const Group& g) { return saved(scene, g) == 0; });
    if (instancing == Instancing::kept) return;
    uint64_t sum = 0;
    std::erase_if(groups, [&](const Group& g) {
        return saved(scene, g) < kWorthEach || triangleCount(scene, g.plan) < kLeastTriangles;
    });
    for (const Group& g : groups) sum += saved(scene, g);
    if (sum < kWorth) groups.clear();
}

/// Still uses of the same meshes by one node each that are worth it, in the order of the first of
/// them. They are counted before they are listed: a million that stay as they are take memory.
std::vector<PrototypePlan> groupUses(const Scene& scene, const std::vector<Instance>& uses,
                                     const std::vector<bool>& meshes, Instancing instancing)
{
    std::vector<Group> groups;
    std::map<UsedMeshes, size_t> known;
    forEachUse(uses, meshes, [&](const UsedMeshes& key, const Instance&) {
        const auto [entry, isNew] = known.try_emplace(key, groups.size());
        if (isNew) groups.push_back({{key.first, {}, key.second}, 0});
        ++groups[entry->second].uses;
    });
    chooseWorthy(scene, instancing, groups);
    std::vector<PrototypePlan> plans;
    known.clear();
    for (Group& group : groups) {
        known.emplace(UsedMeshes(group.plan.meshes, group.plan.mirrored), plans.size());
        group.plan.instances.reserve(group.uses);
        plans.push_back(std::move(group.plan));
    }
    if (plans.empty()) return plans;
    forEachUse(uses, meshes, [&](const UsedMeshes& key, const Instance& use) {
        const auto entry = known.find(key);
        if (entry != known.end()) plans[entry->second].instances.push_back(use);
    });
    return plans;
}

/// Lays the prototype's space around its meshes, with a radius of about one. Returns the smallest
/// and the largest length of a triangle's normal (twice its area) there.
std::pair<double, double> layOutSpace(const Scene& scene, PrototypePlan& plan)
{
    Extent box;
    for (const int mesh : plan.meshes)
        for (const glm::vec3& p : meshOf(scene, mesh).positions)
            if (isFinite(glm::dvec3(p))) box.addPoint(p);
    if (box.empty()) return {0, 0};
    const glm::dvec3 low(box.low), high(box.high);
    const double radius = 0.5 * glm::length(high - low);
    if (!(radius > 0) || !std::isfinite(radius)) return {0, 0};
    const double scale = std::exp2(std::ceil(std::log2(radius)));
    plan.toMesh = glm::dmat4(scale);
    plan.toMesh[3] = glm::dvec4(0.5 * (low + high), 1);
    double least = std::numeric_limits<double>::infinity(), most = 0;
    for (const int index : plan.meshes) {
        const Mesh& mesh = meshOf(scene, index);
        for (const glm::uvec3& t : mesh.triangles) {
            const glm::dvec3 a(mesh.positions[t.x]);
            const glm::dvec3 e1 = glm::dvec3(mesh.positions[t.y]) - a;
            const glm::dvec3 e2 = glm::dvec3(mesh.positions[t.z]) - a;
            const double length = glm::length(glm::cross(e1, e2)) / (scale * scale);
            if (length > 1e-18) least = std::min(least, length);  // others are dropped
            most = std::max(most, std::isfinite(length) ? length : most);
        }
    }
    return {least, most};
}

/// Whether single precision suffices for the instance: its matrix has an inverse that does not
/// cancel, and each of its triangles keeps a normal (Extent's hasNormal, with a margin).
bool isSound(const PrototypePlan& plan, const Instance& use, const Placement& placement,
             std::pair<double, double> normals)
{
    const glm::dmat4 matrix = Mapping(use, placement).toWorld * plan.toMesh;
    const glm::dmat3 linear(matrix);
    const double size = std::sqrt(glm::dot(linear[0], linear[0]) + glm::dot(linear[1], linear[1]) +
                                  glm::dot(linear[2], linear[2]));
    const double volume = std::abs(glm::determinant(linear));
    const bool round = volume > 1e-6 * size * size * size;
    return round && std::isfinite(size) && normals.first * volume / size > 1e-17 &&
           normals.second * size * size < 1e17;
}

shared::InstanceMatrix record(const glm::dmat4& m)
{
    const glm::mat4 rows = glm::transpose(glm::mat4(m));
    return {rows[0], rows[1], rows[2]};
}

[[noreturn]] void throwTooMany(const World& world, const Scene& scene)
{
    throw Error(scene.file.string() + ": " + std::to_string(shownTriangles(world)) +
                " triangles are shown by instances, of which four billion have numbers — use "
                "fewer instances");
}

}  // namespace

bool InstancePlan::holds(const Instance& use) const
{
    if (upright.empty() || !meshes[static_cast<size_t>(use.mesh)]) return false;
    return (isMirrored(use) ? mirrored : upright)[static_cast<size_t>(use.node)];
}

InstancePlan planInstances(const Scene& scene, const std::vector<Instance>& uses,
                           const Placement& placement, Instancing instancing, bool alpha)
{
    InstancePlan plan;
    if (instancing == Instancing::flat) return plan;
    for (const Mesh& mesh : scene.meshes) plan.meshes.push_back(mayBeInstanced(scene, mesh));
    std::vector<PrototypePlan> groups = groupUses(scene, uses, plan.meshes, instancing);
    for (PrototypePlan& group : groups) {
        const std::pair<double, double> normals = layOutSpace(scene, group);
        std::vector<int> unsound;  // nodes, of which then nothing is an instance
        for (const Instance& use : group.instances)
            if (!isSound(group, use, placement, normals)) unsound.push_back(use.node);
        std::sort(unsound.begin(), unsound.end());
        std::erase_if(group.instances, [&](const Instance& use) {
            return std::binary_search(unsound.begin(), unsound.end(), use.node);
        });
        std::stable_partition(group.meshes.begin(), group.meshes.end(), [&](int mesh) {
            return !alpha || !hasAlpha(scene, meshOf(scene, mesh));
        });
    }
    std::erase_if(groups, [&](const PrototypePlan& g) { return g.instances.size() < 2; });
    if (groups.empty()) return {};
    plan.upright.assign(scene.nodes.size(), false);
    plan.mirrored = plan.upright;
    for (const PrototypePlan& group : groups)
        for (const Instance& use : group.instances)
            (group.mirrored ? plan.mirrored : plan.upright)[static_cast<size_t>(use.node)] = true;
    plan.prototypes = std::move(groups);
    return plan;
}

void removeInstances(const InstancePlan& plan, std::vector<Instance>& instances)
{
    std::erase_if(instances, [&](const Instance& use) { return plan.holds(use); });
}

void appendPrototypes(World& world, Topology& topology, Geometry& geometry, const Scene& scene,
                      const std::vector<PrototypePlan>& plans, const Stored& stored)
{
    if (plans.empty()) return;
    std::vector<Prototype> prototypes;
    std::vector<shared::InstanceMatrix> instances;
    for (const PrototypePlan& plan : plans) {
        Prototype prototype;
        prototype.triangles.begin = geometry.triangleCount();
        prototype.instances.begin = static_cast<uint32_t>(instances.size());
        prototype.alphaBegin = prototype.triangles.begin;
        const Mapping mapping(glm::inverse(plan.toMesh), plan.mirrored);
        Extent box;
        for (const int index : plan.meshes) {
            const Mesh& mesh = meshOf(scene, index);
            const uint32_t first = geometry.vertexCount();
            appendVertices(geometry, mesh, mapping, stored);
            Instance told = plan.instances.front();
            told.mesh = index;
            told.nodeToFile = nullptr;
            told.placement = nullptr;
            topology.prototypes.emplace_back(
                told, appendTriangles(geometry, mesh, plan.mirrored, first, box));
            const bool alpha = (world.features & shared::kFeatureAlpha) != 0;
            if (!alpha || !hasAlpha(scene, mesh)) prototype.alphaBegin = geometry.triangleCount();
        }
        prototype.triangles.end = geometry.triangleCount();
        if (prototype.triangles.empty()) continue;  // all degenerate
        for (const Instance& use : plan.instances) {
            const glm::dmat4 matrix = Mapping(use, world.placement).toWorld * plan.toMesh;
            for (const glm::vec3& corner : box.corners())
                topology.still.addPoint(glm::vec3(matrix * glm::dvec4(glm::dvec3(corner), 1)));
            instances.push_back(record(matrix));
        }
        prototype.instances.end = static_cast<uint32_t>(instances.size());
        prototypes.push_back(prototype);
    }
    world.prototypes = std::move(prototypes);
    world.instances = std::move(instances);
    const std::vector<IndexRange> ranges = prototypeTriangles(world);
    // With the room that a hierarchy with split triangles needs
    std::vector<IndexRange> split = ranges;
    for (IndexRange& range : split) range.end += range.size();
    if (geometry.triangleCount() >= shared::kFirstInstancedSlot ||
        !instanceSlots({world.prototypes.data(), world.prototypes.size()}, split))
        throwTooMany(world, scene);
    world.instanceTable = makeInstanceTable(world, ranges);
}

std::optional<std::vector<InstanceSlots>> instanceSlots(std::span<const Prototype> prototypes,
                                                        std::span<const IndexRange> stored)
{
    CHECK(prototypes.size() == stored.size());
    std::vector<InstanceSlots> slots;
    uint64_t next = shared::kFirstInstancedSlot;
    for (size_t i = 0; i < prototypes.size(); ++i) {
        const uint32_t bits = static_cast<uint32_t>(std::bit_width(stored[i].size() - 1));
        slots.push_back({static_cast<uint32_t>(next), bits});
        next += static_cast<uint64_t>(prototypes[i].instances.size()) << bits;
        if (next > shared::kNone) return std::nullopt;
    }
    return slots;
}

std::vector<glm::uvec4> makeInstanceTable(const World& world, std::span<const IndexRange> stored)
{
    std::vector<glm::uvec4> table;
    const size_t count = world.prototypes.size();
    if (count == 0) return table;
    const auto slots = instanceSlots({world.prototypes.data(), count}, stored);
    CHECK(slots);
    table.reserve(1 + count + shared::kInstanceMatrixWords * world.instances.size());
    table.emplace_back(static_cast<uint32_t>(count), 0, 0, 0);
    const auto matrices = static_cast<uint32_t>(1 + count);
    for (size_t i = 0; i < count; ++i) {
        const uint32_t first = world.prototypes[i].instances.begin;
        table.emplace_back((*slots)[i].first, (*slots)[i].bits, stored[i].begin,
                           matrices + shared::kInstanceMatrixWords * first);
    }
    for (const shared::InstanceMatrix& m : world.instances)
        for (const glm::vec4& row : {m.row0, m.row1, m.row2})
            table.push_back(std::bit_cast<glm::uvec4>(row));
    return table;
}

std::vector<IndexRange> prototypeTriangles(const World& world)
{
    std::vector<IndexRange> ranges;
    for (const Prototype& prototype : world.prototypes) ranges.push_back(prototype.triangles);
    return ranges;
}

uint64_t shownTriangles(const World& world)
{
    uint64_t sum = flatTriangles(world);
    for (const Prototype& p : world.prototypes)
        sum += static_cast<uint64_t>(p.triangles.size()) * p.instances.size();
    return sum;
}

}  // namespace core
