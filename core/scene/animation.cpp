// Keyframe interpolation as appendix C of the glTF 2.0 specification writes it, and the walk over
// the forest of nodes.
#include "core/scene/animation.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <variant>

#include "core/base/check.h"

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

/// Translation times rotation times scale. Zeros lose their minus, as in a sum of products.
glm::dmat4x3 matrixOf(const Transform& t)
{
    const glm::dmat3 rotation = glm::mat3_cast(normalised(t.rotation));
    return {rotation[0] * t.scale.x + 0.0, rotation[1] * t.scale.y + 0.0,
            rotation[2] * t.scale.z + 0.0, t.translation + 0.0};
}

const Keyframes& keysOf(const AnimationChannel& channel)
{
    static const Keyframes none;
    return channel.keys ? *channel.keys : none;
}

/// Parts of a key: in-tangent, value and out-tangent, or the value alone.
size_t partsOf(const AnimationChannel& channel)
{
    return channel.interpolation == AnimationChannel::Interpolation::cubicSpline ? 3 : 1;
}

/// The keys around a time.
struct Between {
    size_t before = 0, after = 0;  // equal: nothing to interpolate
    double t = 0, span = 0;        // share of the way, its length in seconds

    /// `keys` is at least 1.
    Between(const AnimationChannel& channel, size_t keys, double time)
    {
        const std::vector<float>& times = keysOf(channel).times;
        const auto begin = times.begin();
        const auto next = std::upper_bound(begin, begin + static_cast<std::ptrdiff_t>(keys), time);
        after = static_cast<size_t>(next - begin);
        before = after == 0 ? 0 : after - 1;
        if (after == 0 || after == keys ||
            channel.interpolation == AnimationChannel::Interpolation::step)
            after = before;
        const double t0 = static_cast<double>(times[before]);
        span = static_cast<double>(times[after]) - t0;
        t = span > 0 ? (time - t0) / span : 0;
    }
};

/// The value between two keys, by at(key, part) and, where that is linear, mix(a, b, t). Between
/// equal keys nothing is interpolated, so that what rests does so to the last bit.
template <class At, class Mix>
auto interpolate(const Between& keys, bool cubic, const At& at, const Mix& mix)
{
    const size_t value = cubic ? 1 : 0;
    using Value = decltype(at(keys.before, value));
    const Value a = at(keys.before, value), b = at(keys.after, value);
    if (keys.before == keys.after) return a;
    if (!cubic) return a == b ? a : mix(a, b, keys.t);
    const Value out = at(keys.before, 2), in = at(keys.after, 0);
    if (a == b && out == Value(0) && in == Value(0)) return a;
    const double t = keys.t, t2 = t * t, t3 = t2 * t;
    return (2 * t3 - 3 * t2 + 1) * a + keys.span * (t3 - 2 * t2 + t) * out +
           (-2 * t3 + 3 * t2) * b + keys.span * (t3 - t2) * in;
}

/// Whether all keys have the value of the first, and no tangents; `width` values to a part.
template <class T> bool hasOneValue(const std::vector<T>& values, size_t parts, size_t width)
{
    const size_t keys = values.size() / (parts * width), value = parts / 2;
    const auto at = [&](size_t key, size_t part, size_t i) {
        return values[(key * parts + part) * width + i];
    };
    for (size_t key = 0; key < keys; ++key) {
        for (size_t i = 0; i < width; ++i) {
            if (at(key, value, i) != at(0, value, i)) return false;
            if (parts == 3 && keys > 1 && (at(key, 0, i) != T(0) || at(key, 2, i) != T(0)))
                return false;
        }
    }
    return true;
}

/// Morph targets of a channel of their weights.
size_t targetsOf(const AnimationChannel& channel)
{
    const size_t parts = keysOf(channel).times.size() * partsOf(channel);
    return parts == 0 ? 0 : keysOf(channel).weights.size() / parts;
}

/// The channels of each node's transform, in their order.
class ChannelLists {
public:
    ChannelLists(const std::vector<AnimationChannel>& channels, size_t nodes)
        : channels_(channels), first_(nodes, kNone), next_(channels.size(), kNone)
    {
        for (size_t i = channels.size(); i-- > 0;) {
            if (channels[i].path == AnimationChannel::Path::weights) continue;
            const auto node = static_cast<size_t>(channels[i].node);
            if (channels[i].node < 0 || node >= nodes) continue;
            next_[i] = std::exchange(first_[node], static_cast<uint32_t>(i));
        }
    }

    template <class Use> void forEach(size_t node, const Use& use) const
    {
        for (uint32_t i = first_[node]; i != kNone; i = next_[i]) use(channels_[i]);
    }

private:
    static constexpr uint32_t kNone = ~uint32_t(0);
    const std::vector<AnimationChannel>& channels_;
    std::vector<uint32_t> first_, next_;
};

void apply(const AnimationChannel& channel, const glm::dvec4& value, Transform& local)
{
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
    case AnimationChannel::Path::weights:
        break;
    }
}

