// Scenes that move in every way that a pose knows, for the tests of poses.
#pragma once

#include <memory>
#include <vector>

#include "core/methods/renderer.h"
#include "core/scene/scene.h"
#include "tests/support/scenes/test_scenes.h"

namespace tests {

/// Keyframes of a node, one per second.
core::AnimationChannel channelOf(int node, core::AnimationChannel::Path path,
                                 std::vector<glm::vec4> values,
                                 core::AnimationChannel::Interpolation interpolation =
                                     core::AnimationChannel::Interpolation::linear);

/// Adds the channels to the scene's first animation.
void animate(core::Scene& scene, std::vector<core::AnimationChannel> channels);

/// A room with smooth balls, lit by a lamp; over four seconds a ball turns and flies, a lamp of
/// triangles and a point light move, a pane with blended alpha slides, and the camera follows.
/// Of the meshes, one rests between two that move.
SceneBuilder movingRoom();

/// The same, but the ball of node 1 is gone from the first second on: poses differ in triangles.
SceneBuilder vanishingRoom();

/// Four samples of every pixel of 48 x 32, from the world's first camera.
core::Estimate filmOf(core::Renderer& renderer, const std::shared_ptr<const core::World>& world);

/// Equal in everything that renderers, reports and cameras read.
void expectSameWorld(const core::World& a, const core::World& b);

}  // namespace tests
