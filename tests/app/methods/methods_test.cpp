// Every method of the table on every device that has it, driven through the one interface: nothing
// here names a method, so that none can be added untested.
#include "app/methods/methods.h"

#include <gtest/gtest.h>

#include "app/files/params_json.h"
#include "app/files/stats.h"
#include "app/pictures/reference_job.h"
#include "app/session/replay.h"
#include "app/session/set_param.h"
#include "core/base/check.h"
#include "tests/support/methods/shared_renderer.h"
#include "tests/support/scenes/asset.h"
#include "tests/support/scenes/instanced_scenes.h"
#include "tests/support/statistics/compare_films.h"
#include "tests/support/statistics/stats.h"

namespace {

using tests::asset;

/// A method's defaults with independent samples and without a limit of depth, where it has such.
core::AnyParams independent(std::string_view method, uint32_t seed)
{
    core::AnyParams params = core::methodNamed(method).defaults;
    if (uint32_t* value = core::findParam<uint32_t>(params, "seed")) *value = seed;
    if (uint32_t* value = core::findParam<uint32_t>(params, "max-depth")) *value = 24;
    app::setParam(params, "sampler", "independent");
    return params;
}

/// A method on a device that has it, with one renderer for all its tests.
struct Where {
    std::string method;
    app::DeviceKind device;

