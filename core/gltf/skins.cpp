// Skins of the nodes that are shown. One that cannot be used is left out with a warning: its meshes
// are then shown as they are stored, where their nodes are.
#include <algorithm>
#include <cmath>
#include <map>

#include "core/gltf/parts.h"

namespace core::gltf {

namespace {

constexpr const char* kConsequence = " — its meshes are shown as they are stored";
constexpr size_t kBetweenCheckpoints = 4096;  // joints: nothing forbids to list one a million times

class Reader {
public:
    Reader(Load& load, const std::vector<Accessor>& accessors, const NodePlan& plan)
        : load_(load), accessors_(accessors), plan_(plan)
    {}

    std::optional<Skin> read(const Object& object)
    {
        Skin skin;
        skin.name = object.name();
        if (!readJoints(object, skin) || !readInverseBinds(object, skin)) return std::nullopt;
        return skin;
    }

private:
    bool readJoints(const Object& object, Skin& skin)
    {
        const Json joints = object.array("joints");
        if (joints.size() == 0) return warn("EMPTY_ENTITY", object.pointer(), "has no joints");
        load_.reserveMemory(joints.size() * sizeof(int), object.pointer());
        skin.joints.reserve(joints.size());
        for (size_t i = 0; i < joints.size(); ++i) {
            if (i % kBetweenCheckpoints == 0) load_.checkpoint();
            const std::optional<uint64_t> node = wholeNumber(joints[i]);
            const size_t count = plan_.sceneNode.size();
            if (!node || *node >= count)
                return warn("UNRESOLVED_REFERENCE", child(object.at("joints"), i),
                            "is " + describe(joints[i]) + ", there are " + std::to_string(count) +
                                " nodes");
            const int joint = plan_.sceneNode[*node];
            if (joint < 0)
                return warn("NODE_SKIN_NO_SCENE", child(object.at("joints"), i),
                            "node " + std::to_string(*node) + " is not in the scene that is shown");
            skin.joints.push_back(joint);
        }
        return true;
    }

    bool readInverseBinds(const Object& object, Skin& skin)
    {
        const char* const key = "inverseBindMatrices";
        if (!object.has(key)) return true;
        const int index = object.softIndex(key, accessors_.size(), "accessors", "skin ignored");
        if (index < 0) return false;
        const Accessor& source = usable(load_, accessors_, index);
        if (!source.matrix || source.components != 16 || !source.isFloat())
            return warn("SKIN_IBM_INVALID_FORMAT", object.at(key), "are not float MAT4");
        if (source.count < skin.joints.size())
            return warn("INVALID_IBM_ACCESSOR_COUNT", object.at(key),
                        "are " + std::to_string(source.count) + " for " +
                            std::to_string(skin.joints.size()) + " joints");
        const size_t count = skin.joints.size();
        load_.reserveMemory(count * (sizeof(glm::mat4) + sizeof(glm::mat4x3)), object.pointer());
        std::vector<glm::mat4> matrices(count);
        readFloats(source, 0, count, 16, &matrices[0][0][0]);
        skin.inverseBinds.reserve(count);
        size_t projective = 0;
        for (size_t i = 0; i < count; ++i) {
            if (i % kBetweenCheckpoints == 0) load_.checkpoint();
            const glm::mat4& matrix = matrices[i];
            for (int column = 0; column < 4; ++column)
                for (int row = 0; row < 4; ++row)
                    if (!(std::abs(matrix[column][row]) < static_cast<float>(kHuge)))
                        return warn("ACCESSOR_INVALID_FLOAT", object.at(key),
                                    "matrix " + std::to_string(i) +
                                        " has values that are not finite or beyond 1e18");
            const glm::vec4 last(matrix[0][3], matrix[1][3], matrix[2][3], matrix[3][3]);
            if (last != glm::vec4(0, 0, 0, 1)) ++projective;
            skin.inverseBinds.emplace_back(matrix);
        }
        if (projective > 0)
            load_.warn("ACCESSOR_INVALID_IBM", object.at(key),
                       std::to_string(projective) +
                           " have a last row other than 0 0 0 1 — taken as that");
        return true;
    }

    bool warn(const char* code, const std::string& pointer, const std::string& what)
    {
        load_.warn(code, pointer, what + kConsequence);
        return false;
    }

    Load& load_;
    const std::vector<Accessor>& accessors_;
    const NodePlan& plan_;
};

}  // namespace

void readSkins(Load& load, const std::vector<Accessor>& accessors, const NodePlan& plan)
{
    Reader reader(load, accessors, plan);
    std::map<int, int> made;  // of the document's, those of the scene; -1: cannot be used
    for (const MeshUse& use : plan.meshUses) {
        if (use.skin < 0) continue;
        const std::string where = child("/skins", static_cast<size_t>(use.skin));
        const auto [entry, isNew] = made.try_emplace(use.skin, -1);
        if (isNew) {
            load.checkpoint();
            std::optional<Skin> skin =
                reader.read(topLevel(load, "skins", static_cast<size_t>(use.skin)));
            if (skin) {
                entry->second = static_cast<int>(load.scene.skins.size());
                load.scene.skins.push_back(std::move(*skin));
            }
        }
        Node& node = load.scene.nodes[static_cast<size_t>(use.node)];
        if (node.placements < 0)
            node.skin = entry->second;
        else
            load.warn("SKIN_IGNORED", where,
                      std::string("is used by a node with EXT_mesh_gpu_instancing") + kConsequence +
                          " in the places of these instances");
    }
}

void checkJoints(Load& load, const MeshUse& use, IndexRange meshes)
{
    Node& node = load.scene.nodes[static_cast<size_t>(use.node)];
    for (uint32_t mesh = meshes.begin; mesh < meshes.end; ++mesh) {
        const Deformation* shape = load.scene.meshes[mesh].deformation.get();
        if (node.skin < 0 || !shape || shape->joints.empty()) continue;
        const size_t joints = load.scene.skins[static_cast<size_t>(node.skin)].joints.size();
        if (shape->joints.back() < joints) continue;
        load.warn("ACCESSOR_JOINTS_INDEX_OOB", child("/meshes", static_cast<size_t>(use.mesh)),
                  "has vertices that follow joint " + std::to_string(shape->joints.back()) +
                      ", skin " + std::to_string(use.skin) + " has " + std::to_string(joints) +
                      kConsequence);
        node.skin = -1;
    }
}

}  // namespace core::gltf
