// See animated_scenes.h.
#include "tests/support/scenes/animated_scenes.h"

#include <algorithm>
#include <cstring>

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

namespace tests {

using Path = core::AnimationChannel::Path;

core::AnimationChannel channelOf(int node, Path path, std::vector<glm::vec4> values,
                                 core::AnimationChannel::Interpolation interpolation)
{
    core::AnimationChannel channel;
    channel.node = node;
    channel.path = path;
    channel.interpolation = interpolation;
    core::Keyframes keys;
    const bool cubic = interpolation == core::AnimationChannel::Interpolation::cubicSpline;
    for (size_t key = 0; key < values.size() / (cubic ? 3 : 1); ++key)
        keys.times.push_back(static_cast<float>(key));
    keys.values = std::move(values);
    channel.keys = std::make_shared<const core::Keyframes>(std::move(keys));
    return channel;
}

void animate(core::Scene& scene, std::vector<core::AnimationChannel> channels)
{
    if (scene.animations.empty()) scene.animations.emplace_back();
    core::Animation& animation = scene.animations.front();
    for (core::AnimationChannel& channel : channels) {
        animation.duration =
            std::max(animation.duration, static_cast<double>(channel.keys->times.back()));
        animation.channels.push_back(std::move(channel));
    }
}

SceneBuilder movingRoom()
{
    SceneBuilder b = room(lambert(glm::vec3(0.7f)), glossy(glm::vec3(0.8f), 0.3f, 0.3f));
    const auto lastNode = [&] { return static_cast<int>(b.scene.nodes.size()) - 1; };
    core::Material glass = lambert(glm::vec3(0.5f));
    glass.data.flags |= shared::kMaterialAlphaBlend;
    glass.data.alpha = 0.5f;
    b.quad({-0.8f, -0.9f, 0.3f}, {0.5f, 0, 0}, {0, 0.8f, 0}, b.material(glass));
    const int pane = lastNode();
    b.sphere({-0.4f, 0.2f, 0}, 0.2f, 3, b.material(lambert(glm::vec3(0.4f, 0.6f, 0.2f))), false,
             true);
    const int ball = lastNode();
    b.sphere({0.4f, 0.4f, -0.3f}, 0.15f, 3, b.material(lambert(glm::vec3(0.6f))), false, true);
    b.quad({0.5f, -0.2f, 0.5f}, {0, 0.2f, 0}, {0, 0, 0.2f}, b.material(emitter(glm::vec3(5))));
    const int lamp = lastNode();
    core::PunctualLight point;
    point.intensity = 0.3f;
    b.light(point, glm::dmat4(1));
    const int light = lastNode();
    b.scene.nodes[static_cast<size_t>(light)].local = core::Transform();
    b.camera({0, 0, 3.2}, {0, 0, 0}, 0.7);
    const int camera = lastNode();
    b.scene.nodes[static_cast<size_t>(camera)].local = core::Transform();
    const glm::vec4 upright(0, 0, 0, 1), quarter(0, 0.7071068f, 0, 0.7071068f);
    animate(b.scene, {channelOf(ball, Path::translation,
                                {{0, 0, 0, 0},
                                 {0.3f, 0.1f, 0, 0},
                                 {0.5f, -0.3f, 0.2f, 0},
                                 {0, 0.2f, 0, 0},
                                 {0, 0, 0, 0}}),
                      channelOf(ball, Path::rotation, {upright, quarter, upright}),
                      channelOf(pane, Path::translation, {{0, 0, 0, 0}, {0.9f, 0, 0, 0}}),
                      channelOf(lamp, Path::translation, {{0, 0, 0, 0}, {0, 0.5f, -0.5f, 0}}),
                      channelOf(lamp, Path::scale, {{1, 1, 1, 0}, {1, 2, 1, 0}}),
                      channelOf(light, Path::translation, {{0, 0.5f, 0, 0}, {0.5f, 0.5f, 0.5f, 0}}),
                      channelOf(camera, Path::translation, {{0, 0, 3.2f, 0}, {0.2f, 0.1f, 3, 0}})});
    return b;
}

namespace {

template <class T>
void expectSameBytes(const core::SharedArray<T>& a, const core::SharedArray<T>& b, const char* what)
{
    ASSERT_EQ(a.size(), b.size()) << what;
    if (a.empty()) return;
    EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(T)), 0) << what;
}

}  // namespace

SceneBuilder vanishingRoom()
{
    SceneBuilder b = movingRoom();
    animate(b.scene, {channelOf(1, Path::scale, {{1, 1, 1, 0}, {0, 0, 0, 0}},
                                core::AnimationChannel::Interpolation::step)});
    return b;
}

core::Estimate filmOf(core::Renderer& renderer, const std::shared_ptr<const core::World>& world)
{
    renderer.setWorld(world, {});
    renderer.setView({world->cameras.front(), {48, 32}, {}}, core::Start::anew);
    renderer.advance({.samples = 4}, {});
    return renderer.read(core::Reading::everything);
}

void expectSameWorld(const core::World& a, const core::World& b)
{
    EXPECT_EQ(a.placement.centre, b.placement.centre);
    EXPECT_EQ(a.placement.scale, b.placement.scale);
    expectSameBytes(a.positions, b.positions, "positions");
    expectSameBytes(a.attributes, b.attributes, "attributes");
    expectSameBytes(a.extra, b.extra, "extra");
    expectSameBytes(a.triangles, b.triangles, "triangles");
    expectSameBytes(a.triangleEmitter, b.triangleEmitter, "emitters of triangles");
    expectSameBytes(a.instanceTable, b.instanceTable, "instances");
    expectSameBytes(a.materials, b.materials, "materials");
    expectSameBytes(a.textureReferences, b.textureReferences, "texture references");
    expectSameBytes(a.texels, b.texels, "texels");
    expectSameBytes(a.emitters, b.emitters, "emitters");
    expectSameBytes(a.emitterCdf, b.emitterCdf, "probabilities of emitters");
    expectSameBytes(a.environment, b.environment, "environment");
    expectSameBytes(a.environmentCdf, b.environmentCdf, "probabilities of the environment");
    expectSameBytes(a.movingPieces, b.movingPieces, "moving pieces");
    EXPECT_EQ(a.movingVertices, b.movingVertices);
    EXPECT_EQ(a.movingTriangles, b.movingTriangles);
    EXPECT_EQ(a.environmentEmitter, b.environmentEmitter);
    EXPECT_EQ(a.sunEmitter, b.sunEmitter);
    EXPECT_EQ(a.environmentIntensity, b.environmentIntensity);
    EXPECT_EQ(a.environmentWidth, b.environmentWidth);
    EXPECT_EQ(a.environmentHeight, b.environmentHeight);
    EXPECT_EQ(a.boundsLow, b.boundsLow);
    EXPECT_EQ(a.boundsHigh, b.boundsHigh);
    EXPECT_EQ(a.radius, b.radius);
    EXPECT_EQ(a.features, b.features);
    EXPECT_TRUE(a.cameras == b.cameras);
    ASSERT_EQ(a.warnings.listed.size(), b.warnings.listed.size());
    for (size_t i = 0; i < a.warnings.listed.size(); ++i) {
        EXPECT_EQ(a.warnings.listed[i].code, b.warnings.listed[i].code);
        EXPECT_EQ(a.warnings.listed[i].message, b.warnings.listed[i].message);
    }
    EXPECT_EQ(a.warnings.total(), b.warnings.total());
}

}  // namespace tests