/// From the node's space into its parent's.
glm::dmat4x3 localMatrix(const Scene& scene, const ChannelLists* lists, size_t node, double time)
{
    const std::variant<Transform, glm::dmat4x3>& local = scene.nodes[node].local;
    const Transform* rest = std::get_if<Transform>(&local);
    Transform moved = rest != nullptr ? *rest : Transform();
    bool moves = false;
    if (lists != nullptr)
        lists->forEach(node, [&](const AnimationChannel& channel) {
            glm::dvec4 value;
            if (!evaluateChannel(channel, time, value)) return;
            apply(channel, value, moved);
            moves = true;  // glTF forbids animating a node that has a matrix
        });
    return rest != nullptr || moves ? matrixOf(moved) : std::get<glm::dmat4x3>(local);
}

}  // namespace

bool evaluateChannel(const AnimationChannel& channel, double time, glm::dvec4& value)
{
    const size_t parts = partsOf(channel);
    const std::vector<glm::vec4>& values = keysOf(channel).values;
    const size_t keys = std::min(keysOf(channel).times.size(), values.size() / parts);
    if (keys == 0) return false;
    const bool rotation = channel.path == AnimationChannel::Path::rotation;
    value = interpolate(
        Between(channel, keys, time), parts == 3,
        [&](size_t key, size_t part) { return glm::dvec4(values[key * parts + part]); },
        [&](const glm::dvec4& a, const glm::dvec4& b, double t) {
            return rotation ? slerp(a, b, t) : glm::mix(a, b, t);
        });
    if (rotation) {
        const glm::dquat q = normalised(asQuaternion(value));
        value = {q.x, q.y, q.z, q.w};
    }
    return true;
}

std::vector<double> evaluateWeights(const AnimationChannel& channel, double time)
{
    std::vector<double> weights(targetsOf(channel));
    if (weights.empty()) return weights;
    const size_t parts = partsOf(channel);
    const Keyframes& all = keysOf(channel);
    const Between keys(channel, all.times.size(), time);
    for (size_t i = 0; i < weights.size(); ++i) {
        weights[i] = interpolate(
            keys, parts == 3,
            [&](size_t key, size_t part) {
                const size_t at = (key * parts + part) * weights.size() + i;
                return static_cast<double>(all.weights[at]);
            },
            [](double a, double b, double t) { return a + (b - a) * t; });
    }
    return weights;
}

bool isConstant(const AnimationChannel& channel)
{
    if (channel.path != AnimationChannel::Path::weights)
        return hasOneValue(keysOf(channel).values, partsOf(channel), 1);
    const size_t targets = targetsOf(channel);
    return targets == 0 || hasOneValue(keysOf(channel).weights, partsOf(channel), targets);
}

Pose poseAt(const Scene& scene, double time)
{
    Pose pose;
    poseAt(scene, time, pose);
    return pose;
}

void poseAt(const Scene& scene, double time, Pose& pose)
{
    pose.time = time;
    pose.weights.clear();
    std::optional<ChannelLists> lists;
    if (!scene.animations.empty()) {
        const std::vector<AnimationChannel>& channels = scene.animations.front().channels;
        lists.emplace(channels, scene.nodes.size());
        for (const AnimationChannel& channel : channels)
            if (channel.path == AnimationChannel::Path::weights)
                pose.weights[channel.node] = evaluateWeights(channel, time);
    }
    pose.toFile.resize(scene.nodes.size());
    for (size_t n = 0; n < scene.nodes.size(); ++n) {
        const int parent = scene.nodes[n].parent;
        CHECK(parent < static_cast<int>(n));
        const glm::dmat4x3 local = localMatrix(scene, lists ? &*lists : nullptr, n, time);
        pose.toFile[n] =
            parent < 0 ? local : pose.toFile[static_cast<size_t>(parent)] * glm::dmat4(local);
    }
}

std::vector<bool> movingNodes(const Scene& scene)
{
    std::vector<bool> moves(scene.nodes.size(), false);
    if (scene.animations.empty()) return moves;
    for (const AnimationChannel& channel : scene.animations.front().channels) {
        if (channel.path == AnimationChannel::Path::weights) continue;
        const bool known = channel.node >= 0 && static_cast<size_t>(channel.node) < moves.size();
        if (known && !isConstant(channel)) moves[static_cast<size_t>(channel.node)] = true;
    }
    for (size_t n = 0; n < moves.size(); ++n) {
        const int parent = scene.nodes[n].parent;
        if (parent >= 0 && moves[static_cast<size_t>(parent)]) moves[n] = true;
    }
    return moves;
}

std::vector<int> morphingNodes(const Scene& scene)
{
    std::vector<int> nodes;
    if (scene.animations.empty()) return nodes;
    for (const AnimationChannel& channel : scene.animations.front().channels)
        if (channel.path == AnimationChannel::Path::weights && !isConstant(channel))
            nodes.push_back(channel.node);
    std::sort(nodes.begin(), nodes.end());
    return nodes;
}

}  // namespace core
