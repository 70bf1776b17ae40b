// From a scene to what renderers read: the order of the steps, materials and cameras.
#include "core/scene/world.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "core/base/check.h"
#include "core/scene/features.h"
#include "core/scene/world_parts.h"

namespace core {

namespace {

using std::numbers::pi;

/// The scene without what the world holds its own copy of, so that a caller who lets go of the
/// scene frees it.
std::shared_ptr<const Scene> withoutMeshesAndTexels(const Scene& scene)
{
    auto slim = std::make_shared<Scene>();
    slim->file = scene.file;
    slim->name = scene.name;
    slim->hash = scene.hash;
    slim->fileHash = scene.fileHash;
    slim->nodes = scene.nodes;
    slim->placements = scene.placements;
    slim->skins = scene.skins;
    slim->materials = scene.materials;
    slim->textureUses = scene.textureUses;
    slim->cameras = scene.cameras;
    slim->lights = scene.lights;
    slim->sun = scene.sun;
    slim->warnings = scene.warnings;
    slim->fileBytes = scene.fileBytes;
    for (const Mesh& mesh : scene.meshes) {
        Mesh copy;
        copy.name = mesh.name;
        copy.material = mesh.material;
        copy.hasNormals = mesh.hasNormals;
        copy.hasTexCoords = mesh.hasTexCoords;
        copy.hasTangents = mesh.hasTangents;
        slim->meshes.push_back(std::move(copy));
    }
    for (const Texture& texture : scene.textures) {
        slim->textures.push_back({texture.name, texture.width, texture.height, {}});
    }
    if (scene.environment) {
        const Environment& e = *scene.environment;
        slim->environment = Environment{e.file, e.width, e.height, {}, e.intensity};
    }
    return slim;
}

/// What a world refers to. An animated scene is flattened again at other times and needs its
/// meshes; and the copy of a million nodes would be larger than the meshes that it saves.
std::shared_ptr<const Scene> kept(std::shared_ptr<const Scene> scene)
{
    if (!scene->animations.empty()) return scene;
    uint64_t saved = scene->environment ? scene->environment->texels.size() * sizeof(glm::vec4) : 0;
    for (const Mesh& mesh : scene->meshes)
        saved +=
            mesh.positions.size() * sizeof(glm::vec3) + mesh.triangles.size() * sizeof(glm::uvec3);
    for (const Texture& texture : scene->textures) saved += texture.texels.size() * sizeof(Texel);
    return saved > scene->nodes.size() * sizeof(Node) ? withoutMeshesAndTexels(*scene) : scene;
}

/// The normalised vector; `fallback` where it has no direction.
glm::dvec3 unitOr(const glm::dvec3& v, const glm::dvec3& fallback)
{
    const double length = glm::length(v);
    return length > 1e-300 && std::isfinite(length) ? v / length : fallback;
}

/// Camera of a node: looks along -Z with +Y up; the node's scale does not matter
/// (glTF 2.0, 3.10.2).
Camera cameraOfNode(const SceneCamera& camera, const glm::dmat4x3& toFile,
                    const Placement& placement)
{
    Camera c;
    c.name = camera.name;
    c.position = placement.toWorld(glm::dvec3(toFile[3]));
    c.forward = unitOr(-glm::dvec3(toFile[2]), {0, 0, -1});
    const glm::dvec3 up = glm::dvec3(toFile[1]);
    const glm::dvec3 fallback =
        std::abs(c.forward.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
    const auto upright = [&](const glm::dvec3& v) {
        return v - c.forward * glm::dot(v, c.forward);
    };
    c.up = unitOr(upright(up), unitOr(upright(fallback), {0, 1, 0}));
    c.yfov = std::clamp(camera.yfov, 1e-5, pi - 1e-3);
    c.aspect = camera.aspect;
    c.orthographic = camera.orthographic;
    c.ymag = camera.ymag * placement.scale;
    c.apertureRadius = camera.apertureRadius * placement.scale;
    c.focusDistance = camera.focusDistance > 0 ? camera.focusDistance * placement.scale
                                               : std::max(glm::length(c.position), 1e-3);
    return c;
}

/// Looks at the scene from the front, a little from the right and above, with a margin of a tenth.
Camera framingCamera(const World& world)
{
    const glm::dvec3 centre = 0.5 * (glm::dvec3(world.boundsLow) + glm::dvec3(world.boundsHigh));
    const double yfov = 0.7;
    const double distance = 1.1 * static_cast<double>(world.radius) / std::sin(0.5 * yfov);
    const glm::dvec3 towards = glm::normalize(glm::dvec3(0.5, 0.35, 1.0));
    Camera camera = lookAt(centre + distance * towards, centre, {0, 1, 0}, yfov);
    camera.name = "default";
    return camera;
}

/// When one triangle in a thousand is affected: a few are specks that nobody sees.
void warnAboutPrecision(World& world, uint64_t rough)
{
    if (rough == 0 || rough * 1000 < world.triangles.size()) return;
    world.warnings.add("PRECISION", "",
                       std::to_string(rough) + " of " + std::to_string(world.triangles.size()) +
                           " triangles are smaller than a millionth of their distance from the "
                           "scene's centre: fewer than four bits of single precision are left for "
                           "their shape — they show rounding from close by");
}

void warnAboutLightThroughSolids(World& world, const Topology& topology)
{
    const bool punctual = std::ranges::any_of(world.emitters, [](const shared::Emitter& e) {
        const uint32_t kind = e.kind & 0xffu;
        return kind >= shared::kEmitterPoint && kind <= shared::kEmitterDirectional;
    });
    if (!punctual || !topology.smoothSolids) return;
    world.warnings.add("LIGHT_THROUGH_SOLIDS", "",
                       "point, spot and directional lights have no surface that a path could meet: "
                       "their light does not come through smooth solids (transmission with a "
                       "thickness) — what only it would light there stays dark; use thin walls, "
                       "some roughness, or lamps that are emissive meshes");
}

}  // namespace

std::string nodePointer(const Scene& scene, size_t node)
{
    const int source = scene.nodes[node].source;
    return "/nodes/" + std::to_string(source < 0 ? node : static_cast<size_t>(source));
}

void layOutMaterials(World& world, const Scene& scene, const std::vector<int>& used)
{
    std::vector<bool> needed(scene.textures.size(), false);
    for (const int m : used) {
        for (const int use : scene.materials[static_cast<size_t>(m)].textures) {
            if (use < 0) continue;
            const int texture = scene.textureUses[static_cast<size_t>(use)].texture;
            if (texture >= 0) needed[static_cast<size_t>(texture)] = true;
        }
    }
    uint64_t total = 0;
    std::vector<uint32_t> firstTexel(scene.textures.size(), 0);
    for (size_t i = 0; i < scene.textures.size(); ++i) {
        if (!needed[i]) continue;
        firstTexel[i] = static_cast<uint32_t>(total);
        total += scene.textures[i].texels.size();
        if (total > 0xffffffffull) {
            throw Error(scene.file.string() +
                        ": textures hold more than 2^32 texels — use smaller images");
        }
    }
    std::vector<Texel> pool;
    pool.reserve(total);
    for (size_t i = 0; i < scene.textures.size(); ++i) {
        if (!needed[i]) continue;
        const std::vector<Texel>& texels = scene.textures[i].texels;
        pool.insert(pool.end(), texels.begin(), texels.end());
    }
    world.texels = std::move(pool);
    std::vector<shared::TextureReference> references;
    for (const TextureUse& use : scene.textureUses) {
        shared::TextureReference record = use.record;
        if (use.texture >= 0) {
            const Texture& texture = scene.textures[static_cast<size_t>(use.texture)];
            record.firstTexel = firstTexel[static_cast<size_t>(use.texture)];
            record.width = texture.width;
            record.height = texture.height;
        }
        references.push_back(record);
    }
    if (references.size() > 0xffffu) {
        throw Error(scene.file.string() + ": " + std::to_string(references.size()) +
                    " different uses of textures, at most 65535 fit a material's record — merge "
                    "materials or leave textures out");
    }
    world.textureReferences = std::move(references);
    std::vector<shared::Material> materials;
    const std::vector<bool> solids = findSolids(scene);
    for (const Material& material : scene.materials) {
        shared::Material m = material.data;
        if (!solids[materials.size()]) m.flags &= ~shared::kMaterialVolume;
        m.absorption /= static_cast<float>(world.placement.scale);
        uint32_t* const pairs[5] = {&m.textures0, &m.textures1, &m.textures2, &m.textures3,
                                    &m.textures4};
        for (uint32_t* pair : pairs) *pair = 0;
        for (uint32_t slot = 0; slot < shared::kTextureSlotCount; ++slot) {
            const int use = material.textures[slot];
            if (use < 0 || scene.textureUses[static_cast<size_t>(use)].texture < 0) continue;
            *pairs[slot / 2] |= static_cast<uint32_t>(use + 1) << (slot % 2 * 16);
        }
        materials.push_back(m);
    }
    world.materials = std::move(materials);
}

void placeCameras(World& world, const Scene& scene, const Pose& pose)
{
    for (size_t n = 0; n < scene.nodes.size(); ++n) {
        const int camera = scene.nodes[n].camera;
        if (camera < 0 || static_cast<size_t>(camera) >= scene.cameras.size()) continue;
        Camera placed = cameraOfNode(scene.cameras[static_cast<size_t>(camera)], pose.toFile[n],
                                     world.placement);
        if (placed.name.empty()) placed.name = "camera " + std::to_string(world.cameras.size());
        if (placed.hasLens()) world.features |= shared::kFeatureThinLens;
        const double sum = glm::dot(placed.position, placed.position);
        if (!std::isfinite(sum)) {
            world.warnings.add("CAMERA_NOT_FINITE", nodePointer(scene, n),
                               "camera without a finite position — ignored");
            continue;
        }
        world.cameras.push_back(std::move(placed));
    }
    if (world.cameras.empty()) world.cameras.push_back(framingCamera(world));
}

namespace {

std::vector<int> sortedUnique(std::vector<int> values)
{
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
    return values;
}

/// What a finished world says about its precision, lights and cameras, in this order: the steps
/// that every pose takes.
void finishPose(World& world, const Topology& topology, const Scene& scene, const Pose& pose,
                uint64_t rough)
{
    warnAboutPrecision(world, rough);
    world.cameras.clear();
    world.features = topology.fixedFeatures;
    placeCameras(world, scene, pose);
    collectEmitters(world, topology, scene, pose);
    warnAboutLightThroughSolids(world, topology);
}

/// All steps from the start. `previous`, another pose or null, lends its materials where they are
/// the same, and its choice of emitters.
std::shared_ptr<const World> flattenWorld(std::shared_ptr<const Scene> scene, Pose& pose,
                                          uint32_t forcedFeatures,
                                          const std::optional<Placement>& placement,
                                          Instancing instancing, const World* previous)
{
    auto world = std::make_shared<World>();
    auto topology = std::make_shared<Topology>();
    world->time = pose.time;
    world->laidOutAt = previous != nullptr ? previous->laidOutAt : pose.time;
    world->warnings = scene->warnings;
    std::vector<Instance> instances = findInstances(*scene, pose, world->warnings);
    std::vector<bool> shown(scene->meshes.size(), false);
    for (const Instance& instance : instances) shown[static_cast<size_t>(instance.mesh)] = true;
    std::vector<int> meshes, materials;
    for (size_t mesh = 0; mesh < shown.size(); ++mesh)
        if (shown[mesh]) meshes.push_back(static_cast<int>(mesh));
    for (const int mesh : meshes)
        materials.push_back(scene->meshes[static_cast<size_t>(mesh)].material);
    topology->usedMaterials = sortedUnique(std::move(materials));
    topology->smoothSolids = anySmoothSolid(*scene, topology->usedMaterials);

    world->features = forcedFeatures | materialFeatures(*scene, topology->usedMaterials);
    world->features |= meshFeatures(*scene, meshes, world->features);
    world->placement = placement ? *placement : placeScene(*scene, instances, pose);
    const bool alpha = (world->features & shared::kFeatureAlpha) != 0;
    topology->plan = planInstances(*scene, instances, world->placement, instancing, alpha);
    const std::vector<PrototypePlan> prototypes = std::move(topology->plan.prototypes);
    if (!prototypes.empty()) world->features |= shared::kFeatureInstances;
    topology->forcedFeatures = forcedFeatures;
    topology->instancing = instancing;
    topology->ofLaterPose = previous != nullptr;
    topology->fixedFeatures = world->features;
    removeInstances(topology->plan, instances);
    orderInstances(*scene, alpha, instances);
    const Extent extent =
        flattenInstances(*world, *topology, *scene, pose, std::move(instances), prototypes);
    warnAboutDropped(world->warnings, *scene, *topology);
    if (previous != nullptr && previous->topology->usedMaterials == topology->usedMaterials) {
        world->materials = previous->materials;
        world->textureReferences = previous->textureReferences;
        world->texels = previous->texels;
    } else {
        layOutMaterials(*world, *scene, topology->usedMaterials);
    }
    findEmission(*world, *topology, *scene);
    if (previous != nullptr) {
        world->emitterTree = previous->emitterTree;
        world->treeEmitters = previous->treeEmitters;
    }
    finishPose(*world, *topology, *scene, pose, extent.rough);
    world->bvh = std::make_shared<LastMade<SharedArray<glm::vec3>, Bvh>>();
    world->topology = std::move(topology);
    world->scene = kept(std::move(scene));
    return world;
}

/// The instances of `topology` and no others, in their order.
bool sameInstances(const Topology& topology, const std::vector<Instance>& instances)
{
    const auto same = [](const Instance& a, const Instance& b) {
        return a.mesh == b.mesh && a.node == b.node;
    };
    return std::equal(instances.begin(), instances.end(), topology.instances.begin(),
                      topology.instances.end(), same);
}

}  // namespace

std::shared_ptr<const World> makeWorld(std::shared_ptr<const Scene> scene, double time,
                                       uint32_t forcedFeatures,
                                       const std::optional<Placement>& placement,
                                       Instancing instancing)
{
    Pose pose = poseAt(*scene, time);
    return flattenWorld(std::move(scene), pose, forcedFeatures, placement, instancing, nullptr);
}

std::shared_ptr<const World> poseWorld(const std::shared_ptr<const World>& from, double time)
{
    CHECK(from->topology != nullptr);
    const Scene& scene = *from->scene;
    if (scene.animations.empty()) return from;  // one pose at all times
    const Topology& topology = *from->topology;
    Pose pose = poseAt(scene, time);
    auto world = std::make_shared<World>(*from);
    world->warnings = scene.warnings;
    std::vector<Instance> instances = findInstances(scene, pose, world->warnings);
    removeInstances(topology.plan, instances);
    orderInstances(scene, (topology.fixedFeatures & shared::kFeatureAlpha) != 0, instances);
    std::optional<Extent> extent;
    if (sameInstances(topology, instances)) extent = moveInstances(*world, scene, pose, instances);
    if (!extent) {
        return flattenWorld(from->scene, pose, topology.forcedFeatures, from->placement,
                            topology.instancing, from.get());
    }
    world->time = time;
    warnAboutDropped(world->warnings, scene, topology);
    finishPose(*world, topology, scene, pose, extent->rough);
    return world;
}

shared::PathSettings worldSettings(const World& world)
{
    shared::PathSettings settings{};
    settings.emitterCount = static_cast<uint32_t>(world.emitters.size());
    settings.environmentEmitter = world.environmentEmitter;
    settings.sunEmitter = world.sunEmitter;
    settings.passesPanes =
        (world.features & shared::kFeaturePanes) != 0 ? shared::kPanesPass : shared::kPanesBlock;
    settings.treeEmitters = world.treeEmitters;
    settings.environmentWidth = world.environmentWidth;
    settings.environmentHeight = world.environmentHeight;
    settings.environmentIntensity = world.environmentIntensity;
    settings.sceneRadius = world.radius;
    return settings;
}

}  // namespace core
