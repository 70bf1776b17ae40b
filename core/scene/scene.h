// A scene as a file describes it: meshes, a forest of nodes, materials, textures, cameras, lights,
// animation. Plain data, immutable once loaded. What renderers read is made from it at one instant:
// see world.h.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include "shared/layout.h"

namespace core {

/// Four half floats: linear Rec.709 and alpha, or plain data (normal maps, roughness).
struct Texel {
    uint16_t r, g, b, a;
};

/// A decoded texture: rows from top to bottom, as glTF's coordinates have it.
struct Texture {
    std::string name;
    uint32_t width = 0, height = 0;
    std::vector<Texel> texels;
};

/// A material with its use of textures: indices into Scene::textureUses, -1 = none.
struct Material {
    std::string name;
    shared::Material data{};
    std::array<int, shared::kTextureSlotCount> textures{-1, -1, -1, -1, -1, -1, -1, -1, -1};
};

/// A texture as a material uses it; `record.firstTexel` is filled in when the pool is laid out.
struct TextureUse {
    int texture = -1;  // index into Scene::textures
    shared::TextureReference record{};
};

/// What a morph target adds at a weight of 1, to the vertices that it changes.
struct MorphTarget {
    std::vector<uint32_t> vertices;            // ascending
    std::vector<glm::vec3> positions;          // as long
    std::vector<glm::vec3> normals, tangents;  // as long, or empty
};

/// How far a vertex follows a joint.
struct Influence {
    uint32_t joint = 0;  // index into Deformation::joints
    float weight = 1;
};

/// How a mesh changes its shape: morph targets are added, then vertices follow joints. Those of
/// vertex v are influences[first[v]] up to influences[first[v + 1]]; there is one at least, and
/// their weights add up to 1. Without a skin `first` is empty.
struct Deformation {
    std::vector<uint32_t> joints;  // indices into Skin::joints: those in use, ascending
    std::vector<uint32_t> first;
    std::vector<Influence> influences;
    std::vector<MorphTarget> targets;  // empty unless their weights are animated
};

/// Triangles of one material. Attributes are packed as renderers read them; `extra` is empty or as
/// long as positions. `hasNormals` false: flat shading, the normals in `attributes` are unused.
struct Mesh {
    std::string name;
    int material = 0;
    bool hasNormals = false, hasTexCoords = false, hasTangents = false;
    std::vector<glm::vec3> positions;
    std::vector<shared::VertexAttributes> attributes;  // empty when nothing needs them
    std::vector<shared::VertexExtra> extra;
    std::vector<glm::uvec3> triangles;
    std::shared_ptr<const Deformation> deformation;  // null: rigid, as most meshes are
};

struct Transform {
    glm::dvec3 translation{0};
    glm::dquat rotation{1, 0, 0, 0};
    glm::dvec3 scale{1};
};

/// EXT_mesh_gpu_instancing: where a node shows its meshes, in its own space.
struct MeshPlacement {
    glm::vec3 translation{0};
    glm::quat rotation{1, 0, 0, 0};
    glm::vec3 scale{1};
};

/// Nodes that meshes follow, and matrices from the space of these into those of the joints.
struct Skin {
    std::string name;
    std::vector<int> joints;                // nodes of the scene
    std::vector<glm::mat4x3> inverseBinds;  // as long, or empty: identities
};

/// Indices begin <= i < end.
struct IndexRange {
    uint32_t begin = 0, end = 0;

    uint32_t size() const { return end - begin; }
    bool empty() const { return begin == end; }
    friend bool operator==(const IndexRange&, const IndexRange&) = default;
};

/// Without a name: of a million nodes that would be a fifth, and only cameras tell theirs.
struct Node {
    int parent = -1;    // comes before its children in Scene::nodes; -1: none
    IndexRange meshes;  // one glTF mesh may become several (one per primitive)
    int source = -1;    // in the document, for messages; -1: the same place as in Scene::nodes
    std::variant<Transform, glm::dmat4x3> local;
    int camera = -1, light = -1;
    int placements = -1;  // index into Scene::placements; -1: the meshes are where the node is
    int skin = -1;        // whose joints the meshes with influences follow, instead of the node
};

/// Perspective or orthographic; angles in radians, lengths in the file's units.
struct SceneCamera {
    std::string name;
    int node = -1;
    bool orthographic = false;
    double yfov = 0.9, aspect = 0;  // aspect 0: that of the image
    double ymag = 1;
    double apertureRadius = 0, focusDistance = 0;  // from extras; 0 = pinhole
};

/// KHR_lights_punctual, in the file's units; `color` times `intensity` is W/sr or, for directional,
/// W/m^2.
struct PunctualLight {
    std::string name;
    uint32_t kind = shared::kEmitterPoint;
    glm::vec3 color{1};
    float intensity = 1, range = 0, innerCone = 0, outerCone = 0.7853982f;
};

/// A latitude-longitude map, rows from +Y down: column fraction u looks to (sin 2 pi u, ., -cos 2
/// pi u).
struct Environment {
    std::string file;
    uint32_t width = 0, height = 0;
    // Linear radiance, before it is multiplied by `intensity`
    std::vector<glm::vec4> texels;
    float intensity = 1;
};

struct Sun {
    glm::vec3 directionTowards{0, 1, 0};
    float angularRadius = 0.004625f;
    glm::vec3 radiance{0};
};

/// `values` holds vec3 in xyz or quaternions as xyzw; cubic splines store (in-tangent, value,
/// out-tangent) per key. Weights of morph targets are in `weights` instead, those of all targets
/// side by side.
struct Keyframes {
    std::vector<float> times;
    std::vector<glm::vec4> values;
    std::vector<float> weights;
};

/// How one node's property changes. Channels with the same keys share them.
struct AnimationChannel {
    enum class Path : uint8_t { translation, rotation, scale, weights };
    enum class Interpolation : uint8_t { step, linear, cubicSpline };
    int node = -1;
    Path path = Path::translation;
    Interpolation interpolation = Interpolation::linear;
    std::shared_ptr<const Keyframes> keys;  // null: none
};

struct Animation {
    std::string name;
    double duration = 0;  // seconds
    std::vector<AnimationChannel> channels;
};

/// One finding of the loader; equal codes are counted, the first ten of each are kept.
struct Warning {
    std::string code;     // after the Khronos validator's names where it has one
    std::string pointer;  // JSON pointer of the place
    std::string message;
};

/// What the loader repaired or ignored: every warning is counted, the first of each code are
/// spelled out.
struct Warnings {
    struct Count {
        std::string code;
        uint64_t count = 0;
    };
    std::vector<Warning> listed;
    std::vector<Count> counts;

    /// Counts the warning and keeps its text while fewer than ten of its code are kept.
    void add(std::string code, std::string pointer, std::string message);
    uint64_t total() const;
};

struct Scene {
    std::filesystem::path file;
    std::string name, hash;  // hash: 16 hex digits over the content of every file read
    std::string fileHash;    // the same, whatever environment is asked for instead of its own
    std::vector<Mesh> meshes;
    std::vector<Node> nodes;  // a forest, parents before children
    std::vector<std::vector<MeshPlacement>> placements;
    std::vector<Skin> skins;
    std::vector<Material> materials;  // at least one; 0 is glTF's default when a mesh names none
    std::vector<TextureUse> textureUses;
    std::vector<Texture> textures;
    std::vector<SceneCamera> cameras;
    std::vector<PunctualLight> lights;
    std::vector<Animation> animations;
    std::optional<Environment> environment;
    std::optional<Sun> sun;
    Warnings warnings;
    uint64_t fileBytes = 0;
};

}  // namespace core
