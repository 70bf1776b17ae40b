// Scenes in which meshes are used often, as triangles of their own and as instances.
#pragma once

#include <memory>

#include "tests/support/scenes/test_scenes.h"

namespace tests {

/// What is put into many places: a smooth ball of `8 * 4^levels` triangles and a small quad beside
/// it, of a material each.
struct Thing {
    core::Material ball = lambert(glm::vec3(0.7f, 0.4f, 0.2f));
    core::Material leaf = lambert(glm::vec3(0.2f, 0.6f, 0.3f));
    int levels = 2;
};

/// A ground and a lamp, and `count` nodes that show the same thing: turned, stretched, some
/// mirrored, not overlapping by much. The camera sees all of it.
SceneBuilder thicket(int count, const Thing& thing = {});

std::shared_ptr<const core::World> worldOf(const SceneBuilder& builder,
                                           core::Instancing instancing);

}  // namespace tests
