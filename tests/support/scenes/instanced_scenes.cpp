// See instanced_scenes.h.
#include "tests/support/scenes/instanced_scenes.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <glm/gtc/matrix_transform.hpp>

#include "shared/warp.h"

namespace tests {

namespace {

/// The meshes of a thing, without a node.
std::vector<int> addThing(SceneBuilder& builder, const Thing& thing)
{
    const int ball = builder.sphere(glm::vec3(5, -3, 2), 0.4f, thing.levels,
                                    builder.material(thing.ball), false, true);
    builder.scene.nodes.pop_back();  // which sphere() made
    const glm::vec3 a(5.2f, -2.8f, 2.3f);
    const int leaf = builder.looseMesh({a, a + glm::vec3(0.5f, 0, 0.1f),
                                        a + glm::vec3(0.5f, 0.6f, 0.1f), a + glm::vec3(0, 0.6f, 0)},
                                       {{0, 1, 2}, {0, 2, 3}}, builder.material(thing.leaf));
    return {ball, leaf};
}

}  // namespace

SceneBuilder thicket(int count, const Thing& thing)
{
    SceneBuilder builder;
    const std::vector<int> meshes = addThing(builder, thing);
    const int ground = builder.material(lambert(glm::vec3(0.5f)));
    const int lamp = builder.material(emitter(glm::vec3(12)));
    const int side =
        std::max(1, static_cast<int>(std::ceil(std::sqrt(static_cast<double>(count)))));
    const float half = 0.5f * static_cast<float>(side);
    builder.quad({-half - 1, 0, half + 1}, {2 * half + 2, 0, 0}, {0, 0, -2 * half - 2}, ground);
    builder.quad({-half, 3, -half}, {2 * half, 0, 0}, {0, 0, 2 * half}, lamp);
    std::mt19937 random(7);
    const auto uniform = [&](double low, double high) {
        return low + (high - low) * 0x1p-32 * static_cast<double>(random());
    };
    for (int i = 0; i < count; ++i) {
        const glm::dvec3 place(i % side - 0.5 * (side - 1), uniform(0.4, 0.8),
                               i / side - 0.5 * (side - 1));
        glm::dmat4 m = glm::translate(glm::dmat4(1), place);
        m = glm::rotate(m, uniform(0, 6.283),
                        glm::dvec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1) + 2));
        m = glm::scale(m, glm::dvec3(uniform(0.5, 1), uniform(0.5, 1),
                                     (i % 3 == 0 ? -1.0 : 1.0) * uniform(0.5, 1)));
        m = glm::translate(m, glm::dvec3(-5, 3, -2));
        builder.node(m, meshes);
    }
    const double reach = 0.5 * side;
    builder.camera({0.2 * reach, 2.5, 2.2 * reach + 2}, {0, 0.4, 0}, 0.8);
    return builder;
}

std::shared_ptr<const core::World> worldOf(const SceneBuilder& builder, core::Instancing instancing)
{
    return core::makeWorld(std::make_shared<const core::Scene>(builder.scene), 0, 0, {},
                           instancing);
}

}  // namespace tests
