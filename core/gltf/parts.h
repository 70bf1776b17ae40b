// The parts of a load in the order in which they run; each fills its piece of load.scene.
#pragma once

#include <vector>

#include "core/gltf/accessors.h"
#include "core/gltf/json.h"

namespace core::gltf {

/// A mesh of the document as a node shows it. Nodes with equal weights share what is made of it.
struct MeshUse {
    int node = -1;  // of the scene
    int mesh = 0;
    uint32_t weights = 0;  // of its morph targets, in NodePlan::weights
    int skin = -1;         // of the document
};

/// A node of the scene that refers to a camera or light of the document.
struct NodeUse {
    int node = -1;
    size_t index = 0;
    std::string name;  // of the node, where it has a camera
};

/// How the nodes of the document became those of the scene.
struct NodePlan {
    std::vector<int> sceneNode;  // per node of the document, -1: not in the scene
    std::vector<MeshUse> meshUses;
    std::vector<std::vector<double>> weights{{}};  // [0]: none
    std::vector<NodeUse> cameraUses, lightUses;
};

/// Nodes of the scene that is shown, parents before children. Refuses loops, bad references and
/// depth above 4096.
NodePlan readNodes(Load& load);

/// Morph targets of a mesh of the document, those of its first primitive (all must have as many),
/// or of one primitive.
size_t targetCount(const Object& meshOrPrimitive);

/// Channels of nodes in the scene: translation, rotation, scale, weights of morph targets.
void readAnimations(Load& load, const std::vector<Accessor>& accessors, const NodePlan& plan);

void readCameras(Load& load, const NodePlan& plan);
void readLights(Load& load, const NodePlan& plan);

/// Which materials of the document became which of the scene.
struct MaterialPlan {
    std::vector<int> sceneMaterial;  // per material of the document, -1: not used
    int fallback = -1;               // glTF's default material, when used
};

/// Materials and texture uses of everything that `plan` shows.
MaterialPlan readMaterials(Load& load, const NodePlan& plan);

/// Decodes the images of scene.textures that readMaterials asked for, on all cores.
void readTextures(Load& load);

/// Where nodes show their meshes: fills scene.placements.
void readPlacements(Load& load, const std::vector<Accessor>& accessors, const NodePlan& plan);

/// The skins that `plan` uses: fills scene.skins and says so at the nodes.
void readSkins(Load& load, const std::vector<Accessor>& accessors, const NodePlan& plan);

/// Takes the skin from the node if a vertex of its meshes follows a joint that the skin does not
/// have.
void checkJoints(Load& load, const MeshUse& use, IndexRange meshes);

/// The meshes that `plan` shows: fills scene.meshes and the nodes' lists.
void readMeshes(Load& load, const std::vector<Accessor>& accessors, const NodePlan& plan,
                const MaterialPlan& materials);

/// scenes[].extras.environment and .sun.
void readEnvironment(Load& load);

/// The scene object that is shown, if the document has scenes.
std::optional<Object> shownScene(Load& load);

}  // namespace core::gltf