    core::Renderer& renderer() const { return tests::sharedRenderer(method, device); }
};

void PrintTo(const Where& where, std::ostream* out)
{
    *out << where.method << " on " << core::enumName(where.device);
}

/// Methods with a trait on every device that has them; without one, all methods.
std::vector<Where> everywhere(bool core::Traits::*trait = nullptr)
{
    std::vector<Where> all;
    for (const core::MethodInfo& method : core::methods())
        for (const app::DeviceKind device : {app::DeviceKind::cpu, app::DeviceKind::vulkan})
            if ((trait == nullptr || method.traits.*trait) &&
                app::whyNot(method.id(), device).empty())
                all.push_back({std::string(method.id()), device});
    return all;
}

core::Estimate renderView(core::Renderer& renderer, const core::View& view, uint32_t samples)
{
    renderer.setView(view, core::Start::anew);
    renderer.advance({.samples = samples}, {});
    return renderer.read(core::Reading::everything);
}

void expectSameBits(const core::Estimate& a, const core::Estimate& b)
{
    EXPECT_EQ(a.samples, b.samples);
    EXPECT_EQ(a.mean.pixels, b.mean.pixels);
    EXPECT_EQ(a.variance.pixels, b.variance.pixels);
    EXPECT_EQ(a.weight.pixels, b.weight.pixels);
}

class EveryMethod : public testing::TestWithParam<Where> {
protected:
    core::Renderer& renderer() const { return GetParam().renderer(); }
    const core::MethodInfo& info() const { return core::methodNamed(GetParam().method); }
};

class DeterministicMethod : public EveryMethod {};
class RadianceMethod : public EveryMethod {};

TEST_P(DeterministicMethod, SameBitsForAnyStepsAndPauses)
{
    const auto world = asset("cornell-glossy");
    renderer().setWorld(world, {});
    const core::View view{world->cameras.at(0), {100, 75}, info().defaults};
    const core::Estimate expected = renderView(renderer(), view, 13);
    EXPECT_EQ(expected.samples, 13u);
    EXPECT_TRUE(expected.counters.clean());
    expectSameBits(expected, renderView(renderer(), view, 13));

    renderer().setView(view, core::Start::anew);
    for (const uint32_t part : {1u, 4u, 0u, 1u, 5u, 2u}) renderer().advance({.samples = part}, {});
    expectSameBits(expected, renderer().read(core::Reading::everything));

    // Stopped after every piece, and resumed.
    renderer().setPace({.dispatchSeconds = 0.001});
    renderer().setView(view, core::Start::anew);
    uint64_t version = renderer().progress().version;
    while (renderer().progress().samples < 13) {
        const auto left = static_cast<uint32_t>(13 - renderer().progress().samples);
        renderer().advance({.samples = left, .seconds = 0}, {});
        ASSERT_GT(renderer().progress().version, version) << "a call without a piece of work";
        version = renderer().progress().version;
    }
    renderer().setPace({});
    renderer().advance({.samples = 0}, {});
    expectSameBits(expected, renderer().read(core::Reading::everything));

    std::stop_source stop;
    stop.request_stop();
    version = renderer().progress().version;
    renderer().advance({.samples = 5}, stop.get_token());  // stopped before it begins
    EXPECT_EQ(renderer().progress().version, version);

    // The mean alone is that of everything.
    const core::Image mean = renderer().read(core::Reading::mean).mean;
    for (size_t i = 0; i < mean.pixels.size(); ++i)
        ASSERT_NEAR(mean.pixels[i], expected.mean.pixels[i], 1e-6f * expected.mean.pixels[i]) << i;
}

TEST_P(EveryMethod, SeedsMatter)
{
    core::AnyParams params = info().defaults;
    uint32_t* seed = core::findParam<uint32_t>(params, "seed");
    ASSERT_NE(seed, nullptr) << "a reference needs a seed of its own";
    const auto world = asset("cornell-glossy");
    renderer().setWorld(world, {});
    const core::View view{world->cameras.at(0), {32, 24}, params};
    const core::Estimate one = renderView(renderer(), view, 2);
    core::View other = view;
    *core::findParam<uint32_t>(other.params, "seed") = *seed + 1;
    EXPECT_NE(one.mean.pixels, renderView(renderer(), other, 2).mean.pixels);
}

/// A closed box of albedo 0.5 that emits 1 shows 2 everywhere; an albedo of 0.8 makes 5 of it. The
/// error is that between pictures of different seeds, since a method's pixels may share their
/// light.
TEST_P(RadianceMethod, FurnacesAreUniform)
{
    for (const auto& [name, radiance] :
         {std::pair("furnace-50", 2.0), std::pair("furnace-80", 5.0)}) {
        const auto world = asset(name);
        renderer().setWorld(world, {});
        tests::Moments means;
        for (uint32_t seed = 0; seed < 16; ++seed) {
            core::AnyParams params = independent(GetParam().method, 3 + seed);
            if (uint32_t* depth = core::findParam<uint32_t>(params, "max-depth")) *depth = 4096;
            const core::Estimate e =
                renderView(renderer(), {world->cameras.at(0), {32, 32}, params}, 16);
            double sum = 0;
            for (const float value : e.mean.pixels) sum += double(value);
            means.add(sum / double(e.mean.pixels.size()));
        }
        const double error = std::sqrt(means.varianceOfMean());
        const double t = std::abs(means.mean() - radiance) / (error + 1e-5 * radiance);
        EXPECT_GT(tests::studentTwoSidedP(t, 15), tests::kLevel)
            << name << ": " << means.mean() << " +- " << error;
        EXPECT_LT((6.0 + 2.6) * error, 0.02 * radiance) << name << " is underpowered";
    }
}

/// T37: a picture does not tell whether meshes are stored once.
TEST_P(EveryMethod, InstancesLookLikeWhatTheyShow)
{
    tests::Thing thing;
    thing.leaf.data.flags |= shared::kMaterialAlphaBlend;
    thing.leaf.data.alpha = 0.6f;
    const tests::SceneBuilder scene = tests::thicket(49, thing);
    std::array<core::Estimate, 2> pictures;
    for (const core::Instancing instancing : {core::Instancing::flat, core::Instancing::kept}) {
        const auto world = tests::worldOf(scene, instancing);
        const bool kept = instancing == core::Instancing::kept;
        ASSERT_EQ(world->instances.size(), kept ? 49u : 0u);
        renderer().setWorld(world, {});
        const core::AnyParams params = independent(GetParam().method, kept ? 5 : 6);
        pictures[kept ? 1 : 0] =
            renderView(renderer(), {world->cameras.at(0), {64, 48}, params}, 48);
        EXPECT_TRUE(pictures[kept ? 1 : 0].counters.clean());
    }
    const tests::FilmComparison c = tests::compareFilms(pictures[0], pictures[1]);
    EXPECT_TRUE(c.agree()) << c.describe();
    EXPECT_GT(c.meanA, 0);
    EXPECT_LT(c.detectable, 0.05) << c.describe();
}

TEST_P(EveryMethod, FirstHitsAreThoseOfTheWorldAndDoNotDisturbThePicture)
{
    const auto world = asset("cornell-glossy");
    renderer().setWorld(world, {});
    const core::View view{world->cameras.at(0), {40, 30}, info().defaults};
    const core::Estimate expected = renderView(renderer(), view, 3);
    const core::Aovs aovs = renderer().aovs();
    expectSameBits(expected, renderer().read(core::Reading::everything));
    EXPECT_GT(*aovs.depth.at(20, 15), 0.0f);
    EXPECT_GE(aovs.ids.at(20, 15)[0], 0.0f);
}

TEST_P(EveryMethod, FirstHitsOfOtherSizesAreThoseOfAViewOfThatSize)
{
    const auto world = asset("cornell-glossy");
    renderer().setWorld(world, {});
    const core::Camera& camera = world->cameras.at(0);
    const glm::uvec2 small(20, 16), large(80, 61);
    core::Camera other = camera;
    other.position.x += 0.1;
    renderer().setView({other, large, info().defaults}, core::Start::anew);
    const core::Aovs expected = renderer().aovs();
    const core::View view{camera, small, info().defaults};
    const core::Estimate whole = renderView(renderer(), view, 3);
    renderer().setView(view, core::Start::anew);
    renderer().advance({.samples = 1}, {});
    const core::Aovs found = renderer().surfaces(other, large, core::Sight::first);
    for (const auto& image :
         {&core::Aovs::depth, &core::Aovs::normal, &core::Aovs::albedo, &core::Aovs::ids})
        EXPECT_EQ((found.*image).pixels, (expected.*image).pixels);
    while (renderer().progress().samples < 3) renderer().advance({.samples = 1}, {});
    expectSameBits(whole, renderer().read(core::Reading::everything));
}

TEST_P(EveryMethod, MapsAreWhatTheTableSays)
{
    const auto world = asset("cornell-glossy");
    renderer().setWorld(world, {});
    renderer().setView({world->cameras.at(0), {40, 30}, info().defaults}, core::Start::anew);
    EXPECT_TRUE(renderer().maps().empty());
    renderer().advance({.samples = 1}, {});
    const std::vector<core::Image> maps = renderer().maps();
    ASSERT_EQ(maps.size(), info().maps.size());
    for (size_t i = 0; i < maps.size(); ++i) {
        EXPECT_GT(std::string_view(info().maps[i].help).size(), 10u);
        ASSERT_EQ(glm::uvec3(maps[i].width, maps[i].height, maps[i].channels),
                  glm::uvec3(40, 30, 1));
        for (const float x : maps[i].pixels) ASSERT_TRUE(std::isfinite(x)) << info().maps[i].name;
    }
}

/// What a picture says of itself is enough to ask for it again.
TEST_P(EveryMethod, MetadataLeadBackToTheParameters)
{
    const auto world = asset("cornell-glossy");
    core::AnyParams params = independent(GetParam().method, 41);
    app::PictureFacts facts{.scene = {.file = REKINDLE_SOURCE_DIR "/assets/cornell-glossy.gltf",
                                      .world = world,
                                      .time = 0,
                                      .environment = core::kOwnEnvironment},
                            .camera = world->cameras.at(0),
                            .size = {16, 12},
                            .params = params,
                            .samples = 3,
                            .device = "cpu",
                            .driver = "",
                            .ended = "spp"};
    EXPECT_EQ(app::replayOf(app::imageMetadata(facts), "x.exr").params, params);
}

std::string nameOf(const testing::TestParamInfo<Where>& where)
{
    return where.param.method + "_" + std::string(core::enumName(where.param.device));
}

/// Methods of paths, each for itself, which can be kept from scattering: a sample of theirs brings
/// what is emitted towards the camera.
TEST(Methods, CentredSamplesSeeWhatFirstHitsTell)
{
    int tried = 0;
    for (const Where& where : everywhere(&core::Traits::radiance)) {
        const core::MethodInfo& method = core::methodNamed(where.method);
        core::AnyParams params = method.defaults;
        uint32_t* const depth = core::findParam<uint32_t>(params, "max-depth");
        if (depth == nullptr || method.traits.sharesLight) continue;
        *depth = 0;
        ++tried;
        for (const char* scene : {"cornell-glossy", "sky"}) {
            SCOPED_TRACE(where.method + ", " + scene);
            const auto world = asset(scene);
            where.renderer().setWorld(world, {});
            const core::View view{world->cameras.at(0), {40, 30}, params, true};
            const core::Image mean = renderView(where.renderer(), view, 1).mean;
            const core::Image emission = where.renderer().aovs().emission;
            float most = 0;
            for (size_t i = 0; i < mean.pixels.size(); ++i) {
                ASSERT_NEAR(mean.pixels[i], emission.pixels[i], 1e-5f * (1 + emission.pixels[i]))
                    << i;
                most = std::max(most, mean.pixels[i]);
            }
            EXPECT_GT(most, 0) << "there is a lamp, or a sky";
        }
    }
    EXPECT_GE(tried, 6);
}

INSTANTIATE_TEST_SUITE_P(Table, EveryMethod, testing::ValuesIn(everywhere()), nameOf);
INSTANTIATE_TEST_SUITE_P(Table, DeterministicMethod,
                         testing::ValuesIn(everywhere(&core::Traits::deterministic)), nameOf);
INSTANTIATE_TEST_SUITE_P(Table, RadianceMethod,
                         testing::ValuesIn(everywhere(&core::Traits::radiance)), nameOf);

/// Where pixels share their light their differences cannot be told from noise pixel by pixel: both
/// devices get the same seed, and with it the same light.
void expectSamePicture(const core::Estimate& a, const core::Estimate& b, const std::string& where)
{
    double mean = 0, difference = 0;
    for (size_t i = 0; i < a.mean.pixels.size(); ++i) {
        mean += double(b.mean.pixels[i]);
        difference += std::abs(double(a.mean.pixels[i]) - double(b.mean.pixels[i]));
    }
    EXPECT_GT(mean, 0) << where;
    EXPECT_LT(difference, 1e-5 * mean) << where;
}

TEST(Methods, DevicesAgree)
{
    for (const core::MethodInfo& method : core::methods()) {
        const std::string id(method.id());
        const Where cpu{id, app::DeviceKind::cpu}, vulkan{id, app::DeviceKind::vulkan};
        if (!app::whyNot(id, cpu.device).empty() || !app::whyNot(id, vulkan.device).empty())
            continue;
        for (const char* name : {"cornell-diffuse", "textured-box", "sky"}) {
            const auto world = asset(name);
            cpu.renderer().setWorld(world, {});
            vulkan.renderer().setWorld(world, {});
            const core::Camera& camera = world->cameras.at(0);
            if (method.traits.sharesLight) {
                const core::View view{camera, {48, 48}, independent(id, 1)};
                expectSamePicture(renderView(vulkan.renderer(), view, 3),
                                  renderView(cpu.renderer(), view, 3), id + ", " + name);
                continue;
            }
            const tests::FilmComparison c = tests::compareFilms(
                renderView(vulkan.renderer(), {camera, {48, 48}, independent(id, 1)}, 192),
                renderView(cpu.renderer(), {camera, {48, 48}, independent(id, 2)}, 192));
            EXPECT_TRUE(c.agree()) << id << ", " << name << ": " << c.describe();
            EXPECT_LT(c.detectable, 0.1) << id << ", " << name << " is underpowered";
        }
    }
}

/// What is kept from picture to picture on a device is allocated in units of several pixels.
TEST(Methods, PicturesMayGrowByAFewPixels)
{
    const auto world = asset("cornell-diffuse");
    for (const core::MethodInfo& method : core::methods()) {
        const std::string id(method.id());
        for (const app::DeviceKind device : {app::DeviceKind::cpu, app::DeviceKind::vulkan}) {
            if (!app::whyNot(id, device).empty()) continue;
            const auto renderer = app::makeRenderer(id, {.device = device});
            renderer->setWorld(world, {});
            for (const glm::uvec2 size : {glm::uvec2(1), {2, 1}, {2, 2}, {7, 3}, {4, 6}, {5, 5}}) {
                renderer->setView({world->cameras.at(0), size, independent(id, 1)},
                                  core::Start::anew);
                renderer->advance({.samples = 2}, {});
                const core::Estimate e = renderer->read(core::Reading::everything);
                EXPECT_EQ(e.mean.pixels.size(), size_t(3) * size.x * size.y) << id;
                EXPECT_TRUE(e.counters.clean()) << id;
            }
        }
    }
}

TEST(Methods, WhatADeviceLacksSaysWhy)
{
    for (const core::MethodInfo& method : core::methods()) {
        bool somewhere = false;
        for (const app::DeviceKind device : {app::DeviceKind::cpu, app::DeviceKind::vulkan}) {
            const std::string why = app::whyNot(method.id(), device);
            somewhere = somewhere || why.empty();
            if (why.empty()) continue;
            try {
                app::makeRenderer(method.id(), {.device = device});
                FAIL() << method.id() << " was made where it does not run";
            } catch (const core::Error& error) {
                EXPECT_EQ(error.code(), core::ExitCode::commandLine);
                EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
            }
        }
        EXPECT_TRUE(somewhere) << method.id() << " runs nowhere";
    }
    for (const app::DeviceKind device : {app::DeviceKind::cpu, app::DeviceKind::vulkan}) {
        try {
            app::makeRenderer("magic", {.device = device});
            FAIL() << "was made";
        } catch (const core::Error& error) {
            const std::string text = error.what();
            EXPECT_NE(text.find("magic"), std::string::npos) << text;
            EXPECT_NE(text.find(core::methods().front().id()), std::string::npos) << text;
        }
    }
}

/// The reference of any method is of that method, and its noise is not that of the picture.
TEST(Methods, ReferencesAreIndependentOfThePicture)
{
    for (const core::MethodInfo& method : core::methods()) {
        if (method.make == nullptr) continue;
        app::ReferenceOrder order;
        order.world = asset("cornell-glossy");
        order.camera = order.world->cameras.at(0);
        order.size = {32, 24};
        order.params = independent(method.id(), 5);
        order.samples = 128;
        const auto box = std::make_shared<core::Mailbox<app::Reference>>();
        core::Worker worker("core");
        const uint64_t generation = worker.start("reference", app::referenceJob(order, box));
        worker.wait();
        ASSERT_EQ(worker.status().state, core::JobState::done) << worker.status().error;
        const auto reference = box->get(generation);
        ASSERT_NE(reference, nullptr);
        EXPECT_EQ(reference->samples, 128u);
        EXPECT_NE(reference->origin.find(method.id()), std::string::npos) << reference->origin;
        const auto renderer = method.make();
        renderer->setWorld(order.world, {});
        const core::Estimate e =
            renderView(*renderer, {order.camera, order.size, order.params}, 128);
        EXPECT_NE(e.mean.pixels, reference->mean.pixels);
    }
}

}  // namespace
