// Keyframes of nodes. A channel with a fault is left out with a warning; the node then keeps its
// rest pose.
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>
#include <variant>

#include "core/gltf/parts.h"

namespace core::gltf {

namespace {

using Channel = AnimationChannel;

/// What the keys of a channel are made of.
struct KeySource {
    int input = -1, output = -1;  // accessors
    uint32_t width = 0;           // components of a value: 1 for weights, 4 for rotations, else 3
    size_t elements = 1;          // values of a key
    Channel::Interpolation interpolation = Channel::Interpolation::linear;

    bool cubic() const { return interpolation == Channel::Interpolation::cubicSpline; }
    friend bool operator==(const KeySource&, const KeySource&) = default;
};

struct Keys {
    std::shared_ptr<const Keyframes> keyframes;  // null: there is a fault
    std::string fault;
};

/// What is wrong with the accessors themselves; empty: nothing.
std::string faultOf(const Accessor& input, const Accessor& output, const KeySource& source)
{
    const size_t elements = source.elements;
    if (input.components != 1 || !input.isFloat()) return "its times are not floats";
    if (output.components != source.width || output.matrix)
        return std::string("its values do not have ")
            .append(std::to_string(source.width))
            .append(" components");
    if (output.count % elements != 0 ||
        output.count / elements != input.count * (source.cubic() ? 3 : 1))
        return "it has " + std::to_string(input.count) + " times and " +
               std::to_string(output.count) + " values" +
               (elements > 1 ? " for " + std::to_string(elements) + " morph targets" : "");
    return {};
}

/// Values of `width` components each.
std::vector<glm::vec4> vectors(const std::vector<float>& flat, uint32_t width)
{
    std::vector<glm::vec4> values(flat.size() / width, glm::vec4(0));
    for (size_t i = 0; i < flat.size(); ++i)
        values[i / width][static_cast<int>(i % width)] = flat[i];
    return values;
}

/// Rotations are unit quaternions; tangents of splines are not.
bool normaliseRotations(std::vector<glm::vec4>& values, bool cubic)
{
    for (size_t i = cubic ? 1 : 0; i < values.size(); i += cubic ? 3 : 1) {
        const float length = glm::length(values[i]);
        if (!(length > 1e-6f)) return false;
        values[i] /= length;
    }
    return true;
}

Keys readKeys(const Accessor& input, const Accessor& output, const KeySource& source)
{
    if (std::string fault = faultOf(input, output, source); !fault.empty())
        return {nullptr, std::move(fault)};
    Keyframes keys;
    std::vector<float>& times = keys.times;
    times.resize(input.count);
    readFloats(input, 0, input.count, 1, times.data());
    std::vector<float> values(output.count * source.width);
    readFloats(output, 0, output.count, source.width, values.data());
    if (!std::all_of(values.begin(), values.end(), [](float v) { return std::abs(v) < 1e18f; }))
        return {nullptr, "it has values that are not finite or beyond 1e18"};
    for (size_t i = 0; i < times.size(); ++i)
        if (!std::isfinite(times[i]) || times[i] < 0 || (i > 0 && times[i] <= times[i - 1]))
            return {nullptr, "its times do not increase from 0"};
    if (source.width == 1)
        keys.weights = std::move(values);
    else
        keys.values = vectors(values, source.width);
    if (source.width == 4 && !normaliseRotations(keys.values, source.cubic()))
        return {nullptr, "it has a rotation of length 0"};
    return {std::make_shared<const Keyframes>(std::move(keys)), {}};
}

class Reader {
public:
    Reader(Load& load, const std::vector<Accessor>& accessors, const NodePlan& plan)
        : load_(load), accessors_(accessors), plan_(plan)
    {}

