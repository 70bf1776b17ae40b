// See deformation.h. Everything is computed in double, from the sums over targets and joints to the
// last rounding to what a world stores.
#include "core/scene/deformation.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "core/base/parallel.h"
#include "shared/warp.h"

namespace core {

namespace {

const glm::dmat4x3 kIdentity(1);

const Mesh& meshOf(const Scene& scene, const Instance& use)
{
    return scene.meshes[static_cast<size_t>(use.mesh)];
}

/// The skin that the mesh of a node follows, or null.
const Skin* skinOf(const Scene& scene, int node, const Deformation& shape)
{
    const int skin = scene.nodes[static_cast<size_t>(node)].skin;
    return skin < 0 || shape.first.empty() ? nullptr : &scene.skins[static_cast<size_t>(skin)];
}

/// The weights of the targets in `pose`; none where they are not animated.
std::vector<double> weightsOf(const Deformation& shape, int node, const Pose& pose)
{
    const auto animated = pose.weights.find(node);
    std::vector<double> weights;
    if (animated != pose.weights.end()) weights = animated->second;
    weights.resize(shape.targets.size(), 0.0);
    return weights;
}

/// Matrices from the mesh to the world of `placement`, for each joint in use; one without a skin.
std::vector<glm::dmat4> matricesOf(const Scene& scene, const Instance& use, const Pose& pose,
                                   const Placement& placement)
{
    const Deformation& shape = *meshOf(scene, use).deformation;
    const Skin* skin = skinOf(scene, use.node, shape);
    if (!skin) {
        Instance here = use;
        here.nodeToFile = &pose.toFile[static_cast<size_t>(use.node)];
        return {Mapping(here, placement).toWorld};
    }
    std::vector<glm::dmat4> matrices;
    matrices.reserve(shape.joints.size());
    for (const uint32_t joint : shape.joints) {
        glm::dmat4x3 toFile = pose.toFile[static_cast<size_t>(skin->joints[joint])];
        if (!skin->inverseBinds.empty())
            toFile = toFile * glm::dmat4(glm::dmat4x3(skin->inverseBinds[joint]));
        Instance here;
        here.nodeToFile = &toFile;
        matrices.push_back(Mapping(here, placement).toWorld);
    }
    return matrices;
}

/// Vertices of a block after morphing, in the mesh's space; normals and tangents where asked for.
struct Block {
    size_t begin = 0;
    std::vector<glm::dvec3> positions, normals, tangents;
    bool morphed = false;

    void add(const MorphTarget& target, double weight)
    {
        const auto begins = std::lower_bound(target.vertices.begin(), target.vertices.end(), begin);
        for (size_t i = static_cast<size_t>(begins - target.vertices.begin());
             i < target.vertices.size() && target.vertices[i] < begin + positions.size(); ++i) {
            const size_t v = target.vertices[i] - begin;
            positions[v] += weight * glm::dvec3(target.positions[i]);
            if (!normals.empty() && !target.normals.empty())
                normals[v] += weight * glm::dvec3(target.normals[i]);
            if (!tangents.empty() && !target.tangents.empty())
                tangents[v] += weight * glm::dvec3(target.tangents[i]);
        }
        morphed = true;
    }
};

/// A use in one pose.
class Deformer {
public:
    Deformer(const Scene& scene, const Instance& use, const Pose& pose, const Placement& placement)
        : mesh_(meshOf(scene, use)), shape_(*mesh_.deformation),
          skinned_(skinOf(scene, use.node, shape_) != nullptr),
          matrices_(matricesOf(scene, use, pose, placement)),
          weights_(weightsOf(shape_, use.node, pose))
    {}

