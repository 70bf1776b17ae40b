// Rooms that see the sky through a window.
#pragma once

#include "shared/emitter.h"
#include "tests/support/scenes/test_scenes.h"

namespace tests {

/// A sky that is brighter towards +X, over a dim ground; `sunny`: with a sun of one texel.
inline void addSky(SceneBuilder& b, bool sunny)
{
    core::Environment e;
    e.width = 48;
    e.height = 24;
    for (uint32_t y = 0; y < e.height; ++y) {
        for (uint32_t x = 0; x < e.width; ++x) {
            const float towards =
                1 + shared::environmentDirection({(static_cast<float>(x) + 0.5f) / 48.0f,
                                                  (static_cast<float>(y) + 0.5f) / 24.0f})
                        .x;
            const glm::vec3 sky = glm::vec3(0.8f, 1.0f, 1.4f) * (0.5f + towards);
            e.texels.emplace_back(y < 12 ? sky : glm::vec3(0.1f), 1.0f);
        }
    }
    if (sunny) e.texels[8 * 48 + 13] = glm::vec4(200.0f, 180.0f, 150.0f, 1.0f);
    b.scene.environment = std::move(e);
}

/// A grey room of 2 x 2 x 2 about the origin with a box in it; its wall at +X has a window of 0.8 x
/// 0.6.
inline SceneBuilder windowRoom(bool sunny, const core::Material& floor = lambert(glm::vec3(0.6f)))
{
    SceneBuilder b;
    const int grey = b.material(lambert(glm::vec3(0.6f)));
    b.quad({-1, -1, 1}, {2, 0, 0}, {0, 0, -2}, b.material(floor));
    b.quad({-1, 1, -1}, {2, 0, 0}, {0, 0, 2}, grey);
    b.quad({-1, -1, -1}, {2, 0, 0}, {0, 2, 0}, grey);
    b.quad({-1, -1, 1}, {0, 2, 0}, {2, 0, 0}, grey);
    b.quad({-1, -1, 1}, {0, 0, -2}, {0, 2, 0}, grey);
    // The wall around the window: below, above, and beside it.
    b.quad({1, -1, -1}, {0, 0, 2}, {0, 1, 0}, grey);
    b.quad({1, 0.6f, -1}, {0, 0, 2}, {0, 0.4f, 0}, grey);
    b.quad({1, 0, -1}, {0, 0, 0.6f}, {0, 0.6f, 0}, grey);
    b.quad({1, 0, 0.4f}, {0, 0, 0.6f}, {0, 0.6f, 0}, grey);
    b.box({-0.6f, -1, -0.6f}, {0, -0.3f, 0}, b.material(lambert({0.7f, 0.4f, 0.3f})), false);
    b.camera({-0.9, 0.3, 0.9}, {0.2, -0.4, -0.3}, 1.1);
    addSky(b, sunny);
    return b;
}

/// The same with ten small lamps under the ceiling, beside a cupboard that has none and no sky.
inline SceneBuilder roomWithLamps()
{
    SceneBuilder b = windowRoom(false);
    for (int i = 0; i < 5; ++i) {
        const int lamp = b.material(emitter(glm::vec3(static_cast<float>(1 + i))));
        b.quad({-0.8f + 0.3f * static_cast<float>(i), 0.9f, 0.5f}, {0.1f, 0, 0}, {0, 0, 0.1f},
               lamp);
    }
    core::PunctualLight light;
    light.intensity = 0.05f;
    glm::dmat4 node(1);
    node[3] = glm::dvec4(0.5, -0.8, -0.5, 1);
    b.light(light, node);
    return b;
}

}  // namespace tests
