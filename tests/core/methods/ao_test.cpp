// Ambient occlusion against closed forms, on every device. With directions of density cos / pi the
// open share is an area on the unit disk (Nusselt's analogon): what blocks within a distance d cuts
// a known piece off. Triangles of any size leave themselves open, on every device (T16).
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "app/methods/methods.h"
#include "tests/support/scenes/instanced_scenes.h"
#include "tests/support/scenes/test_scenes.h"
#include "tests/support/statistics/stats.h"

namespace {

using namespace tests;

class Ao : public testing::TestWithParam<app::DeviceKind> {
protected:
    void SetUp() override
    {
        const std::string why = app::whyNot("ao", GetParam());
        if (!why.empty()) GTEST_SKIP() << why;
        renderer_ = app::makeRenderer("ao", {.device = GetParam()});
    }

    /// The open share that camera `camera` sees, over 16 x 16 pixels.
    PictureMean open(const std::shared_ptr<const core::World>& world, float distance, uint32_t spp,
                     size_t camera = 0)
    {
        core::AoParams params;
        params.distance = distance;
        params.sampler = core::SamplerKind::independent;
        params.seed = static_cast<uint32_t>(7 + camera);
        renderer_->setWorld(world, {});
        renderer_->setView({world->cameras.at(camera), {16, 16}, params}, core::Start::anew);
        renderer_->advance({.samples = spp}, {});
        const core::Estimate e = renderer_->read(core::Reading::everything);
        EXPECT_TRUE(e.counters.clean());
        EXPECT_GT(renderer_->stats().rays, 0u);
        return estimate(e);
    }

