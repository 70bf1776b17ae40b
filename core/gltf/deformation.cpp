// How primitives deform: the joints that their vertices follow, and morph targets whose weights are
// animated. Those whose weights stay are added to the mesh as it is read (meshes.cpp).
#include "core/gltf/deformation.h"

#include <algorithm>
#include <cmath>

#include "core/scene/animation.h"

namespace core::gltf {

namespace {

constexpr const char* kUnskinned = " — shown as it is stored, where its node is";

/// One pair of JOINTS_n and WEIGHTS_n: four of each for every vertex.
struct InfluenceSet {
    std::vector<float> joints, weights;
};

class Reader {
public:
    Reader(Load& load, const std::vector<Accessor>& accessors, const DecodedPrimitive* decoded,
           const Object& primitive, const VertexRange& range)
        : load_(load), accessors_(accessors), decoded_(decoded), primitive_(primitive),
          range_(range)
    {}

    void readInfluences(Deformation& shape)
    {
        std::vector<InfluenceSet> sets;
        const std::optional<Object> attributes = primitive_.object("attributes");
        for (bool more = true; more;) {
            std::optional<InfluenceSet> set = readSet(*attributes, std::to_string(sets.size()));
            more = set.has_value();
            if (more) sets.push_back(std::move(*set));
        }
        if (sets.empty()) return;
        load_.reserveMemory((range_.count + range_.twins.size() + 1) * sizeof(uint32_t),
                            attributes->pointer());
        shape.first.assign(1, 0);
        for (size_t v = 0; v < range_.count; ++v) addVertex(*attributes, sets, v, shape);
        for (const uint32_t v : range_.twins) {
            for (uint32_t i = shape.first[v]; i < shape.first[v + 1]; ++i) {
                const Influence copy = shape.influences[i];
                shape.influences.push_back(copy);
            }
            shape.first.push_back(static_cast<uint32_t>(shape.influences.size()));
        }
        listJoints(shape);
        tellFaults(*attributes);
    }

    void readTargets(const Mesh& mesh, Deformation& shape)
    {
        const size_t count = targetCount(primitive_);
        const std::optional<Object> attributes = primitive_.object("attributes");
        const bool tangents = mesh.hasTangents && attributes->has("TANGENT");
        load_.reserveMemory(3 * range_.count * sizeof(glm::vec3) + count * sizeof(MorphTarget),
                            primitive_.at("targets"));
        for (size_t i = 0; i < count; ++i) {
            load_.checkpoint();
            shape.targets.push_back(
                readTarget(primitive_.element("targets", i), mesh.hasNormals, tangents));
        }
        if (std::all_of(shape.targets.begin(), shape.targets.end(),
                        [](const MorphTarget& target) { return target.vertices.empty(); }))
            shape.targets.clear();
    }

private:
    /// Set `n` of influences; none where there is none or it cannot be used.
    std::optional<InfluenceSet> readSet(const Object& attributes, const std::string& n)
    {
        const Accessor* joints =
            findAttribute(load_, accessors_, attributes, "JOINTS_" + n, decoded_);
        const Accessor* weights =
            findAttribute(load_, accessors_, attributes, "WEIGHTS_" + n, decoded_);
        const std::string consequence = n == "0" ? kUnskinned : " — this set is ignored";
        if (!joints && !weights) {
            if (n == "0")
                load_.warn("NODE_SKIN_WITH_NON_SKINNED_MESH", attributes.pointer(),
                           "has no JOINTS_0, which the skin of its node needs" + consequence);
            return std::nullopt;
        }
        if (!joints || !weights) {
            load_.warn("MESH_PRIMITIVE_JOINTS_WEIGHTS_MISMATCH", attributes.pointer(),
                       "has only one of JOINTS_" + n + " and WEIGHTS_" + n + consequence);
            return std::nullopt;
        }
        const bool whole =
            (joints->componentType == kUnsignedByte || joints->componentType == kUnsignedShort) &&
            !joints->normalized;
        const bool fits = isFour(*joints) && isFour(*weights) && whole &&
                          (weights->isFloat() || weights->componentType == kUnsignedByte ||
                           weights->componentType == kUnsignedShort);
        if (!fits) {
            load_.warn("MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT",
                       attributes.at(whole && isFour(*joints) ? "WEIGHTS_" + n : "JOINTS_" + n),
                       "must hold four whole numbers (joints) or numbers (weights) for each of " +
                           std::to_string(range_.positions) + " positions" + consequence);
            return std::nullopt;
        }
        load_.reserveMemory(range_.count * 8 * sizeof(float), attributes.pointer());
        InfluenceSet set;
        set.joints.resize(4 * range_.count);
        set.weights.resize(4 * range_.count);
        readFloats(*joints, range_.first, range_.count, 4, set.joints.data());
        readFloats(*weights, range_.first, range_.count, 4, set.weights.data());
        return set;
    }