    Animation read(const Object& object)
    {
        Animation animation;
        animation.name = object.name();
        const size_t count = object.array("channels").size();
        load_.reserveMemory(count * sizeof(Channel), object.pointer());
        animation.channels.reserve(count);
        for (size_t i = 0; i < count; ++i) {
            std::optional<Channel> channel = readChannel(object, object.element("channels", i));
            if (!channel) continue;
            animation.duration =
                std::max(animation.duration, static_cast<double>(channel->keys->times.back()));
            animation.channels.push_back(std::move(*channel));
        }
        return animation;
    }

private:
    std::optional<Channel> readChannel(const Object& animation, const Object& object)
    {
        const std::optional<Object> target = object.object("target");
        if (!target) load_.refuse("UNDEFINED_PROPERTY", object.pointer(), "'target' is missing");
        const int sampler =
            object.requiredIndex("sampler", animation.array("samplers").size(), "sampler");
        const Object source = animation.element("samplers", static_cast<size_t>(sampler));
        const int input = source.requiredIndex("input", accessors_.size(), "accessor");
        const int output = source.requiredIndex("output", accessors_.size(), "accessor");
        const int node = target->index("node", plan_.sceneNode.size(), "node");
        if (node < 0) return std::nullopt;  // allowed: an extension may say what moves
        Channel channel;
        channel.node = plan_.sceneNode[static_cast<size_t>(node)];
        if (channel.node < 0) return std::nullopt;  // of another scene

        const std::string path = target->requiredString("path");
        if (path == "translation")
            channel.path = Channel::Path::translation;
        else if (path == "rotation")
            channel.path = Channel::Path::rotation;
        else if (path == "scale")
            channel.path = Channel::Path::scale;
        else if (path == "weights")
            channel.path = Channel::Path::weights;
        else
            return skip("VALUE_NOT_IN_LIST", target->at("path"),
                        describe(path) + " is not a property of nodes");
        const bool weights = channel.path == Channel::Path::weights;
        const size_t elements = weights ? targetsOf(static_cast<size_t>(node)) : 1;
        if (elements == 0)
            return skip("ANIMATION_CHANNEL_TARGET_NODE_WEIGHTS_NO_MORPHS", target->at("path"),
                        "the node has no mesh with morph targets");
        if (!weights && std::holds_alternative<glm::dmat4x3>(
                            load_.scene.nodes[static_cast<size_t>(channel.node)].local))
            return skip("ANIMATION_CHANNEL_TARGET_NODE_MATRIX", target->at("node"),
                        "the node has a matrix, which cannot be animated");

        const std::string interpolation = source.softString("interpolation");
        if (interpolation == "STEP")
            channel.interpolation = Channel::Interpolation::step;
        else if (interpolation == "CUBICSPLINE")
            channel.interpolation = Channel::Interpolation::cubicSpline;
        else if (!interpolation.empty() && interpolation != "LINEAR")
            return skip("VALUE_NOT_IN_LIST", source.at("interpolation"),
                        describe(interpolation) + " is not known");

        const KeySource keySource{input, output,
                                  weights                                   ? 1u
                                  : channel.path == Channel::Path::rotation ? 4u
                                                                            : 3u,
                                  elements, channel.interpolation};
        const Keys& keys = keysOf(keySource, object);
        if (!keys.keyframes) return skip("ANIMATION_SAMPLER_INVALID", source.pointer(), keys.fault);
        channel.keys = keys.keyframes;
        return channel;
    }

    /// The keys that were made not long before of the same, as of a million channels with one
    /// sampler; or new ones.
    const Keys& keysOf(const KeySource& source, const Object& channel)
    {
        const Accessor& times = usable(load_, accessors_, source.input);
        const Accessor& values = usable(load_, accessors_, source.output);
        const auto place =
            static_cast<size_t>(source.input) * 31 + static_cast<size_t>(source.output);
        auto& [known, keys] = met_.at(place % met_.size());
        if (known == source) return keys;
        load_.reserveMemory(sizeof(Keyframes) + times.count * sizeof(float) +
                                values.count *
                                    (source.width == 1 ? sizeof(float) : sizeof(glm::vec4)),
                            channel.pointer());
        known = source;
        keys = readKeys(times, values, source);
        return keys;
    }

    /// Morph targets of the mesh of a node of the document.
    size_t targetsOf(size_t node)
    {
        const int mesh =
            topLevel(load_, "nodes", node).index("mesh", countOf(load_, "meshes"), "mesh");
        return mesh < 0 ? 0 : targetCount(topLevel(load_, "meshes", static_cast<size_t>(mesh)));
    }

    std::nullopt_t skip(const char* code, const std::string& pointer, const std::string& what)
    {
        load_.warn(code, pointer, what + " — this channel is ignored");
        return std::nullopt;
    }

    Load& load_;
    const std::vector<Accessor>& accessors_;
    const NodePlan& plan_;
    std::array<std::pair<KeySource, Keys>, 64> met_;
};

}  // namespace

/// What channels move: bits of properties, for each node of the scene.
using Moved = std::vector<uint8_t>;

static uint8_t bitOf(AnimationChannel::Path path)
{
    return static_cast<uint8_t>(1u << static_cast<unsigned>(path));
}

/// Exporters write an animation for each object that moves: those that move nothing that `first`
/// moves are played with it, and become a part of it. False where one does.
static bool joins(Animation& first, Animation& other, Moved& moved)
{
    const auto of = [&](const AnimationChannel& channel) -> uint8_t& {
        return moved[static_cast<size_t>(channel.node)];
    };
    for (const AnimationChannel& channel : other.channels)
        if ((of(channel) & bitOf(channel.path)) != 0) return false;
    for (const AnimationChannel& channel : other.channels) of(channel) |= bitOf(channel.path);
    first.duration = std::max(first.duration, other.duration);
    if (first.channels.empty())
        first.channels = std::move(other.channels);
    else
        std::ranges::move(other.channels, std::back_inserter(first.channels));
    return true;
}

void readAnimations(Load& load, const std::vector<Accessor>& accessors, const NodePlan& plan)
{
    Reader reader(load, accessors, plan);
    std::vector<Animation>& animations = load.scene.animations;
    Moved moved(load.scene.nodes.size(), 0);
    for (size_t i = 0; i < countOf(load, "animations"); ++i) {
        load.checkpoint();
        Animation animation = reader.read(topLevel(load, "animations", i));
        if (animation.channels.empty()) continue;
        if (animations.empty()) {
            animations.emplace_back().name = animation.name;
            joins(animations.front(), animation, moved);
        } else if (!joins(animations.front(), animation, moved)) {
            load.warn("ANIMATION_IGNORED", child("/animations", i),
                      "moves what an earlier animation moves — only the first is played");
            animations.push_back(std::move(animation));
        }
    }
}

}  // namespace core::gltf
