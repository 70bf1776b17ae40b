// A scene at one instant, as renderers read it: every use of a mesh flattened into one list of
// triangles, recentred and rescaled, with one pool of texels and one table of emitters. What is
// shown so often that this would cost too much is stored once instead, beside its instances.
// Immutable; shared between threads and devices. Another instant of the same scene shares what
// stays.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/last_made.h"
#include "core/base/shared_array.h"
#include "core/scene/camera.h"
#include "core/scene/scene.h"

namespace core {

/// world = (file - centre) * scale, computed in double. Undone in reports and saved cameras.
struct Placement {
    glm::dvec3 centre{0};
    double scale = 1;

    glm::dvec3 toWorld(glm::dvec3 p) const { return (p - centre) * scale; }
    glm::dvec3 toFile(glm::dvec3 p) const { return p / scale + centre; }
};

using shared::WorldTriangle;

/// Meshes of a node that are stored once, in a space of their own with a radius of about one, and
/// shown by instances. They rest, and neither shine nor are panes.
struct Prototype {
    IndexRange triangles;     // of World::triangles
    uint32_t alphaBegin = 0;  // the first of them whose alpha is tested
    IndexRange instances;     // of World::instances
};

/// What becomes of meshes that are used more than once. `automatic`: what is used so often that a
/// lot of memory depends on it is stored once; rays take longer through two levels.
enum class Instancing { automatic, flat, kept };

struct Topology;  // world_parts.h
struct Bvh;       // core/trace/bvh.h

/// The arrays are shared by all poses of a scene that have the same contents in them: a pose costs
/// what moves. Two worlds with the same `topology` differ in no more than `positions`, the vertices
/// `movingVertices` of them, their `attributes`, emitters, cameras and what follows from these;
/// that an array is the same one is told by SharedArray::sharesWith.
struct World {
    std::shared_ptr<const Scene> scene;
    double time = 0;  // of this pose, in seconds of the scene's animation
    // Of the pose that placement, instancing and choice of emitters were made for: all others take
    // them over
    double laidOutAt = 0;
    Placement placement;

    // The same in all poses of a topology. Triangles are in the order: opaque and still, opaque and
    // moving, alpha-tested and moving, alpha-tested and still (alpha last so that devices can keep
    // it apart; one range of what moves so that a pose replaces one piece of every array). Behind
    // them those of prototypes, with vertices in the space of these.
    std::shared_ptr<const Topology> topology;
    SharedArray<shared::VertexExtra> extra;  // as long as positions, or empty
    SharedArray<WorldTriangle> triangles;
    // Per triangle an index into emitters or kNone; empty when none emits
    SharedArray<uint32_t> triangleEmitter;
    SharedArray<Prototype> prototypes;
    SharedArray<shared::InstanceMatrix> instances;  // in the order of their prototypes
    SharedArray<glm::uvec4> instanceTable;          // shared/instances.h, where slots are triangles
    SharedArray<shared::Material> materials;
    SharedArray<shared::TextureReference> textureReferences;
    SharedArray<Texel> texels;
    uint32_t environmentWidth = 0, environmentHeight = 0;
    SharedArray<glm::vec4> environment;  // radiance without intensity
    // Height + 1 values over rows, then per row width + 1 values, then parts (makeEnvironmentCdf)
    SharedArray<float> environmentCdf;
    float environmentIntensity = 1;
    IndexRange movingVertices, movingTriangles;  // what the animation can move
    SharedArray<IndexRange> movingPieces;        // movingTriangles by uses of meshes; none is empty
    glm::vec3 reachLow{0}, reachHigh{0};  // where movingTriangles will be, by samples of time
    // For bvhOf: the hierarchy of the last pose that one was made for, by its positions
    std::shared_ptr<LastMade<SharedArray<glm::vec3>, Bvh>> bvh;

    // The pose.
    SharedArray<glm::vec3> positions;  // world, plus one unused at the end (Embree reads 16 bytes)
    SharedArray<shared::VertexAttributes> attributes;  // as long as positions, or empty
    SharedArray<shared::Emitter> emitters;
    SharedArray<float> emitterCdf;        // emitters.size() + 1 values from 0 to 1
    SharedArray<glm::uvec4> emitterTree;  // over those with a place; empty where they are few
    uint32_t treeEmitters = 0;  // the first so many are chosen by the tree: emitter_choice.h
    uint32_t environmentEmitter = shared::kNone, sunEmitter = shared::kNone;
    glm::vec3 boundsLow{0}, boundsHigh{0};
    float radius = 1;       // of the bounding sphere about the origin
    uint32_t features = 0;  // kFeature bits that can occur
    std::vector<Camera> cameras;
    Warnings warnings;  // the scene's and those of flattening
};

/// How many triangles stand for themselves: those of prototypes come behind.
inline uint32_t flatTriangles(const World& world)
{
    return world.prototypes.empty() ? static_cast<uint32_t>(world.triangles.size())
                                    : world.prototypes.front().triangles.begin;
}

/// How many triangles there are to be seen.
uint64_t shownTriangles(const World& world);

/// Flattens `scene` at `time` seconds of its first animation (0: the rest pose when there is none).
/// Degenerate and non-finite triangles are dropped and counted. `forcedFeatures` are kept even if
/// unused (--no-skip): what their code reads is then stored. `World::scene` keeps meshes and texels
/// only when there is an animation: let go of `scene` to free them. `placement` is that of another
/// instant of the same scene, whose world space then stays; without it, the instant's own bounds
/// decide. Throws core::Error when the result exceeds 2^31 indices, or instances show more than
/// four billion triangles.
std::shared_ptr<const World> makeWorld(std::shared_ptr<const Scene> scene, double time = 0,
                                       uint32_t forcedFeatures = 0,
                                       const std::optional<Placement>& placement = {},
                                       Instancing instancing = Instancing::automatic);

/// The same scene at another time, in the same world space, with the same forced features and
/// choice of emitters; else equal to what makeWorld makes of it, array by array, but sharing with
/// `world`, one of makeWorld's, what has not changed. Only where the pose decides which triangles
/// there are (a scale that vanishes, a triangle that loses area or orientation) is the scene
/// flattened anew; materials and texels are shared even then if the same materials are used.
std::shared_ptr<const World> poseWorld(const std::shared_ptr<const World>& world, double time);

/// Whether both hold the same triangles of the same scene, in two poses.
inline bool sameTopology(const World& a, const World& b)
{
    return a.topology != nullptr && a.topology == b.topology;
}

/// The settings of `PathSettings` that follow from the world alone.
shared::PathSettings worldSettings(const World& world);

}  // namespace core
