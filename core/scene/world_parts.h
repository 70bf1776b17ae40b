// The steps of makeWorld and poseWorld, in the order in which they run. Private to world*.cpp, here
// and in core/trace.
#pragma once

#include <array>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/scene/animation.h"
#include "core/scene/world.h"

namespace core {

/// One use of a mesh: its matrix into the file's space, its node for messages, whether the
/// animation can move it, and whether it has a shape of its own in every pose (deformation.h). With
/// a skin the matrix is the identity.
struct Instance {
    int mesh = 0;
    int node = 0;
    bool moves = false, deforms = false;
    // Of the pose that it was found in, and in the node's space where it has such; not in a
    // topology
    const glm::dmat4x3* nodeToFile = nullptr;
    const MeshPlacement* placement = nullptr;

    glm::dmat4x3 toFile() const;
};

/// What an instance does to points, normals and handedness.
struct Mapping {
    glm::dmat4 toWorld;
    glm::dmat3 linear, normals;
    bool mirrored;

    Mapping(const Instance& instance, const Placement& placement);
    /// A prototype's, which mirrors in itself what its instances mirror back.
    Mapping(const glm::dmat4& toWorld, bool mirrored);

    glm::vec3 point(const glm::vec3& p) const
    {
        return glm::vec3(glm::dvec3(toWorld * glm::dvec4(glm::dvec3(p), 1)));
    }
};

/// Uses of the same meshes that are to be instances of one prototype.
struct PrototypePlan {
    std::vector<int> meshes;          // opaque ones first
    std::vector<Instance> instances;  // the first mesh's, for all
    bool mirrored = false;
    glm::dmat4 toMesh{1};  // from the prototype's space
};

/// Which uses become instances.
struct InstancePlan {
    std::vector<PrototypePlan> prototypes;
    // A use is an instance if its mesh is here, and its node for places of its handedness.
    std::vector<bool> upright, mirrored, meshes;

    bool holds(const Instance& use) const;
};

/// What becomes of the triangles of one instance.
struct Dropped {
    uint32_t degenerate = 0, notFinite = 0;

    friend bool operator==(const Dropped&, const Dropped&) = default;
};

/// How far triangles reach, and how small they are.
struct Extent {
    glm::vec3 low{std::numeric_limits<float>::infinity()},
        high{-std::numeric_limits<float>::infinity()};
    float radius2 = 0;   // of vertices from the origin
    uint64_t rough = 0;  // triangles of which single precision leaves fewer than four bits

    void add(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c);
    void add(const Extent& other);
    void addPoint(const glm::vec3& p);
    std::array<glm::vec3, 8> corners() const;
    bool empty() const { return !(low.x <= high.x); }
};

/// A triangle that emits, and the mean luminance of its texture over it (1 without).
struct TriangleEmission {
    uint32_t triangle = 0;
    bool textured = false;
    double mean = 1;
};

/// What poseWorld needs to know of the world that it starts from. All poses with the same triangles
/// share one.
struct Topology {
    uint32_t forcedFeatures = 0;
    Instancing instancing = Instancing::automatic;
    bool ofLaterPose = false;    // one of many: not worth keeping anything of for later runs
    InstancePlan plan;           // without prototypes
    uint32_t fixedFeatures = 0;  // without those of emitters and cameras
    std::vector<int> usedMaterials;
    bool smoothSolids = false;        // among them
    std::vector<Instance> instances;  // in the order of their triangles, without matrices
    std::vector<Dropped> dropped;     // of each instance
    std::vector<std::pair<Instance, Dropped>> prototypes;  // of each mesh, with a node that uses it
    Extent still;                                          // of the triangles that never move
    std::vector<TriangleEmission> emission;
    double environmentWeight = 0;  // radiance times solid angle, without intensity
};

/// Uses of meshes that can show something, in the order of the nodes; those that their scale makes
/// vanish are dropped with a warning.
std::vector<Instance> findInstances(const Scene& scene, const Pose& pose, Warnings& warnings);

/// Which of the uses are stored once and shown by instances; `alpha`: there are alpha tests.
InstancePlan planInstances(const Scene& scene, const std::vector<Instance>& instances,
                           const Placement& placement, Instancing instancing, bool alpha);

/// Takes away the uses that become instances.
void removeInstances(const InstancePlan& plan, std::vector<Instance>& instances);

/// Puts them into the order of World::triangles.
void orderInstances(const Scene& scene, bool alpha, std::vector<Instance>& instances);

/// Centre of the triangles' bounds, and a power of two that brings their radius into [1, 100] when
/// it is outside.
Placement placeScene(const Scene& scene, const std::vector<Instance>& instances, const Pose& pose);

/// Fills positions, attributes, extra, triangles, what moves, bounds and radius. `world.features`
/// decides what is stored. Returns the extent of all triangles. `pose` is the same afterwards, but
/// others lie in its memory meanwhile.
Extent flattenInstances(World& world, Topology& topology, const Scene& scene, Pose& pose,
                        std::vector<Instance> instances,
                        const std::vector<PrototypePlan>& prototypes);

/// Replaces in `world`, which is a copy of another pose, what moves, and bounds and radius. Nothing
/// when the triangles of the new pose are others: the world is then as it was.
std::optional<Extent> moveInstances(World& world, const Scene& scene, const Pose& pose,
                                    const std::vector<Instance>& instances);

/// Says which triangles of each instance were dropped.
void warnAboutDropped(Warnings& warnings, const Scene& scene, const Topology& topology);

/// Copies the materials in world units and lays out the texels of those textures that `used`
/// materials read.
void layOutMaterials(World& world, const Scene& scene, const std::vector<int>& used);

/// Cameras in the order of the nodes; one that frames the scene when the file has none.
void placeCameras(World& world, const Scene& scene, const Pose& pose);

/// What of the light does not depend on the pose: which triangles emit, the environment's map and
/// its CDF.
void findEmission(World& world, Topology& topology, const Scene& scene);

/// Emissive triangles, punctual lights, environment, sun; their records, the CDF over them, and
/// their feature bits. Tables that come out as they are stay shared.
void collectEmitters(World& world, const Topology& topology, const Scene& scene, const Pose& pose);

/// JSON pointer of a node in the document.
std::string nodePointer(const Scene& scene, size_t node);

/// Puts `values` into `array`, unless it holds just these: then it goes on sharing them. Returns
/// whether they are others.
template <class T> bool replaceIfChanged(SharedArray<T>& array, std::vector<T> values)
{
    static_assert(std::is_trivially_copyable_v<T>);
    const bool same = array.size() == values.size() &&
                      (values.empty() ||
                       std::memcmp(array.data(), values.data(), values.size() * sizeof(T)) == 0);
    if (!same) array = std::move(values);
    return !same;
}

}  // namespace core
