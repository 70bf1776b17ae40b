// EXT_mesh_gpu_instancing: nodes that show their mesh in many places, which accessors hold. What
// does not fit together refuses the file: without it the picture would be another.
#include <algorithm>
#include <array>
#include <cmath>

#include "core/gltf/parts.h"

namespace core::gltf {

namespace {

class Reader {
public:
    Reader(Load& load, const std::vector<Accessor>& accessors, const Object& extension)
        : load_(load), accessors_(accessors), extension_(extension),
          attributes_(extension.object("attributes"))
    {}

    std::vector<MeshPlacement> read()
    {
        const std::vector<float> translations = values("TRANSLATION", 3);
        const std::vector<float> rotations = values("ROTATION", 4);
        const std::vector<float> scales = values("SCALE", 3);
        if (!known_) countOthers();
        load_.reserveMemory(count_ * sizeof(MeshPlacement), pointer());
        std::vector<MeshPlacement> placements(count_);
        for (size_t i = 0; i < count_; ++i) {
            MeshPlacement& p = placements[i];
            if (!translations.empty()) p.translation = vectorAt(translations, i);
            if (!scales.empty()) p.scale = vectorAt(scales, i);
            if (!rotations.empty()) p.rotation = rotationAt(rotations, i);
        }
        if (turnless_ > 0)
            load_.warn("ROTATION_NON_UNIT", pointer() + "/ROTATION",
                       std::to_string(turnless_) + " have length 0 — no rotation instead");
        return placements;
    }

private:
    std::string pointer() const { return attributes_ ? attributes_->pointer() : ""; }

    static glm::vec3 vectorAt(const std::vector<float>& values, size_t i)
    {
        const float* v = values.data() + 3 * i;
        return {v[0], v[1], v[2]};
    }

    glm::quat rotationAt(const std::vector<float>& values, size_t i)
    {
        const float* v = values.data() + 4 * i;
        const float length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + v[3] * v[3]);
        if (!(length > 1e-6f) || !std::isfinite(length)) {
            ++turnless_;
            return {1, 0, 0, 0};
        }
        return {v[3] / length, v[0] / length, v[1] / length, v[2] / length};
    }

    /// All components of an attribute; none where it is absent. Integers are normalised.
    std::vector<float> values(const char* name, uint32_t components)
    {
        const int index =
            attributes_ ? attributes_->index(name, accessors_.size(), "accessor") : -1;
        if (index < 0) return {};
        const Accessor& accessor = usable(load_, accessors_, index);
        const std::string where = attributes_->at(name);
        if (accessor.components != components || accessor.matrix ||
            (!accessor.isFloat() && !accessor.normalized))
            load_.refuse("INSTANCING_FORMAT", where,
                         "is not a list of " + std::to_string(components) +
                             " floats or normalized integers each");
        if (known_ && accessor.count != count_)
            load_.refuse("INSTANCING_COUNT", where,
                         "has " + std::to_string(accessor.count) + " elements, another has " +
                             std::to_string(count_));
        known_ = true;
        count_ = accessor.count;
        load_.reserveMemory(count_ * components * sizeof(float), where);
        std::vector<float> flat(count_ * components);
        readFloats(accessor, 0, count_, components, flat.data());
        return flat;
    }

    /// Instances may have attributes of their own alone: all then stand where their node is.
    /// Without any attribute nothing tells how many there are.
    void countOthers()
    {
        if (attributes_ && attributes_->json().size() > 0) {
            const std::string& name = *attributes_->json().member(0).key;
            const int index =
                attributes_->requiredIndex(name.c_str(), accessors_.size(), "accessor");
            count_ = usable(load_, accessors_, index).count;
            return;
        }
        load_.warn("UNDEFINED_PROPERTY",
                   attributes_ ? attributes_->pointer() : extension_.pointer(),
                   "has no attributes — the mesh is shown once, where its node is");
        count_ = 1;
    }

    Load& load_;
    const std::vector<Accessor>& accessors_;
    const Object& extension_;
    std::optional<Object> attributes_;
    bool known_ = false;
    uint64_t count_ = 0, turnless_ = 0;
};

}  // namespace

void readPlacements(Load& load, const std::vector<Accessor>& accessors, const NodePlan& plan)
{
    const Json nodes = load.document.root().find("nodes").value_or(Json::emptyArray());
    for (size_t i = 0; i < plan.sceneNode.size(); ++i) {
        const int node = plan.sceneNode[i];
        if (node < 0 || !nodes[i].find("mesh") || !nodes[i].find("extensions")) continue;
        const Object source(load, nodes[i], child("/nodes", i));
        const std::optional<Object> extension = source.extension("EXT_mesh_gpu_instancing");
        if (!extension) continue;
        load.scene.nodes[static_cast<size_t>(node)].placements =
            static_cast<int>(load.scene.placements.size());
        load.scene.placements.push_back(Reader(load, accessors, *extension).read());
    }
}

}  // namespace core::gltf
