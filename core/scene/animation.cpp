// Keyframe interpolation as appendix C of the glTF 2.0 specification writes it, and the walk over
// the node forest.
#include "core/scene/animation.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include <glm/gtc/matrix_transform.hpp>

namespace core {

namespace {

glm::dquat asQuaternion(const glm::dvec4& v)
{
    return {v.w, v.x, v.y, v.z};
}

/// Unit quaternion; the identity where there is no direction to keep.
glm::dquat normalised(const glm::dquat& q)
{
    const double length = std::sqrt(glm::dot(q, q));
    if (!(length > 1e-12) || !std::isfinite(length)) return {1, 0, 0, 0};
    return q * (1.0 / length);
}

/// Spherical interpolation the short way round.
glm::dvec4 slerp(const glm::dvec4& a, const glm::dvec4& b, double t)
{
    const glm::dquat q = glm::slerp(normalised(asQuaternion(a)), normalised(asQuaternion(b)), t);
    return {q.x, q.y, q.z, q.w};
}

glm::dmat4 localMatrix(const Transform& t)
{
    if (t.matrix) return *t.matrix;
    const glm::dmat4 translation = glm::translate(glm::dmat4(1), t.translation);
    return translation * glm::mat4_cast(normalised(t.rotation)) *
           glm::scale(glm::dmat4(1), t.scale);
}

/// Calls visit(node, parent or -1) for all nodes that the roots reach, parents first; a node that
/// is reached again is passed over.
template <class Visit> void visitNodes(const Scene& scene, const Visit& visit)
{
    std::vector<bool> reached(scene.nodes.size(), false);
    struct Entry {
        int node;
        int parent;
    };
    std::vector<Entry> stack;
    const auto push = [&](const std::vector<int>& nodes, int parent) {
        for (auto it = nodes.rbegin(); it != nodes.rend(); ++it) stack.push_back({*it, parent});
    };
    push(scene.roots, -1);
    while (!stack.empty()) {
        const Entry entry = stack.back();
        stack.pop_back();
        if (entry.node < 0 || static_cast<size_t>(entry.node) >= scene.nodes.size()) continue;
        const size_t n = static_cast<size_t>(entry.node);
        if (reached[n]) continue;
        reached[n] = true;
        visit(entry.node, entry.parent);
        push(scene.nodes[n].children, entry.node);
    }
}

/// Whether the channel has one value at all times: exporters like to write such channels for every
/// node. Splines count as constant only without tangents.
bool isConstant(const AnimationChannel& channel)
{
    const bool cubic = channel.interpolation == AnimationChannel::Interpolation::cubicSpline;
    const size_t stride = cubic ? 3 : 1, keys = channel.values.size() / stride;
    if (keys == 0) return true;
    const glm::vec4 value = channel.values[cubic ? 1 : 0];
    for (size_t key = 0; key < keys; ++key) {
        if (channel.values[key * stride + (cubic ? 1 : 0)] != value) return false;
        if (cubic && keys > 1 &&
            (channel.values[key * 3] != glm::vec4(0) ||
             channel.values[key * 3 + 2] != glm::vec4(0)))
            return false;
    }
    return true;
}

void apply(const AnimationChannel& channel, double time, const Scene& scene,
           std::unordered_map<int, Transform>& animated)
{
    if (channel.node < 0 || static_cast<size_t>(channel.node) >= scene.nodes.size()) return;
    glm::dvec4 value;
    if (!evaluateChannel(channel, time, value)) return;
    const Transform& rest = scene.nodes[static_cast<size_t>(channel.node)].local;
    Transform& local = animated.try_emplace(channel.node, rest).first->second;
    local.matrix.reset();  // glTF forbids animating a node that has a matrix
    switch (channel.path) {
    case AnimationChannel::Path::translation:
        local.translation = glm::dvec3(value);
        break;
    case AnimationChannel::Path::scale:
        local.scale = glm::dvec3(value);
        break;
    case AnimationChannel::Path::rotation:
        local.rotation = asQuaternion(value);
        break;
    }
}

}  // namespace

bool evaluateChannel(const AnimationChannel& channel, double time, glm::dvec4& value)
{
    const bool cubic = channel.interpolation == AnimationChannel::Interpolation::cubicSpline;
    const size_t stride = cubic ? 3 : 1;
    const size_t keys = std::min(channel.times.size(), channel.values.size() / stride);
    if (keys == 0) return false;
    const auto at = [&](size_t key, size_t part) {
        return glm::dvec4(channel.values[key * stride + part]);
    };
    const bool rotation = channel.path == AnimationChannel::Path::rotation;
    const auto begin = channel.times.begin();
    const auto next = std::upper_bound(begin, begin + static_cast<std::ptrdiff_t>(keys), time);
    const size_t after = static_cast<size_t>(next - begin);
    // Between equal keys nothing is interpolated, so that what rests does so to the last bit.
    const auto rests = [&] {
        const glm::dvec4 zero(0);
        return cubic ? at(after - 1, 1) == at(after, 1) && at(after - 1, 2) == zero &&
                           at(after, 0) == zero
                     : at(after - 1, 0) == at(after, 0);
    };
    if (after == 0 || after == keys ||
        channel.interpolation == AnimationChannel::Interpolation::step || rests()) {
        value = at(after == 0 ? 0 : after - 1, cubic ? 1 : 0);
    } else {
        const double t0 = static_cast<double>(channel.times[after - 1]);
        const double span = static_cast<double>(channel.times[after]) - t0;
        const double t = span > 0 ? (time - t0) / span : 0;
        if (cubic) {
            const double t2 = t * t, t3 = t2 * t;
            value = (2 * t3 - 3 * t2 + 1) * at(after - 1, 1) +
                    span * (t3 - 2 * t2 + t) * at(after - 1, 2) +
                    (-2 * t3 + 3 * t2) * at(after, 1) + span * (t3 - t2) * at(after, 0);
        } else if (rotation) {
            value = slerp(at(after - 1, 0), at(after, 0), t);
        } else {
            value = glm::mix(at(after - 1, 0), at(after, 0), t);
        }
    }
    if (rotation) {
        const glm::dquat q = normalised(asQuaternion(value));
        value = {q.x, q.y, q.z, q.w};
    }
    return true;
}

Pose poseAt(const Scene& scene, double time)
{
    std::unordered_map<int, Transform> animated;
    if (!scene.animations.empty())
        for (const AnimationChannel& channel : scene.animations.front().channels)
            apply(channel, time, scene, animated);

    Pose pose;
    pose.toFile.assign(scene.nodes.size(), glm::dmat4x3(1));
    visitNodes(scene, [&](int node, int parent) {
        const size_t n = static_cast<size_t>(node);
        pose.order.push_back(node);
        const auto changed = animated.empty() ? animated.end() : animated.find(node);
        const glm::dmat4 local =
            localMatrix(changed == animated.end() ? scene.nodes[n].local : changed->second);
        pose.toFile[n] =
            parent < 0 ? glm::dmat4x3(local) : pose.toFile[static_cast<size_t>(parent)] * local;
    });
    return pose;
}

std::vector<bool> movingNodes(const Scene& scene)
{
    std::vector<bool> moves(scene.nodes.size(), false);
    if (scene.animations.empty()) return moves;
    for (const AnimationChannel& channel : scene.animations.front().channels) {
        const bool known = channel.node >= 0 && static_cast<size_t>(channel.node) < moves.size();
        if (known && !isConstant(channel)) moves[static_cast<size_t>(channel.node)] = true;
    }
    visitNodes(scene, [&](int node, int parent) {
        if (parent >= 0 && moves[static_cast<size_t>(parent)])
            moves[static_cast<size_t>(node)] = true;
    });
    return moves;
}

}  // namespace core