    /// The vertices [begin, end) after morphing, with what `stored` and the mesh have of them.
    Block block(size_t begin, size_t end, bool normals, bool tangents) const
    {
        Block block;
        block.begin = begin;
        block.positions.reserve(end - begin);
        block.normals.reserve(normals ? end - begin : 0);
        block.tangents.reserve(tangents ? end - begin : 0);
        for (size_t v = begin; v < end; ++v) {
            block.positions.emplace_back(mesh_.positions[v]);
            if (normals) block.normals.emplace_back(shared::unpackOct(mesh_.attributes[v].normal));
            if (!tangents) continue;
            const glm::vec4 t = shared::unpackTangent(mesh_.attributes[v].tangent);
            block.tangents.emplace_back(t.x, t.y, t.z);
        }
        for (size_t i = 0; i < weights_.size(); ++i)
            if (weights_[i] != 0) block.add(shape_.targets[i], weights_[i]);
        return block;
    }

    /// The matrix of a vertex: the weighted mean of its joints'. It is divided by the sum of the
    /// weights, which is 1 in single precision only: far from the middle that would show.
    glm::dmat4 matrix(size_t v) const
    {
        if (!skinned_) return matrices_.front();
        const uint32_t begin = shape_.first[v], end = shape_.first[v + 1];
        if (begin + 1 == end) return matrices_[shape_.influences[begin].joint];
        glm::dmat4 sum(0);
        double weights = 0;
        for (uint32_t i = begin; i < end; ++i) {
            const Influence& influence = shape_.influences[i];
            const auto weight = static_cast<double>(influence.weight);
            sum += weight * matrices_[influence.joint];
            weights += weight;
        }
        return sum / weights;
    }

private:
    const Mesh& mesh_;
    const Deformation& shape_;
    bool skinned_;
    std::vector<glm::dmat4> matrices_;
    std::vector<double> weights_;  // of the targets
};

/// The tangent after morphing, made perpendicular to the normal again, then by the matrix.
uint32_t packedTangent(const glm::dmat3& linear, bool mirrors, glm::dvec3 tangent,
                       const glm::dvec3* normal, uint32_t stored)
{
    if (normal != nullptr) {
        const double length2 = glm::dot(*normal, *normal);
        if (length2 > 0) tangent -= *normal * (glm::dot(*normal, tangent) / length2);
    }
    const glm::dvec3 t = linear * tangent;
    const double length = glm::length(t);
    if (!(length > 0) || !std::isfinite(length)) return stored;
    const float handedness = shared::unpackTangent(stored).w;
    return shared::packTangent(glm::vec3(t / length), mirrors ? -handedness : handedness);
}

}  // namespace

Instance DeformingUses::of(Instance use) const
{
    const Mesh& mesh = meshOf(scene_, use);
    if (!mesh.deformation) return use;
    const Deformation& shape = *mesh.deformation;
    const bool morphs = !shape.targets.empty() &&
                        std::binary_search(morphingNodes_.begin(), morphingNodes_.end(), use.node);
    const Skin* skin = skinOf(scene_, use.node, shape);
    use.deforms = morphs || skin != nullptr;
    if (skin != nullptr) {
        use.nodeToFile = &kIdentity;
        use.moves = std::any_of(shape.joints.begin(), shape.joints.end(),
                                [&](uint32_t joint) { return moves(skin->joints[joint]); });
    }
    use.moves = use.moves || morphs;
    return use;
}

bool appendDeformed(Geometry& geometry, const Scene& scene, const Instance& use, const Pose& pose,
                    const Placement& placement, const Stored& stored)
{
    const Mesh& mesh = meshOf(scene, use);
    const Deformer deformer(scene, use, pose, placement);
    const size_t first = geometry.positions.size(), count = mesh.positions.size();
    geometry.positions.resize(first + count);
    if (stored.attributes) geometry.attributes.resize(first + count);
    const bool normals = stored.normals && mesh.hasNormals;
    const bool tangents = stored.tangents && mesh.hasTangents;
    std::atomic<size_t> mirrored{0};
    parallelFor(count, 1 << 12, [&](size_t begin, size_t end) {
        const Block block = deformer.block(begin, end, normals, tangents);
        size_t mirroredHere = 0;
        for (size_t v = begin; v < end; ++v) {
            const glm::dmat4 matrix = deformer.matrix(v);
            const glm::dmat3 linear(matrix);
            const bool mirrors = glm::determinant(linear) < 0;
            if (mirrors) ++mirroredHere;
            geometry.positions[first + v] =
                glm::vec3(glm::dvec3(matrix * glm::dvec4(block.positions[v - begin], 1)));
            if (!stored.attributes) continue;
            shared::VertexAttributes a{shared::kNoNormal, 0, 0, 0};
            if (!mesh.attributes.empty()) a = mesh.attributes[v];
            const uint32_t normal = a.normal;
            a.normal = shared::kNoNormal;
            if (normals && normal != shared::kNoNormal)
                a.normal = packedNormal(cofactors(linear) * (mirrors ? -1.0 : 1.0) *
                                        block.normals[v - begin]);
            if (tangents)
                a.tangent = packedTangent(
                    linear, mirrors, block.tangents[v - begin],
                    block.morphed && normals ? &block.normals[v - begin] : nullptr, a.tangent);
            geometry.attributes[first + v] = a;
        }
        mirrored += mirroredHere;
    });
    appendExtra(geometry, mesh, stored);
    return 2 * mirrored > count;
}

std::vector<glm::dvec3> deformedPositions(const Scene& scene, const Instance& use, const Pose& pose)
{
    const Deformer deformer(scene, use, pose, {});
    std::vector<glm::dvec3> positions(meshOf(scene, use).positions.size());
    parallelFor(positions.size(), 1 << 12, [&](size_t begin, size_t end) {
        const Block block = deformer.block(begin, end, false, false);
        for (size_t v = begin; v < end; ++v)
            positions[v] =
                glm::dvec3(deformer.matrix(v) * glm::dvec4(block.positions[v - begin], 1));
    });
    return positions;
}

DeformedBounds::DeformedBounds(const Scene& scene, const Instance& use) : scene_(scene), use_(use)
{
    const Mesh& mesh = meshOf(scene, use);
    const Deformation& shape = *mesh.deformation;
    const bool skinned = skinOf(scene, use.node, shape) != nullptr;
    boxes_.resize(skinned ? shape.joints.size() : 1);
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
        if (!isFinite(glm::dvec3(mesh.positions[v]))) continue;
        if (!skinned) {
            boxes_[0].addPoint(mesh.positions[v]);
            continue;
        }
        for (uint32_t i = shape.first[v]; i < shape.first[v + 1]; ++i)
            boxes_[shape.influences[i].joint].addPoint(mesh.positions[v]);
    }
    for (const MorphTarget& target : shape.targets) {
        Extent box;
        box.addPoint(glm::vec3(0));
        for (const glm::vec3& offset : target.positions) box.addPoint(offset);
        targets_.push_back(box);
    }
}

void DeformedBounds::add(const Pose& pose, const Placement& placement, Extent& reach) const
{
    const Deformation& shape = *meshOf(scene_, use_).deformation;
    glm::vec3 low(0), high(0);
    const std::vector<double> weights = weightsOf(shape, use_.node, pose);
    for (size_t i = 0; i < weights.size(); ++i) {
        const auto weight = static_cast<float>(weights[i]);
        low += weight * (weight < 0 ? targets_[i].high : targets_[i].low);
        high += weight * (weight < 0 ? targets_[i].low : targets_[i].high);
    }
    const std::vector<glm::dmat4> matrices = matricesOf(scene_, use_, pose, placement);
    for (size_t i = 0; i < matrices.size(); ++i) {
        if (boxes_[i].empty()) continue;
        Extent box = boxes_[i];
        box.low += low;
        box.high += high;
        for (const glm::vec3& corner : box.corners()) {
            const glm::dvec3 p(matrices[i] * glm::dvec4(glm::dvec3(corner), 1));
            if (isFinite(p)) reach.addPoint(glm::vec3(p));
        }
    }
}

}  // namespace core