    bool isFour(const Accessor& accessor) const
    {
        return accessor.components == 4 && !accessor.matrix && accessor.count == range_.positions;
    }

    /// Appends what vertex `v` follows, with weights that add up to 1.
    void addVertex(const Object& attributes, const std::vector<InfluenceSet>& sets, size_t v,
                   Deformation& shape)
    {
        const size_t begin = shape.influences.size();
        double sum = 0;
        for (const InfluenceSet& set : sets) {
            for (size_t i = 4 * v; i < 4 * v + 4; ++i) {
                const float weight = set.weights[i];
                if (!std::isfinite(weight)) ++notFinite_;
                if (weight < 0) ++negative_;
                if (!(weight > 0) || !std::isfinite(weight)) continue;
                shape.influences.push_back({static_cast<uint32_t>(set.joints[i]), weight});
                sum += static_cast<double>(weight);
            }
        }
        if (begin == shape.influences.size())
            shape.influences.push_back({static_cast<uint32_t>(sets[0].joints[4 * v]), 1});
        else
            for (size_t i = begin; i < shape.influences.size(); ++i)
                shape.influences[i].weight =
                    static_cast<float>(static_cast<double>(shape.influences[i].weight) / sum);
        // Bytes round four weights by a hundredth together.
        constexpr double kTolerance = 0.01;
        if (std::abs(sum - 1) > kTolerance) ++off_;
        const size_t added = shape.influences.size() - begin;
        load_.reserveMemory(added * sizeof(Influence), attributes.pointer());
        if (shape.influences.size() > std::numeric_limits<uint32_t>::max())
            load_.refuse("ACCESSOR_TOO_LONG", attributes.pointer(), "has more than 2^32 weights");
        shape.first.push_back(static_cast<uint32_t>(shape.influences.size()));
    }

    /// Lists the joints in use, and lets influences refer to that list.
    static void listJoints(Deformation& shape)
    {
        constexpr size_t kJoints = 1 << 16;  // that an unsigned short can name
        std::vector<uint32_t> place(kJoints, 0);
        for (const Influence& influence : shape.influences) place[influence.joint] = 1;
        for (uint32_t joint = 0; joint < kJoints; ++joint) {
            if (place[joint] == 0) continue;
            place[joint] = static_cast<uint32_t>(shape.joints.size());
            shape.joints.push_back(joint);
        }
        for (Influence& influence : shape.influences) influence.joint = place[influence.joint];
    }

    void tellFaults(const Object& attributes)
    {
        const std::string where = attributes.at("WEIGHTS_0");
        if (notFinite_ > 0)
            load_.warn("ACCESSOR_INVALID_FLOAT", where,
                       std::to_string(notFinite_) + " weights are not finite — taken as 0");
        if (negative_ > 0)
            load_.warn("ACCESSOR_WEIGHTS_NEGATIVE", where,
                       std::to_string(negative_) + " weights are negative — taken as 0");
        if (off_ > 0)
            load_.warn("ACCESSOR_WEIGHTS_NON_NORMALIZED", where,
                       std::to_string(off_) +
                           " vertices have weights that do not add up to 1 — scaled so that they "
                           "do; with no weight, a vertex follows its first joint");
    }

