// Path tracing that keeps its samples, on a camera that moves, on every device: what is kept
// changes no mean, or as little as was allowed.
#include <algorithm>
#include <cmath>
#include <random>

#include <glm/gtc/packing.hpp>

#include "shared/warp.h"
#include "tests/support/methods/reuse_flights.h"
#include "tests/support/scenes/test_scenes.h"
#include "tests/support/statistics/compare_films.h"
#include "tests/support/statistics/stats.h"

namespace {

using namespace tests;

class ReuseBias : public ReuseFlights {};

/// Every strategy that claims it, over independent flights: the mean over the picture stays within
/// half a per cent, which the flights could tell. Visibility of old samples is not asked for again,
/// so that it could be off.
TEST_P(ReuseBias, AMoveLeavesTheMeanAsItIs)
{
    constexpr uint32_t kFlights = 48, kFrames = 8;
    constexpr double kBound = 0.005;
    begin("cornell-moderate", {24, 24});
    const double expected = meanOf(reference(2048).mean);
    struct Case {
        ReuseStrategy strategy;
        float rays;
    };
    for (const auto [strategy, rays] :
         {Case{ReuseStrategy::ra, 1}, Case{ReuseStrategy::mis, 1},
          Case{ReuseStrategy::reweighting, 1}, Case{ReuseStrategy::ra, 2.5f},
          Case{ReuseStrategy::rejectionAugmentation, 1}, Case{ReuseStrategy::restirGi, 1}}) {
        tests::Moments means;
        for (uint32_t flight = 0; flight < kFlights; ++flight) {
            const core::Estimate e = fly(with(strategy, 100 + flight, rays), kFrames, 1.5);
            EXPECT_TRUE(e.counters.clean());
            means.add(meanOf(e.mean));
        }
        const double error = std::sqrt(means.varianceOfMean());
        EXPECT_LT(std::abs(means.mean() - expected), kBound * expected + tests::kScore * error)
            << core::enumName(strategy) << ", rays " << rays;
        EXPECT_LT(error, 0.01 * expected) << core::enumName(strategy) << " is underpowered";
    }
}

/// How far the mean of independent flights is from the truth, in its standard errors, over squares
/// of 2 x 2 pixels: 1 without bias.
double meanSquareScore(std::span<const core::Image> flights, const core::Image& truth)
{
    double sum = 0;
    size_t count = 0;
    for (uint32_t y = 0; y + 1 < truth.height; y += 2) {
        for (uint32_t x = 0; x + 1 < truth.width; x += 2, ++count) {
            const auto brightness = [&](const core::Image& image) {
                double all = 0;
                for (uint32_t k = 0; k < 4; ++k)
                    for (uint32_t c = 0; c < 3; ++c)
                        all += double(image.at(x + k % 2, y + k / 2)[c]);
                return all;
            };
            tests::Moments found;
            for (const core::Image& flight : flights) found.add(brightness(flight));
            sum += std::pow(found.mean() - brightness(truth), 2) / found.varianceOfMean();
        }
    }
    return sum / double(count);
}

/// Where old samples are asked for visibility, and new ones whether the view before could have had
/// them, nothing is wrong in any part of the picture. The same flights without asking are far off,
/// which shows that this test would tell.
TEST_P(ReuseBias, AskingForVisibilityTakesTheBiasAway)
{
    constexpr uint32_t kFrames = 5, kFlights = 96;
    begin("cornell-diffuse", {24, 24});
    const core::Image truth = reference(8192).mean;
    const auto scoreOf = [&](core::ReuseBias bias) {
        std::vector<core::Image> flights;
        for (uint32_t flight = 0; flight < kFlights; ++flight) {
            ReuseParams params = with(ReuseStrategy::ra, 4000 + flight);
            params.bias = bias;
            flights.push_back(fly(params, kFrames, 6).mean);
        }
        return meanSquareScore(flights, truth);
    };
    EXPECT_LT(scoreOf(core::ReuseBias::unbiased), 1.5);  // of 144 squares: 1.05 +- .13
    EXPECT_GT(scoreOf(core::ReuseBias::fast), 4);
}

/// A bound is kept by asking as often as it takes, and no more often.
TEST_P(ReuseBias, ABoundOfTheBiasIsKept)
{
    constexpr uint32_t kFlights = 48, kFrames = 12;
    begin("cornell-diffuse", {24, 24});
    const double expected = meanOf(reference(8192).mean);
    double asked[2];
    for (const float bound : {0.002f, 0.1f}) {
        tests::Moments means;
        for (uint32_t flight = 0; flight < kFlights; ++flight) {
            ReuseParams params = with(ReuseStrategy::ra, 5000 + flight);
            params.bias = core::ReuseBias::bounded;
            params.bound = bound;
            means.add(meanOf(fly(params, kFrames, 6).mean));
        }
        const double error = std::sqrt(means.varianceOfMean());
        EXPECT_LT(std::abs(means.mean() - expected),
                  double(bound) * expected + tests::kScore * error);
        EXPECT_LT(error, 0.002 * expected);
        asked[bound < 0.01f ? 0 : 1] = detail("visibility");
    }
    EXPECT_GT(asked[0], 0.3);
    EXPECT_LT(asked[1], 0.1);
}

/// The bound is one of moves: passes that follow in the same view find nothing hidden, and must not
/// make it look as if there were less than there is.
TEST_P(ReuseBias, PassesThatFollowDoNotLoosenTheBound)
{
    constexpr uint32_t kFlights = 16, kFrames = 12;
    begin("cornell-diffuse", {24, 24});
    tests::Moments visibility[2], wrong[2];
    for (uint32_t flight = 0; flight < kFlights; ++flight)
        for (const bool several : {false, true}) {
            ReuseParams params = with(ReuseStrategy::ra, 6000 + flight);
            params.bias = core::ReuseBias::bounded;
            params.bound = 0.002f;
            fly(params, kFrames, 6, several ? 8 : 1);
            visibility[several ? 1 : 0].add(detail("visibility"));
            wrong[several ? 1 : 0].add(detail("leak") + detail("loss"));
        }
    EXPECT_GT(visibility[1].mean(), 0.8 * visibility[0].mean());
    // More, since the history that a move begins with is longer: 1.35 times +- .06.
    EXPECT_GT(wrong[1].mean(), wrong[0].mean());
    EXPECT_LT(wrong[1].mean(), 1.6 * wrong[0].mean());
}

/// Below one path per pixel, those with a good history take turns: the mean stays, too, and so many
/// are really spared.
TEST_P(ReuseBias, FewPathsLeaveTheMeanAsItIs)
{
    constexpr uint32_t kFlights = 24, kFrames = 24;
    begin("cornell-diffuse", {24, 24});
    const double expected = meanOf(reference(2048).mean);
    uint64_t paths[2];
    for (const bool few : {false, true}) {
        tests::Moments means;
        for (uint32_t flight = 0; flight < kFlights; ++flight) {
            fly(with(ReuseStrategy::ra, 300 + flight, few ? 0.25f : 1), kFrames, 0.25);
            means.add(meanOf(renderer_->read(core::Reading::mean).mean));
        }
        paths[few ? 1 : 0] = renderer_->stats().paths;
        const double error = std::sqrt(means.varianceOfMean());
        EXPECT_LT(std::abs(means.mean() - expected), 0.005 * expected + tests::kScore * error);
        EXPECT_LT(error, 0.01 * expected);
    }
    EXPECT_LT(double(paths[1]), 0.7 * double(paths[0]));
}

/// A white sky over a floor whose normals differ from texel to texel by some ten degrees.
core::Scene bumpyFloor()
{
    core::Scene scene;
    core::Material material = tests::lambert(glm::vec3(0.6f));
    material.data.flags |= shared::kMaterialDoubleSided;
    core::Texture texture;
    texture.width = texture.height = 64;
    std::mt19937 random(3);
    std::normal_distribution<float> slope(0, 0.1745f);
    for (int i = 0; i < 64 * 64; ++i) {
        const float x = slope(random), y = slope(random);
        const glm::vec3 n = 0.5f * glm::normalize(glm::vec3(x, y, 1)) + 0.5f;
        const auto half = [](float value) { return glm::packHalf1x16(value); };
        texture.texels.push_back({half(n.x), half(n.y), half(n.z), half(1)});
    }
    scene.textures.push_back(texture);
    core::TextureUse use;
    use.texture = 0;
    use.record = {};
    use.record.flags = shared::kTextureNearest;
    use.record.row0 = glm::vec3(1, 0, 0);
    use.record.row1 = glm::vec3(0, 1, 0);
    scene.textureUses.push_back(use);
    material.textures[shared::kTextureNormal] = 0;
    scene.materials.push_back(material);
    core::Mesh mesh;
    mesh.material = 0;
    mesh.positions = {{-20, 0, 20}, {20, 0, 20}, {20, 0, -20}, {-20, 0, -20}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.hasNormals = mesh.hasTexCoords = mesh.hasTangents = true;
    for (const glm::vec2 uv : {glm::vec2(0, 0), {10, 0}, {10, 10}, {0, 10}})
        mesh.attributes.push_back({shared::packOct(glm::vec3(0, 1, 0)), uv.x, uv.y,
                                   shared::packTangent(glm::vec3(1, 0, 0), 1)});
    scene.meshes.push_back(mesh);
    core::Node node;
    node.meshes = {0, 1};
    scene.nodes.push_back(node);
    core::Environment sky;
    sky.width = 8;
    sky.height = 4;
    sky.texels.assign(32, glm::vec4(1));
    scene.environment = sky;
    return scene;
}

/// Old samples are where the old normal let them be: what only the new one sees is left to new
/// samples. With the new pixel's lobe in the place of the old one's, six per cent of the light of
/// this floor were missing.
TEST_P(ReuseBias, NormalMapsLeaveTheMeanAsItIs)
{
    constexpr int kFrames = 70, kFirst = 30, kStep = 8;
    world_ = core::makeWorld(std::make_shared<const core::Scene>(bumpyFloor()), 0);
    renderer_->setWorld(world_, {});
    size_ = {24, 24};
    const auto camera = [](int frame) {
        const double x = -3 + 0.041 * frame, z = 0.013 * frame;
        return core::lookAt({x, 2.5, z}, {x, 0, z - 0.3}, {0, 0, -1}, 0.6);
    };
    const auto params = [](ReuseStrategy strategy, core::ReuseBias bias, uint32_t seed) {
        ReuseParams p = with(strategy, seed);
        p.maxDepth = 1;
        p.bias = bias;
        p.jitter = PixelJitter::always;
        return p;
    };
    tests::Moments truth;
    for (int frame = kFirst; frame < kFrames; frame += kStep) {
        look(camera(frame), params(ReuseStrategy::discard, core::ReuseBias::fast, 5),
             core::Start::anew, 128);
        truth.add(meanOf(renderer_->read(core::Reading::mean).mean));
    }
    for (const core::ReuseBias bias : {core::ReuseBias::fast, core::ReuseBias::unbiased}) {
        tests::Moments means;
        for (uint32_t flight = 0; flight < 6; ++flight) {
            double sum = 0;
            int count = 0;
            for (int frame = 0; frame < kFrames; ++frame) {
                look(camera(frame), params(ReuseStrategy::ra, bias, 40 + flight),
                     frame == 0 ? core::Start::anew : core::Start::moved);
                if (frame < kFirst || (frame - kFirst) % kStep != 0) continue;
                sum += meanOf(renderer_->read(core::Reading::mean).mean);
                ++count;
            }
            means.add(sum / count);
        }
        // The error is .7 per cent.
        EXPECT_NEAR(means.mean() / truth.mean(), 1, 0.03) << core::enumName(bias);
    }
}

INSTANTIATE_TEST_SUITE_P(Device, ReuseBias,
                         testing::Values(app::DeviceKind::cpu, app::DeviceKind::vulkan),
                         DeviceName());

}  // namespace