    void expectShare(const PictureMean& e, double exact)
    {
        // The footprint of the pixels is worth 2e-4.
        EXPECT_LT(std::abs(e.mean - exact), kScore * std::sqrt(e.varianceOfMean) + 2e-4)
            << e.mean << " instead of " << exact;
        EXPECT_LT((kScore + 2.33) * std::sqrt(e.varianceOfMean), 0.01) << "underpowered";
    }

private:
    std::unique_ptr<core::Renderer> renderer_;
};

/// A floor, and a camera that looks at the point of it under the middle.
SceneBuilder floorAt()
{
    SceneBuilder b;
    b.quad({-50, 0, 50}, {100, 0, 0}, {0, 0, -100}, b.material(lambert(glm::vec3(0.5f))));
    b.camera({0.2, 0.5, 0.3}, {0, 0, 0}, 0.002);
    return b;
}

TEST_P(Ao, AClosedBoxIsDarkAndAnOpenFloorIsNot)
{
    SceneBuilder box;
    box.box({-1, -1, -1}, {1, 1, 1}, box.material(lambert(glm::vec3(0.5f))), true);
    box.camera({0.1, 0.2, 0.3}, {1, 0.4, -0.5}, 1.2);
    const PictureMean dark = open(box.world(), 0, 16);
    EXPECT_EQ(dark.mean, 0);
    const PictureMean bright = open(floorAt().world(), 0, 16);
    EXPECT_NEAR(bright.mean, 1, 1e-12);
}

/// A wall at distance h blocks the directions whose component towards it is at least h / d: a
/// segment of the disk.
TEST_P(Ao, AWallCutsASegmentOffTheDisk)
{
    for (const double h : {0.25, 0.6}) {
        SceneBuilder b = floorAt();
        b.quad({h, -1, 50}, {0, 101, 0}, {0, 0, -100}, b.material(lambert(glm::vec3(0.5f))));
        const auto world = b.world();
        for (const double d : {0.5 * h, 1.25 * h, 3 * h}) {
            const double r = h / d;
            const double cut =
                r < 1 ? (std::acos(r) - r * std::sqrt(1 - r * r)) / std::numbers::pi : 0;
            expectShare(open(world, static_cast<float>(d), 512), 1 - cut);
        }
    }
}

/// A ceiling at height h blocks the directions whose cosine is at least h / d: all but a ring.
TEST_P(Ao, ACeilingLeavesARing)
{
    SceneBuilder b = floorAt();
    b.quad({-50, 1, 50}, {0, 0, -100}, {100, 0, 0}, b.material(lambert(glm::vec3(0.5f))));
    const auto world = b.world();
    for (const double d : {0.9, 1.1, 2.0})
        expectShare(open(world, static_cast<float>(d), 512), d < 1 ? 1 : 1 / (d * d));
}

/// A ground that reaches `side` to all sides and lies beside the scene's centre, at which the
/// camera looks; what hangs below it gives the scene a height, and with it boxes that rays enter.
struct LargeGround {
    const char* name;
    double side, across, height, tilt;  // across: to two of the sides
};

SceneBuilder largeGround(const LargeGround& g)
{
    SceneBuilder b;
    const int grey = b.material(lambert(glm::vec3(0.5f)));
    const double below = std::min(g.side / 60, 10.0), far = 0.4 * g.side;
    const int ground = b.looseMesh({{-g.side, g.height, g.across},
                                    {g.side, g.height, g.across},
                                    {g.side, g.height, -g.across},
                                    {-g.side, g.height, -g.across}},
                                   {{0, 1, 2}, {0, 2, 3}}, grey);
    b.looseMesh({{far, g.height, 0}, {far + 1, g.height, 0}, {far, g.height - below, 0}},
                {{0, 1, 2}}, grey);
    const glm::dmat4 turn = glm::rotate(glm::dmat4(1), glm::radians(g.tilt), {0.6, 0, 0.8});
    b.node(turn, {ground, ground + 1});
    const double away = g.side / 100;
    b.camera(glm::dvec3(turn * glm::dvec4(0.2 * away, g.height + away, 0.3 * away, 1)),
             glm::dvec3(turn * glm::dvec4(0, g.height, 0, 1)), 0.7);
    return b;
}

/// The error of a hit is that of its triangle's size, however near the centre it is.
TEST_P(Ao, LargeGroundsDoNotShadowThemselves)
{
    for (const LargeGround& g :
         {LargeGround{"flat", 50, 50, -0.05, 0}, LargeGround{"of kilometres", 5000, 5000, -5, 0},
          LargeGround{"tilted by 5", 60, 60, 0, 5}, LargeGround{"tilted by 15", 60, 60, 0, 15},
          LargeGround{"tilted by 45", 60, 60, 0, 45}, LargeGround{"road", 50, 1, -0.05, 20},
          LargeGround{"board", 5, 0.05, -0.05, 10}}) {
        const PictureMean e = open(largeGround(g).world(), 0, 64);
        EXPECT_NEAR(e.mean, 1, 1e-12) << g.name;
    }
}

/// Nor where they are stored once, in a space of their own.
TEST_P(Ao, LargeInstancesDoNotShadowThemselves)
{
    for (const double height : {0.0, 0.3}) {
        SceneBuilder b = largeGround({"instances", 50, 50, height, 10});
        const glm::dmat4 under = glm::translate(glm::dmat4(1), glm::dvec3(3, -2, 5));
        b.node(glm::scale(under, glm::dvec3(0.01)), {0, 1});
        const auto world = worldOf(b, core::Instancing::kept);
        ASSERT_EQ(world->instances.size(), 2u);
        EXPECT_NEAR(open(world, 0, 64).mean, 1, 1e-12) << height;
    }
}

/// What lies a centimetre above kilometres of ground darkens it.
TEST_P(Ao, SmallThingsShadowLargeGrounds)
{
    SceneBuilder b = largeGround({"of kilometres", 5000, 5000, -5, 0});
    b.quad({-1, -4.99f, 1}, {0, 0, -2}, {2, 0, 0}, b.material(lambert(glm::vec3(0.5f))));
    b.camera({0.002, -4.995, 0.003}, {0, -5, 0}, 0.7);
    EXPECT_LT(open(b.world(), 0, 16, 1).mean, 0.01);
}

/// What the camera does not hit is open.
TEST_P(Ao, TheBackgroundIsOpen)
{
    SceneBuilder b = floorAt();
    b.camera({0, 1, 0}, {0, 2, 0.01}, 0.5);
    EXPECT_NEAR(open(b.world(), 0, 4, 1).mean, 1, 1e-12);
}

/// The world is scaled where its size would cost digits; what is asked for is in the file's metres.
TEST_P(Ao, DistancesAreThoseOfTheFile)
{
    const auto shareOf = [this](double scale) {
        SceneBuilder b;
        const auto s = static_cast<float>(scale);
        const int grey = b.material(lambert(glm::vec3(0.5f)));
        b.quad(s * glm::vec3(-5, 0, 5), {10 * s, 0, 0}, {0, 0, -10 * s}, grey);
        b.quad(s * glm::vec3(-5, 1, 5), {10 * s, 0, 0}, {0, 0, -10 * s}, grey);
        b.camera(scale * glm::dvec3(0.02, 0.5, 0.03), glm::dvec3(0), 0.002);
        return open(b.world(), static_cast<float>(1.5 * scale), 256).mean;
    };
    const double usual = shareOf(1);
    EXPECT_GT(usual, 0.3);
    EXPECT_LT(usual, 0.7);
    for (const double scale : {1.0 / 64, 64.0}) EXPECT_NEAR(shareOf(scale), usual, 0.02) << scale;
}

INSTANTIATE_TEST_SUITE_P(Devices, Ao,
                         testing::Values(app::DeviceKind::cpu, app::DeviceKind::vulkan),
                         [](const auto& device) {
                             return std::string(core::enumName(device.param));
                         });

}  // namespace