    MorphTarget readTarget(const Object& target, bool normals, bool tangents)
    {
        const std::vector<glm::vec3> p = offsets(target, "POSITION");
        const std::vector<glm::vec3> n =
            normals ? offsets(target, "NORMAL") : std::vector<glm::vec3>();
        const std::vector<glm::vec3> t =
            tangents ? offsets(target, "TANGENT") : std::vector<glm::vec3>();
        const auto changes = [](const std::vector<glm::vec3>& v, size_t i) {
            return !v.empty() && v[i] != glm::vec3(0);
        };
        MorphTarget result;
        // Vertex `v` as the file has it is vertex `here` of the mesh.
        const auto add = [&](size_t v, size_t here) {
            if (!changes(p, v) && !changes(n, v) && !changes(t, v)) return;
            result.vertices.push_back(static_cast<uint32_t>(here));
            result.positions.push_back(p.empty() ? glm::vec3(0) : p[v]);
            if (!n.empty()) result.normals.push_back(n[v]);
            if (!t.empty()) result.tangents.push_back(t[v]);
            constexpr uint64_t kEach = sizeof(uint32_t) + 3 * sizeof(glm::vec3);
            load_.reserveMemory(kEach, target.pointer());
        };
        for (size_t v = 0; v < range_.count; ++v) add(v, v);
        for (size_t i = 0; i < range_.twins.size(); ++i) add(range_.twins[i], range_.count + i);
        return result;
    }

    /// What the target adds to each vertex; nothing where it has no such attribute.
    std::vector<glm::vec3> offsets(const Object& target, const char* name)
    {
        const Accessor* source = findAttribute(load_, accessors_, target, name);
        if (!source || !source->hasData()) return {};
        if (source->components != 3 || source->matrix ||
            source->count < range_.first + range_.count) {
            load_.warn("MESH_PRIMITIVE_MORPH_TARGET_INVALID", target.at(name),
                       "does not fit the mesh — ignored");
            return {};
        }
        std::vector<glm::vec3> result(range_.count);
        readFloats(*source, range_.first, range_.count, 3, &result[0][0]);
        size_t bad = 0;
        for (glm::vec3& offset : result) {
            const glm::vec3 size = glm::abs(offset);
            if (std::max({size.x, size.y, size.z}) < 1e18f && size == size) continue;
            offset = glm::vec3(0);
            ++bad;
        }
        if (bad > 0)
            load_.warn("ACCESSOR_INVALID_FLOAT", target.at(name),
                       std::to_string(bad) + " values are not finite or beyond 1e18 — taken as 0");
        return result;
    }

    Load& load_;
    const std::vector<Accessor>& accessors_;
    const DecodedPrimitive* decoded_;
    const Object& primitive_;
    const VertexRange& range_;
    size_t notFinite_ = 0, negative_ = 0, off_ = 0;
};

}  // namespace

std::map<int, const AnimationChannel*> weightChannels(const Scene& scene)
{
    std::map<int, const AnimationChannel*> channels;
    if (scene.animations.empty()) return channels;
    for (const AnimationChannel& channel : scene.animations.front().channels)
        if (channel.path == AnimationChannel::Path::weights) channels[channel.node] = &channel;
    return channels;
}

ShapeOfUse shapeOf(const Scene& scene, const std::map<int, const AnimationChannel*>& channels,
                   const NodePlan& plan, const MeshUse& use)
{
    ShapeOfUse shape;
    shape.skinned = scene.nodes[static_cast<size_t>(use.node)].skin >= 0;
    const auto channel = channels.find(use.node);
    if (channel == channels.end()) {
        shape.weights = plan.weights[use.weights];
        return shape;
    }
    shape.morphing = !isConstant(*channel->second);
    if (shape.morphing) return shape;
    shape.weights = evaluateWeights(*channel->second, 0);
    if (std::all_of(shape.weights.begin(), shape.weights.end(), [](double w) { return w == 0; }))
        shape.weights.clear();
    return shape;
}

std::shared_ptr<const Deformation>
readDeformation(Load& load, const std::vector<Accessor>& accessors, const DecodedPrimitive* decoded,
                const Object& primitive, const VertexRange& range, const ShapeOfUse& shape,
                const Mesh& mesh)
{
    if (!shape.skinned && !shape.morphing) return nullptr;
    Reader reader(load, accessors, decoded, primitive, range);
    auto result = std::make_shared<Deformation>();
    if (shape.skinned) reader.readInfluences(*result);
    if (shape.morphing) reader.readTargets(mesh, *result);
    if (result->first.empty() && result->targets.empty()) return nullptr;
    return result;
}

}  // namespace core::gltf
