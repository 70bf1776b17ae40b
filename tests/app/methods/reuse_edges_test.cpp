// T-38. First hits on the edges of walls, on every device: the camera looks into the middle of a
// square box, whose edges lie on the diagonals of the picture, and so under the middles of pixels.
// And the edges of the picture: what comes in over them has no history.
#include <algorithm>
#include <cmath>

#include "tests/support/methods/reuse_flights.h"
#include "tests/support/scenes/test_scenes.h"
#include "tests/support/statistics/image_mean.h"

namespace {

using namespace tests;

using ReuseEdges = ReuseFlights;

TEST_P(ReuseEdges, PointsOnTheEdgesOfWallsSeeLight)
{
    constexpr uint32_t kSide = 48;
    begin("cornell-diffuse", {kSide, kSide});
    const core::Image image = reference(256).mean;
    // One wall may have little of a colour of which the other has much.
    const auto at = [&](uint32_t x, uint32_t y) {
        const float* c = image.at(x, y);
        return double(c[0]) + double(c[1]) + double(c[2]);
    };
    uint32_t edges = 0;
    for (uint32_t i = 1; i < 8; ++i) {
        for (const uint32_t x : {i, kSide - 1 - i}) {
            for (const uint32_t y : {i, kSide - 1 - i}) {
                const double beside = std::min(at(x - 1, y), at(x + 1, y));
                EXPECT_GT(at(x, y), 0.2 * beside) << x << ", " << y;
                edges += beside > 0 ? 1 : 0;
            }
        }
    }
    EXPECT_EQ(edges, 28u);
}

/// A wall in the sun, and the camera before it; a board behind the camera, beyond the right border
/// of what it sees first, shades a part of the wall.
std::shared_ptr<const core::World> halfShadedWall()
{
    SceneBuilder b;
    b.quad({-20, -20, 0}, {40, 0, 0}, {0, 40, 0}, b.material(lambert(glm::vec3(0.5f))));
    b.quad({1.5f, -20, 6}, {20, 0, 0}, {0, 40, 0}, b.material(lambert(glm::vec3(0.5f))));
    core::PunctualLight light;
    light.kind = shared::kEmitterDirectional;
    light.intensity = 2;
    b.light(light, glm::dmat4(1));                               // towards -z
    b.camera({0, 0, 4}, {0, 0, 0}, float(2 * std::atan(0.25)));  // two wide
    return b.world();
}

/// The camera moves towards the shadow by less than half a pixel a view. Handed on by the pixels at
/// the border, light of before would cover it: 9 % too much. Which pixel a history comes from moves
/// the shadow's border by less than a pixel, 3 % of the light.
TEST_P(ReuseEdges, WhatComesInOverTheBorderHasNoHistory)
{
    constexpr uint32_t kSide = 32, kViews = 32;
    constexpr double kStep = 0.4 * 2 / kSide;
    begin(halfShadedWall(), {kSide, kSide});
    const auto flown = [&](ReuseStrategy strategy) {
        ReuseParams params = with(strategy, 1);
        params.maxDepth = 1;
        const core::Camera camera = world_->cameras.at(0);
        for (uint32_t i = 0; i < kViews; ++i) {
            const glm::dvec3 at = camera.position + glm::dvec3(kStep * i, 0, 0);
            look(core::lookAt(at, at + camera.forward, {0, 1, 0}, camera.yfov), params,
                 i == 0 ? core::Start::anew : core::Start::moved);
        }
        return meanOf(renderer_->read(core::Reading::mean).mean);
    };
    const double truth = flown(ReuseStrategy::discard);
    ASSERT_GT(truth, 0);
    for (const ReuseStrategy strategy : {ReuseStrategy::ra, ReuseStrategy::naive})
        EXPECT_NEAR(flown(strategy) / truth, 1, 0.03) << core::enumName(strategy);
}

INSTANTIATE_TEST_SUITE_P(Device, ReuseEdges,
                         testing::Values(app::DeviceKind::cpu, app::DeviceKind::vulkan),
                         DeviceName());

}  // namespace
