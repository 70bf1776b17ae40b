// The paths of a tile, which the CPU traces in packets and shades in blocks, are those that the
// shared text describes one by one (T24): with emitters chosen in their tree and by power, among
// surfaces of one colour and of all kinds. So are guided ones, whether they follow the guide, leave
// records, both or neither.
#include <algorithm>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "core/image/film.h"
#include "core/methods/guide_training.h"
#include "core/methods/guided_kernel.h"
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

/// What a path is shaded by where it meets something; as shared::shadeSurface.
using Shade = std::function<bool(const shared::VertexNumbers&, const shared::Hit&,
                                 shared::PathState&, shared::ShadowRay&, glm::vec3&)>;

/// The radiance of one path.
glm::vec3 pathAlone(const core::Accel& accel, const shared::PathSettings& settings,
                    const shared::CameraData& camera, glm::uvec2 pixel, uint32_t index,
                    const Shade& shade = {})
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
        const shared::VertexNumbers numbers = shared::drawVertexNumbers(stream, depth);
        goes = shade ? shade(numbers, hit, path, shadow, L)
                     : shared::shadeSurface(scene, settings, numbers, hit, path, shadow, L);
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

/// Pictures by the tiles of guided paths, of which one in four leaves records.
class GuidedTiles {
public:
    explicit GuidedTiles(const std::shared_ptr<const core::World>& world)
        : accel_(world), guide_({.box = core::guideBox(*world)})
    {
        job_.path.accel = &accel_;
        job_.path.scene = core::sceneView(*world);
        job_.path.settings = core::worldSettings(*world);
        job_.path.settings.imageWidth = kWidth;
        job_.path.settings.imageHeight = kHeight;
        core::setPathSettings(core::PathParams{}, job_.path.settings);
        job_.path.camera = core::cameraData(world->cameras[0], kWidth, kHeight);
        kernel_ = core::leastAble(core::guidedVariants(), world->features).kernel;
    }

    void follow(uint32_t followers)
    {
        job_.path.settings.guidedRules =
            shared::packGuidedRules(4, shared::kRouletteBoth, shared::kNeeBsdf, followers);
    }

    /// Samples [first, first + count) of all pixels, and what they leave.
    core::Film render(uint32_t first, uint32_t count, std::vector<core::guiding::PathRecords>& out)
    {
        core::Film film;
        film.reset(kWidth, kHeight);
        job_.path.firstSample = first;
        job_.path.sampleCount = count;
        out.assign(1, {});
        constexpr uint32_t kTile = 8;
        for (uint32_t y = 0; y < kHeight; y += kTile)
            for (uint32_t x = 0; x < kWidth; x += kTile)
                kernel_(job_, {x, y, std::min(x + kTile, kWidth), std::min(y + kTile, kHeight)},
                        film, out[0]);
        return film;
    }

    void learn(uint32_t samples)
    {
        std::vector<core::guiding::PathRecords> records;
        render(0, samples, records);
        guide_.learn(records, samples);
        tables_ = guide_.tables();
        job_.guide = tables_->view();
    }

    double guidedLeaves() const
    {
        double guided = 0;
        for (const glm::uvec4& leaf : tables_->leaves) guided += shared::uintAsFloat(leaf.y) < 1;
        return guided;
    }

    /// The same path of a pixel by itself; counts the records that it leaves.
    glm::vec3 alone(glm::uvec2 pixel, uint32_t index, size_t& records) const
    {
        const shared::PathSettings& settings = job_.path.settings;
        const bool isRecorded = shared::isRecorded(shared::guideCell(pixel & 7u), index,
                                                   shared::recordStride(settings));
        const bool follows = shared::followsGuide(settings, isRecorded);
        shared::GuidedState state = shared::beginGuided(0);
        uint32_t count = 0;
        const Shade shade = [&](const shared::VertexNumbers& numbers, const shared::Hit& hit,
                                shared::PathState& path, shared::ShadowRay& shadow, glm::vec3& L) {
            shared::GuideRecord record{};
            uint32_t recorded = isRecorded && count < shared::kGuideVertices;
            const bool goes =
                shared::shadeGuided(job_.path.scene, job_.guide, settings, follows, numbers, hit,
                                    path, state, shadow, record, recorded, L);
            count += recorded;
            return goes;
        };
        const glm::vec3 radiance =
            pathAlone(accel_, settings, job_.path.camera, pixel, index, shade);
        records += count;
        return radiance;
    }

private:
    core::Accel accel_;
    core::guiding::Guide guide_;
    std::shared_ptr<const core::guiding::GuideTables> tables_ = guide_.tables();
    core::GuidedJob job_;
    core::GuidedKernel kernel_ = nullptr;
};

void expectGuidedPathsAlone(const std::shared_ptr<const core::World>& world)
{
    GuidedTiles tiles(world);
    tiles.follow(shared::kGuideForNone);
    for (const uint32_t samples : {64u, 128u, 256u}) tiles.learn(samples);
    EXPECT_GT(tiles.guidedLeaves(), 0);
    for (const uint32_t followers :
         {shared::kGuideForAll, shared::kGuideForRecorded, shared::kGuideForNone}) {
        SCOPED_TRACE(followers);
        tiles.follow(followers);
        constexpr uint32_t kSample = 1000;
        std::vector<core::guiding::PathRecords> records;
        const core::Film film = tiles.render(kSample, 1, records);
        uint32_t differ = 0;
        size_t expectedRecords = 0;
        for (uint32_t y = 0; y < kHeight; ++y) {
            for (uint32_t x = 0; x < kWidth; ++x) {
                const glm::vec3 expected = tiles.alone({x, y}, kSample, expectedRecords);
                const glm::vec3 found(film.sum[size_t(y) * kWidth + x]);
                for (int c = 0; c < 3; ++c)
                    differ += std::abs(found[c] - expected[c]) > 1e-4f * expected[c] + 1e-7f;
            }
        }
        EXPECT_LE(differ, 3u);
        EXPECT_GT(expectedRecords,
                  kWidth * kHeight / 8);  // one path in four, where it meets something
        EXPECT_NEAR(double(records[0].records.size()), double(expectedRecords), 3);
    }
}

TEST(PathAlone, GuidedTilesHaveThePathsOfEachPixel)
{
    for (const core::Material& floor :
         {lambert(glm::vec3(0.5f)), glossy(glm::vec3(0.8f), 0, 0.3f)}) {
        const auto byPower = hallOfLamps(floor, true);
        for (const auto& world : {byPower, core::chosenByPlace(byPower)}) {
            SCOPED_TRACE(testing::Message() << "tree " << world->treeEmitters);
            expectGuidedPathsAlone(world);
        }
    }
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
