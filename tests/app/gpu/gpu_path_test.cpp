// The Vulkan path tracer against the Embree one (T18), against itself (T23, T24), its first hits
// (T26), its counters (T25), rays that are cut short (V19), with validation and synchronization
// validation on throughout (V1), and refusals with numbers (V13).
#include <numeric>

#include <gtest/gtest.h>

#include "app/gpu/base/memory.h"
#include "app/gpu/methods/methods.h"
#include "app/gpu/methods/path.h"
#include "core/base/pcg32.h"
#include "core/methods/guided_params.h"
#include "core/methods/method.h"
#include "core/methods/reuse_params.h"
#include "core/scene/emitter_choice.h"
#include "tests/support/methods/sky_preparing.h"
#include "tests/support/process/kept_objects.h"
#include "tests/support/scenes/asset.h"
#include "tests/support/scenes/instanced_scenes.h"
#include "tests/support/scenes/sky_rooms.h"
#include "tests/support/scenes/test_scenes.h"
#include "tests/support/statistics/compare_films.h"
#include "tests/support/statistics/random_values.h"

namespace {

using tests::asset;

/// One device for all tests: making one costs compilation.
core::Renderer& gpuRenderer()
{
    static core::Renderer& renderer =
        tests::kept(gpu::makePathRenderer({.index = -1, .validation = true}));
    return renderer;
}

core::PathParams independentPaths(uint32_t seed, uint32_t depth = 6)
{
    core::PathParams params;
    params.sampler = core::SamplerKind::independent;
    params.seed = seed;
    params.maxDepth = depth;
    return params;
}

core::Estimate renderFilm(core::Renderer& renderer, const core::World& world, uint32_t width,
                          uint32_t height, uint32_t samples, const core::PathParams& params)
{
    renderer.setView({world.cameras.at(0), {width, height}, params}, core::Start::anew);
    renderer.advance({.samples = samples}, {});
    const core::Estimate film = renderer.read(core::Reading::everything);
    return film;
}

/// An asset, the samples per pixel that its test takes, and the relative bias of the mean that they
/// can show.
struct SceneCase {
    const char* name;
    uint32_t samples;
    double detectable;
};

class GpuPath : public testing::TestWithParam<SceneCase> {
protected:
    void TearDown() override { EXPECT_EQ(gpu::validationMessages(), messages_); }

private:
    const uint64_t messages_ = gpu::validationMessages();
};

void expectAgreement(const char* name, const std::shared_ptr<const core::World>& world,
                     uint32_t samples, double detectable, const core::PathParams& params)
{
    core::PathParams other = params;
    other.seed = 2;
    gpuRenderer().setWorld(world, {});
    const auto cpu = core::makeRenderer("path");
    cpu->setWorld(world, {});
    const core::Estimate a = renderFilm(gpuRenderer(), *world, 64, 64, samples, params);
    const core::Estimate b = renderFilm(*cpu, *world, 64, 64, samples, other);
    const tests::FilmComparison c = tests::compareFilms(a, b);
    EXPECT_TRUE(c.agree()) << name << ": " << c.describe();
    EXPECT_LT(c.detectable, detectable) << name << " is underpowered: " << c.describe();
    EXPECT_GT(c.meanA, 0) << name;
    EXPECT_TRUE(a.counters.clean()) << name;
    EXPECT_TRUE(b.counters.clean()) << name;
}

TEST_P(GpuPath, AgreesWithCpu)
{
    const SceneCase c = GetParam();
    expectAgreement(c.name, asset(c.name), c.samples, c.detectable, independentPaths(1));
}

TEST_P(GpuPath, SlowAgreesWithCpu)
{
    const SceneCase c = GetParam();
    const double factor = std::max(c.detectable / 0.01, 1.0);  // to see 1 %, with a tenth to spare
    expectAgreement(c.name, asset(c.name),
                    static_cast<uint32_t>(1.1 * factor * factor * c.samples) + 1,
                    std::min(c.detectable, 0.01), independentPaths(1));
}

/// What blends is there all over or not at all: nothing is cut along the edges of triangles.
TEST(FirstHits, WhatBlendsIsDecidedByHalf)
{
    constexpr uint32_t kSide = 16;
    const auto cpu = core::makeRenderer("path");
    for (const float alpha : {0.3f, 0.7f}) {
        tests::SceneBuilder b;
        core::Material veil = tests::lambert(glm::vec3(0.2f));
        veil.data.flags |= shared::kMaterialAlphaBlend;
        veil.data.alpha = alpha;
        const int wall = b.material(tests::lambert(glm::vec3(0.5f)));
        const int before = b.material(veil);
        for (int i = 0; i < 4; ++i)
            b.quad({-1 + 0.5f * static_cast<float>(i), -1, 1}, {0.5f, 0, 0}, {0, 2, 0}, before);
        b.quad({-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, wall);
        b.camera({0, 0, 5}, {0, 0, 0}, 0.4);
        const auto world = b.world();
        for (core::Renderer* renderer : {cpu.get(), &gpuRenderer()}) {
            renderer->setWorld(world, {});
            renderer->setView({world->cameras.at(0), {kSide, kSide}, {}}, core::Start::anew);
            const core::Aovs aovs = renderer->aovs();
            const int expected = alpha > 0.5f ? before : wall;
            for (uint32_t y = 0; y < kSide; ++y)
                for (uint32_t x = 0; x < kSide; ++x)
                    ASSERT_EQ(aovs.ids.at(x, y)[1], static_cast<float>(expected))
                        << (renderer == cpu.get() ? "cpu " : "vulkan ") << alpha << ' ' << x << ' '
                        << y;
        }
    }
}

TEST_P(GpuPath, FirstHitsAreThoseOfTheCpu)
{
    const auto world = asset(GetParam().name);
    const size_t size = 256;
    gpuRenderer().setWorld(world, {});
    gpuRenderer().setView({world->cameras.at(0), {256, 256}, {}}, core::Start::anew);
    const core::Aovs a = gpuRenderer().aovs();
    const auto cpu = core::makeRenderer("path");
    cpu->setWorld(world, {});
    cpu->setView({world->cameras.at(0), {256, 256}, {}}, core::Start::anew);
    const core::Aovs b = cpu->aovs();
    // Pixel centres on an edge that triangles share (the corners of a box, say) may name any of
    // them: equal depth is a tie.
    size_t otherIds = 0, otherDepths = 0, otherNormals = 0, otherAlbedos = 0, hits = 0;
    for (size_t p = 0; p < size * size; ++p) {
        const bool deeper =
            std::abs(a.depth.pixels[p] - b.depth.pixels[p]) > 1e-5f * b.depth.pixels[p];
        const bool same = a.ids.pixels[3 * p] == b.ids.pixels[3 * p];
        otherIds += !same && deeper ? 1u : 0u;
        if (!same) continue;
        hits += a.depth.pixels[p] > 0 ? 1u : 0u;
        otherDepths += deeper ? 1u : 0u;
        for (size_t k = 3 * p; k < 3 * p + 3; ++k) {
            otherNormals += std::abs(a.normal.pixels[k] - b.normal.pixels[k]) > 1e-3f ? 1u : 0u;
            otherAlbedos += std::abs(a.albedo.pixels[k] - b.albedo.pixels[k]) > 1e-3f ? 1u : 0u;
        }
    }
    EXPECT_GT(hits, 1000u);
    EXPECT_LE(otherIds, 7u);  // 1e-4 of the pixels
    EXPECT_LE(otherDepths, 7u);
    EXPECT_LE(otherNormals, 21u);
    EXPECT_LE(otherAlbedos, 21u);
}

// The door's light comes through a gap: what a quick test can see of it is little, the slow one
// sees 1 %.
INSTANTIATE_TEST_SUITE_P(
    Assets, GpuPath,
    testing::Values(SceneCase{"cornell-diffuse", 900, 0.02},
                    SceneCase{"cornell-glossy", 1500, 0.02}, SceneCase{"textured-box", 512, 0.02},
                    SceneCase{"glass", 512, 0.02}, SceneCase{"lights", 1400, 0.02},
                    SceneCase{"hall", 1000, 0.03}, SceneCase{"door-ajar", 1900, 0.1},
                    SceneCase{"sky", 512, 0.02}, SceneCase{"furnace-sphere", 128, 0.01}),
    [](const auto& instance) {
        std::string name = instance.param.name;
        std::replace(name.begin(), name.end(), '-', '_');
        return name;
    });

class GpuPathAlone : public testing::Test {
protected:
    void TearDown() override { EXPECT_EQ(gpu::validationMessages(), messages_); }

private:
    const uint64_t messages_ = gpu::validationMessages();
};

TEST_F(GpuPathAlone, SameSeedGivesTheSameBitsHoweverItIsCutUp)
{
    const auto world = asset("cornell-glossy");
    gpuRenderer().setWorld(world, {});
    for (const core::SamplerKind sampler :
         {core::SamplerKind::sobol, core::SamplerKind::independent}) {
        core::PathParams params;
        params.sampler = sampler;
        const core::Estimate once = renderFilm(gpuRenderer(), *world, 100, 75, 13, params);
        const core::Estimate twice = renderFilm(gpuRenderer(), *world, 100, 75, 13, params);
        EXPECT_EQ(once.mean.pixels, twice.mean.pixels);

        renderFilm(gpuRenderer(), *world, 31, 17, 2, params);  // another size in between
        gpuRenderer().setView({world->cameras.at(0), {100, 75}, params}, core::Start::anew);
        for (const uint32_t part : {1u, 4u, 1u, 5u, 2u})
            gpuRenderer().advance({.samples = part}, {});
        const core::Estimate parts = gpuRenderer().read(core::Reading::everything);
        EXPECT_EQ(once.mean.pixels, parts.mean.pixels);
        EXPECT_EQ(once.variance.pixels, parts.variance.pixels);
        EXPECT_EQ(parts.samples, 13u);

        params.seed = 2;
        EXPECT_NE(once.mean.pixels,
                  renderFilm(gpuRenderer(), *world, 100, 75, 13, params).mean.pixels);
    }
}

/// Lamps of all kinds, more than a few, and a sky, behind tinted walls: the emitter tree, panes and
/// what both keep in the state of a path, in both kernels.
TEST_F(GpuPathAlone, LampsBehindWallsAgreeWithCpu)
{
    tests::SceneBuilder b;
    b.quad({-4, 0, 4}, {8, 0, 0}, {0, 0, -8}, b.material(tests::lambert(glm::vec3(0.5f))));
    b.sphere({0.5f, 0.4f, 0}, 0.4f, 2, b.material(tests::glossy(glm::vec3(0.8f), 0, 0.3f)));
    core::Material pane = tests::lambert(glm::vec3(0.9f, 0.7f, 0.8f));
    pane.data.transmission = 1;
    pane.data.roughness = 0;
    b.quad({-4, 1, 4}, {8, 0, 0}, {0, 0, -8}, b.material(pane));
    for (int i = 0; i < 6; ++i) {
        const int lamp = b.material(tests::emitter(glm::vec3(static_cast<float>(2 + i))));
        b.quad({-3 + static_cast<float>(i), 1.5f, -1}, {0.4f, 0, 0}, {0, 0, 0.4f}, lamp);
        b.quad({-3 + static_cast<float>(i), 0.3f, -2}, {0.2f, 0, 0}, {0, 0.2f, 0}, lamp);
    }
    core::PunctualLight light;
    light.intensity = 2;
    glm::dmat4 node(1);
    node[3] = glm::dvec4(1, 2, 1, 1);
    b.light(light, node);
    b.constantEnvironment(glm::vec3(0.2f));
    b.camera({0, 0.8, 3}, {0, 0.3, 0}, 0.8);
    const auto world = core::chosenByPlace(b.world());
    ASSERT_GT(world->treeEmitters, 0u);
    ASSERT_NE(world->features & shared::kFeaturePanes, 0u);
    for (const core::Kernel kernel : {core::Kernel::wavefront, core::Kernel::megakernel}) {
        core::PathParams params = independentPaths(1);
        params.kernel = kernel;
        expectAgreement("lamps behind walls", world, 700, 0.02, params);
    }
}

/// T36: the sky through a window, with lamps and without, in both kernels.
TEST_F(GpuPathAlone, SkyThroughWindowsAgreesWithCpu)
{
    for (const bool lamps : {false, true}) {
        const auto world = (lamps ? tests::roomWithLamps() : tests::windowRoom(false)).world();
        for (const core::Kernel kernel : {core::Kernel::wavefront, core::Kernel::megakernel}) {
            core::PathParams params = independentPaths(1);
            params.kernel = kernel;
            expectAgreement("room with a window", world, 300, 0.02, params);
            bool drawn = false;
            for (const core::StatsDetail& detail : gpuRenderer().stats().details)
                drawn = drawn || detail.name == "sky_regions";
            EXPECT_TRUE(drawn);
        }
    }
}

/// First hits before a kernel is there are those of the view, and are not in its picture.
TEST_F(GpuPathAlone, ALookBeforeTheFirstPictureShowsItsFirstHits)
{
    const auto world = asset("glass");
    core::PathParams params;
    const auto renderer = gpu::makePathRenderer({.index = -1, .validation = true});
    const core::View view{world->cameras.at(0), {33, 20}, params};
    renderer->setWorld(world, {});
    const std::optional<core::Aovs> look = renderer->look(view);
    ASSERT_TRUE(look.has_value());
    EXPECT_EQ(renderer->progress().samples, 0u);
    const core::Estimate film = renderFilm(*renderer, *world, 33, 20, 2, params);
    const core::Aovs aovs = renderer->aovs();
    EXPECT_EQ(look->depth.pixels, aovs.depth.pixels);
    EXPECT_EQ(look->normal.pixels, aovs.normal.pixels);
    EXPECT_EQ(look->albedo.pixels, aovs.albedo.pixels);
    EXPECT_EQ(look->ids.pixels, aovs.ids.pixels);
    EXPECT_FALSE(renderer->look(view).has_value()) << "what is compiled need not be waited for";
    const core::Estimate again = renderFilm(*renderer, *world, 33, 20, 2, params);
    EXPECT_EQ(film.mean.pixels, again.mean.pixels);
    EXPECT_EQ(film.counters.nan, 0u);
}

/// The kernels of these take seconds to compile, too.
TEST_F(GpuPathAlone, MethodsWithPathsLookFirst)
{
    const auto world = asset("glass");
    const auto look = [&](std::unique_ptr<core::Renderer> renderer, const core::AnyParams& params) {
        const core::View view{world->cameras.at(0), {33, 20}, params};
        renderer->setWorld(world, {});
        const std::optional<core::Aovs> first = renderer->look(view);
        ASSERT_TRUE(first.has_value()) << params.id();
        renderer->setView(view, core::Start::anew);
        renderer->advance({.samples = 1}, {});
        EXPECT_EQ(first->ids.pixels, renderer->aovs().ids.pixels) << params.id();
        EXPECT_FALSE(renderer->look(view).has_value()) << params.id();
    };
    look(gpu::makeGuidedPaths({.index = -1, .validation = true}), core::GuidedParams{});
    look(gpu::makeSampleReuse({.index = -1, .validation = true}), core::ReuseParams{});
}

/// There a hierarchy is built for it.
TEST_F(GpuPathAlone, LookingForTheSkyCanBeStopped)
{
    const auto world = tests::windowRoom(false).world();
    core::PathParams params;
    params.sky = core::SkySampling::regions;
    EXPECT_EQ(tests::expectStoppable(gpuRenderer(), world, params),
              (std::set<std::string>{"building the BVH", "looking for the sky"}));
}

TEST_F(GpuPathAlone, BothKernelsGiveTheSameImage)
{
    for (const char* name : {"cornell-glossy", "glass", "lights"}) {
        const auto world = asset(name);
        gpuRenderer().setWorld(world, {});
        core::PathParams params;
        params.maxDepth = 32;  // more bounces than one submission holds, fewer than Mesa's loops
                               // allow a whole path
        params.kernel = core::Kernel::wavefront;
        const core::Estimate a = renderFilm(gpuRenderer(), *world, 96, 64, 8, params);
        params.kernel = core::Kernel::megakernel;
        const core::Estimate b = renderFilm(gpuRenderer(), *world, 96, 64, 8, params);
        EXPECT_EQ(a.mean.pixels, b.mean.pixels) << name;
    }
}

/// A closed white room full of long slivers, whose boxes all overlap: a ray looks at most of them.
std::shared_ptr<const core::World> sliverRoom(uint32_t count)
{
    tests::SceneBuilder b;
    b.box(glm::vec3(-0.1f), glm::vec3(1.1f),
          b.material(tests::emitter(glm::vec3(1), glm::vec3(0.9f))), true);
    core::Pcg32 random(7);
    std::vector<glm::vec3> positions;
    std::vector<glm::uvec3> triangles;
    for (uint32_t i = 0; i < count; ++i) {
        const auto at = [&](float side) {
            return glm::vec3(side) + 0.05f * glm::vec3(tests::uniform(random),
                                                       tests::uniform(random),
                                                       tests::uniform(random));
        };
        const glm::vec3 a = at(0), c = at(0.95f);
        positions.insert(positions.end(), {a, c, c + glm::vec3(1e-4f, 0, 0)});
        triangles.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
    }
    b.mesh(positions, triangles, b.material(tests::lambert(glm::vec3(0.9f))));
    b.camera({1, 0.1, 0.1}, {0, 0.9, 0.8}, 0.8);
    return b.world();
}

/// Whether the device leaves loops that turn too often, as Mesa's software device does on Debian 12
/// (22.3; 25.0 on Debian 13 does not): then rays through many slivers are cut short, and counted.
bool leavesLoops(const core::Estimate& ofManySlivers)
{
    return ofManySlivers.counters.stackOverflow > 0;
}

core::Estimate ofManySlivers(core::Renderer& renderer)
{
    const auto world = sliverRoom(40000);
    renderer.setWorld(world, {});
    return renderFilm(renderer, *world, 8, 8, 1, independentPaths(5, 1));
}

/// A software device may leave loops in all of a lane: a path that it cuts short is taken by
/// bounces, whichever kernel is asked for.
TEST_F(GpuPathAlone, PathsThatOneLaneCannotFollowAreTakenByBounces)
{
    const bool leaves = leavesLoops(ofManySlivers(gpuRenderer()));
    const auto world = sliverRoom(2000);
    gpuRenderer().setWorld(world, {});
    core::PathParams params = independentPaths(5, 32);
    params.rouletteDepth = 4096;
    params.kernel = core::Kernel::megakernel;
    const core::Estimate whole = renderFilm(gpuRenderer(), *world, 8, 8, 1, params);
    const uint64_t rays = gpuRenderer().stats().rays;
    if (leaves) {
        EXPECT_EQ(std::get<std::string>(gpuRenderer().stats().details[0].value), "wavefront")
            << "the scene is no test";
    }
    params.kernel = core::Kernel::wavefront;
    const core::Estimate bounces = renderFilm(gpuRenderer(), *world, 8, 8, 1, params);
    EXPECT_EQ(whole.mean.pixels, bounces.mean.pixels);
    EXPECT_EQ(rays, gpuRenderer().stats().rays);
    EXPECT_TRUE(whole.counters.clean());
    EXPECT_TRUE(bounces.counters.clean());
}

/// And where it cannot even follow one ray, it is told. Where nothing is told nothing is missing.
TEST_F(GpuPathAlone, RaysThatAreCutShortAreCounted)
{
    const core::Estimate film = ofManySlivers(gpuRenderer());
    EXPECT_EQ(film.counters.nan + film.counters.inf + film.counters.negative, 0u);
    if (leavesLoops(film)) {
        EXPECT_TRUE(gpu::Device({}).isSoftware());
    } else {
        const auto cpu = core::makePathTracer();
        const auto mean = [](const core::Estimate& e) {
            return std::accumulate(e.mean.pixels.begin(), e.mean.pixels.end(), 0.0);
        };
        EXPECT_NEAR(mean(film) / mean(ofManySlivers(*cpu)), 1, 0.01);
    }
}

TEST_F(GpuPathAlone, DepthLimitsMeanWhatTheySay)
{
    // A closed box of albedo 0.5 that emits 1 everywhere: depth n gives 2 - 2^-n, every path, every
    // pixel.
    const auto world = asset("furnace-50");
    gpuRenderer().setWorld(world, {});
    for (const uint32_t depth : {0u, 1u, 2u, 5u, 17u, 40u}) {
        core::PathParams params = independentPaths(3, depth);
        params.rouletteDepth = 4096;
        params.strategy = core::Strategy::bsdf;
        const core::Estimate film = renderFilm(gpuRenderer(), *world, 16, 16, 4, params);
        for (const float mean : film.mean.pixels)
            ASSERT_NEAR(mean, 2 - std::pow(0.5, depth), 2e-5) << depth;
    }
}

/// T37: of 65 thousand triangles that are stored.
TEST_F(GpuPathAlone, AHundredMillionTrianglesAgreeWithCpu)
{
    const auto world =
        tests::worldOf(tests::thicket(3200, {.levels = 6}), core::Instancing::automatic);
    ASSERT_GT(core::shownTriangles(*world), 100'000'000u);
    const auto onDevice = gpu::makePathRenderer({.index = -1, .validation = true});
    onDevice->setWorld(world, {});
    const auto cpu = core::makeRenderer("path");
    cpu->setWorld(world, {});
    const core::Estimate a = renderFilm(*onDevice, *world, 64, 64, 192, independentPaths(1));
    const core::Estimate b = renderFilm(*cpu, *world, 64, 64, 192, independentPaths(2));
    const tests::FilmComparison c = tests::compareFilms(a, b);
    EXPECT_TRUE(c.agree()) << c.describe();
    EXPECT_LT(c.detectable, 0.05) << c.describe();
    EXPECT_LT(onDevice->stats().peakDeviceBytes, 64u << 20);
}

TEST_F(GpuPathAlone, ASceneThatDoesNotFitIsRefusedWithTheNumbers)
{
    gpu::Device device({});
    try {
        const gpu::Buffer buffer(device, "the BVH",
                                 uint64_t(device.limits().maxTexelBufferElements) * 16 + 16,
                                 VK_FORMAT_R32G32B32A32_UINT, gpu::BufferOf::scene);
        FAIL() << "a buffer beyond the device's limit was made";
    } catch (const core::Error& error) {
        EXPECT_EQ(error.code(), core::ExitCode::deviceLost);
        EXPECT_NE(
            std::string(error.what()).find(std::to_string(device.limits().maxTexelBufferElements)),
            std::string::npos)
            << error.what();
        EXPECT_NE(std::string(error.what()).find("the scene does not fit"), std::string::npos);
    }
    try {
        const gpu::Buffer buffer(device, "the paths",
                                 uint64_t(device.limits().maxTexelBufferElements) * 16 + 16,
                                 VK_FORMAT_R32G32B32A32_UINT);
        FAIL() << "a buffer beyond the device's limit was made";
    } catch (const core::Error& error) {
        EXPECT_NE(std::string(error.what()).find("the image does not fit"), std::string::npos)
            << error.what();
    }
    EXPECT_EQ(device.allocatedBytes, 0u);
}

}  // namespace
