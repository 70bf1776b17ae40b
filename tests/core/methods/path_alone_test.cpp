// The paths of a tile, which the CPU traces in packets and shades in blocks, are those that the
// shared text describes one by one (T24): with emitters chosen in their tree and by power, among
// surfaces of one colour and of all kinds.
#include <cmath>

#include <gtest/gtest.h>

#include "core/methods/method.h"
#include "core/methods/path_settings.h"
#include "core/scene/emitter_choice.h"
#include "core/trace/accel.h"
#include "core/trace/scene_view.h"
#include "shared/path.h"
#include "tests/support/scenes/test_scenes.h"

namespace {

using namespace tests;

constexpr uint32_t kWidth = 21, kHeight = 13;

/// A floor below lamps of 24 triangles, some of which have holes, and a ball on it.
std::shared_ptr<const core::World> hallOfLamps(const core::Material& floor, bool holes)
{
    SceneBuilder b;
    b.quad({-4, 0, 4}, {8, 0, 0}, {0, 0, -8}, b.material(floor));
    b.sphere({0.5f, 0.4f, 0}, 0.4f, 2, b.material(floor));
    for (int i = 0; i < 12; ++i) {
        core::Material lamp = emitter(glm::vec3(static_cast<float>(1 + i % 5)));
        if (holes && i % 3 == 0) {
            lamp.data.flags |= shared::kMaterialAlphaBlend;
            lamp.data.alpha = 0.4f;
        }
        const auto x = static_cast<float>(i % 4), z = static_cast<float>(i / 4);
        b.quad({-2 + x, 1.5f, -1 + z}, {0.4f, 0, 0}, {0, 0, 0.4f}, b.material(lamp));
    }
    b.camera({0, 0.8, 3}, {0, 0.3, 0}, 0.8);
    return b.world();
}

/// Whether something is in the way of a connection.
bool isOpen(const core::Accel& accel, const shared::ShadowRay& shadow, uint32_t seed)
{
    uint8_t blocked = 0;
    const core::Ray ray{shadow.origin, shadow.tMax, shadow.direction, seed};
    accel.occluded({&ray, 1}, &blocked);
    return blocked == 0;
}

/// The radiance of one path.
glm::vec3 pathAlone(const core::Accel& accel, const shared::PathSettings& settings,
                    const shared::CameraData& camera, glm::uvec2 pixel, uint32_t index)
{
    const shared::SceneView scene = core::sceneView(accel.world());
    const shared::SampleStream stream =
        shared::makeStream(settings.samplerKind, settings.seed, pixel, index, shared::kPurposePath);
    shared::PathState path = shared::beginPath(camera, settings, pixel, stream);
    glm::vec3 L(0);
    for (bool goes = true; goes;) {
        const uint32_t depth = path.depth;
        const core::Ray ray{path.origin, shared::kInfinity, path.direction,
                            shared::alphaSeed(stream, depth, 0)};
        shared::Hit hit;
        if (!accel.closest(ray, hit)) return L + shared::shadeMiss(scene, settings, path);
        shared::ShadowRay shadow;
        goes = shared::shadeSurface(scene, settings, shared::drawVertexNumbers(stream, depth), hit,
                                    path, shadow, L);
        if (shadow.contribution != glm::vec3(0) &&
            isOpen(accel, shadow, shared::alphaSeed(stream, depth, 1)))
            L += shadow.contribution;
    }
    return L;
}

/// Roundings differ where compilers fuse other operations; a random number at a threshold may then
/// lead elsewhere, in few paths.
void expectPathsAlone(const std::shared_ptr<const core::World>& world)
{
    const core::PathParams params;
    auto renderer = core::makeRenderer("path");
    renderer->setWorld(world, {});
    renderer->setView({world->cameras[0], {kWidth, kHeight}, params}, core::Start::anew);
    const core::Accel accel(world);
    shared::PathSettings settings = core::worldSettings(*world);
    settings.imageWidth = kWidth;
    settings.imageHeight = kHeight;
    core::setPathSettings(params, settings);
    const shared::CameraData camera = core::cameraData(world->cameras[0], kWidth, kHeight);
    renderer->advance({.samples = 1}, {});
    const core::Estimate film = renderer->read(core::Reading::everything);
    uint32_t differ = 0, lit = 0;
    for (uint32_t y = 0; y < kHeight; ++y) {
        for (uint32_t x = 0; x < kWidth; ++x) {
            const glm::vec3 expected = pathAlone(accel, settings, camera, {x, y}, 0);
            const float* found = &film.mean.pixels[(size_t(y) * kWidth + x) * 3];
            for (int c = 0; c < 3; ++c)
                differ += std::abs(found[c] - expected[c]) > 1e-4f * expected[c] + 1e-7f;
            lit += expected != glm::vec3(0);
        }
    }
    EXPECT_GT(lit, kWidth * kHeight / 2);
    EXPECT_LE(differ, 3u);
}

TEST(PathAlone, TilesHaveThePathsOfEachPixel)
{
    for (const bool holes : {false, true}) {
        for (const core::Material& floor :
             {lambert(glm::vec3(0.5f)), glossy(glm::vec3(0.8f), 0, 0.3f)}) {
            const auto byPower = hallOfLamps(floor, holes);
            const auto byPlace = core::chosenByPlace(byPower);
            ASSERT_EQ(byPlace->treeEmitters, 24u);
            for (const auto& world : {byPower, byPlace}) {
                SCOPED_TRACE(testing::Message()
                             << "holes " << holes << ", tree " << world->treeEmitters);
                expectPathsAlone(world);
            }
        }
    }
}

}  // namespace
