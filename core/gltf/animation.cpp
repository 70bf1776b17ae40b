// Keyframes of nodes. A channel with a fault is left out with a warning; the node then keeps its
// rest pose.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/gltf/parts.h"

namespace core::gltf {

namespace {

using Channel = AnimationChannel;

struct Keys {
    std::vector<float> times, values;
    std::string fault;
};

/// Times and values of a sampler for a property of `elements` elements of `width` components.
Keys readKeys(const Accessor& input, const Accessor& output, uint32_t width, size_t elements,
              Channel::Interpolation interpolation)
{
    Keys keys;
    const uint64_t perKey = interpolation == Channel::Interpolation::cubicSpline ? 3 : 1;
    if (input.components != 1 || !input.isFloat()) {
        keys.fault = "its times are not floats";
        return keys;
    }
    if (output.components != width || output.matrix) {
        keys.fault = std::string("its values do not have ")
                         .append(std::to_string(width))
                         .append(" components");
        return keys;
    }
    if (output.count % elements != 0 || output.count / elements != input.count * perKey) {
        keys.fault = "it has " + std::to_string(input.count) + " times and " +
                     std::to_string(output.count) + " values" +
                     (elements > 1 ? " for " + std::to_string(elements) + " morph targets" : "");
        return keys;
    }
    keys.times.resize(input.count);
    readFloats(input, 0, input.count, 1, keys.times.data());
    for (size_t i = 0; i < keys.times.size(); ++i)
        if (!std::isfinite(keys.times[i]) || keys.times[i] < 0 ||
            (i > 0 && keys.times[i] <= keys.times[i - 1]))
            keys.fault = "its times do not increase from 0";
    keys.values.resize(output.count * width);
    readFloats(output, 0, output.count, width, keys.values.data());
    if (!std::all_of(keys.values.begin(), keys.values.end(),
                     [](float v) { return std::abs(v) < 1e18f; }))
        keys.fault = "it has values that are not finite or beyond 1e18";
    return keys;
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
bool normaliseRotations(Channel& channel)
{
    const size_t step = channel.interpolation == Channel::Interpolation::cubicSpline ? 3 : 1;
    for (size_t i = step == 3 ? 1 : 0; i < channel.values.size(); i += step) {
        const float length = glm::length(channel.values[i]);
        if (!(length > 1e-6f)) return false;
        channel.values[i] /= length;
    }
    return true;
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
                std::max(animation.duration, static_cast<double>(channel->times.back()));
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
        if (!weights && load_.scene.nodes[static_cast<size_t>(channel.node)].local.matrix)
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

        const Accessor& times = usable(load_, accessors_, input);
        const Accessor& values = usable(load_, accessors_, output);
        // Channels may share a sampler, but each has keys of its own here.
        load_.reserveMemory(times.count * sizeof(float) +
                                values.count * (weights ? sizeof(float) : sizeof(glm::vec4)),
                            object.pointer());
        const uint32_t width = weights ? 1 : channel.path == Channel::Path::rotation ? 4 : 3;
        Keys keys = readKeys(times, values, width, elements, channel.interpolation);
        if (!keys.fault.empty())
            return skip("ANIMATION_SAMPLER_INVALID", source.pointer(), keys.fault);
        channel.times = std::move(keys.times);
        if (weights)
            channel.weights = std::move(keys.values);
        else
            channel.values = vectors(keys.values, width);
        if (channel.path == Channel::Path::rotation && !normaliseRotations(channel))
            return skip("ANIMATION_SAMPLER_INVALID", source.pointer(),
                        "it has a rotation of length 0");
        return channel;
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
