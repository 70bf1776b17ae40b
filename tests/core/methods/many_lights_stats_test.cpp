// What rendering with many lights tells of itself: what a view has cost and lit, not what views
// before it have.
#include <gtest/gtest.h>

#include <atomic>

#include "core/base/machine_memory.h"
#include "core/gltf/gltf.h"
#include "core/methods/many_lights.h"
#include "core/methods/method.h"
#include "tests/support/methods/slice_twin.h"
#include "tests/support/methods/stats_number.h"

namespace {

using glm::vec3;
using tests::number;

std::shared_ptr<const core::World> box()
{
    return core::makeWorld(core::loadGltf(REKINDLE_SOURCE_DIR "/assets/cornell-diffuse.gltf"));
}

core::ManyLightsParams few()
{
    return {.lights = 1000, .clusters = 50, .sliceSize = 200};
}

/// The lights of the first sample serve all views; the first of these has paid for them.
TEST(ManyLightsStats, LightsOfEarlierViewsCostNothing)
{
    const auto world = box();
    const auto renderer = core::makeRenderer("manylights");
    renderer->setWorld(world, {});
    core::Camera camera = world->cameras.at(0);
    core::ManyLightsParams params = few();
    const auto renderNext = [&] {
        camera.position.x += 0.01;
        renderer->setView({camera, {24, 24}, params}, core::Start::anew);
        renderer->advance({.samples = 1}, {});
    };
    renderNext();
    const double lights = number(*renderer, "lights");
    const uint64_t rays = renderer->stats().rays;
    EXPECT_GT(lights, 0);
    EXPECT_GT(number(*renderer, "seconds_lights"), 0);
    EXPECT_GT(number(*renderer, "seconds_tree"), 0);
    renderNext();
    EXPECT_EQ(number(*renderer, "lights"), lights);
    EXPECT_EQ(number(*renderer, "seconds_lights"), 0);
    EXPECT_EQ(number(*renderer, "seconds_tree"), 0);
    EXPECT_LT(renderer->stats().rays, rays) << "rays of the lights, traced for the view before";
    renderer->advance({.samples = 1}, {});
    EXPECT_GT(number(*renderer, "seconds_lights"), 0) << "the second sample has its own";
    params.lights = 2000;
    renderNext();
    EXPECT_GT(number(*renderer, "seconds_lights"), 0);
}

/// A camera that moves has other parameters than one at rest.
TEST(ManyLightsStats, LightsOfEarlierParametersCostNothing)
{
    const auto world = box();
    const auto renderer = core::makeRenderer("manylights");
    renderer->setWorld(world, {});
    const auto render = [&](uint32_t lights) {
        core::ManyLightsParams params = few();
        params.lights = lights;
        renderer->setView({world->cameras.at(0), {24, 24}, params}, core::Start::anew);
        renderer->advance({.samples = 1}, {});
        return renderer->read(core::Reading::mean).mean.pixels;
    };
    const std::vector<float> first = render(300), second = render(500);
    EXPECT_GT(number(*renderer, "seconds_lights"), 0);
    EXPECT_EQ(render(300), first);
    EXPECT_EQ(number(*renderer, "seconds_lights"), 0);
    EXPECT_EQ(render(500), second);
    EXPECT_EQ(number(*renderer, "seconds_lights"), 0);
    for (const uint32_t lights : {700u, 900u}) render(lights);
    EXPECT_EQ(render(300), first);
    EXPECT_GT(number(*renderer, "seconds_lights"), 0) << "not more than two are kept";
    EXPECT_NE(render(500), first);
    renderer->setWorld(world, {});
    EXPECT_EQ(render(300), first);
    EXPECT_GT(number(*renderer, "seconds_lights"), 0) << "another scene has other lights";
}

/// Lights depend on few parameters: the others leave them, and the picture is that of a renderer
/// that has never had any other.
TEST(ManyLightsStats, LightsStayWhereOnlyTheirUseChanges)
{
    const auto world = box();
    const auto renderer = core::makeRenderer("manylights");
    renderer->setWorld(world, {});
    const auto pictureBy = [&](core::Renderer& by, const core::ManyLightsParams& params) {
        by.setView({world->cameras.at(0), {16, 16}, params}, core::Start::anew);
        by.advance({.samples = 1}, {});
        return by.read(core::Reading::mean).mean.pixels;
    };
    const auto expectSame = [&](const char* name, const core::ManyLightsParams& params, bool kept) {
        const std::vector<float> found = pictureBy(*renderer, params);
        EXPECT_EQ(number(*renderer, "seconds_lights") == 0, kept) << name;
        EXPECT_EQ(number(*renderer, "seconds_tree") == 0, kept) << name;
        const auto fresh = core::makeRenderer("manylights");
        fresh->setWorld(world, {});
        EXPECT_EQ(pictureBy(*fresh, params), found) << name;
        EXPECT_EQ(number(*fresh, "clamp_distance"), number(*renderer, "clamp_distance")) << name;
    };
    core::ManyLightsParams params = few();
    params.lights = 300;
    expectSame("the first", params, false);
    params.clusters = 20;
    expectSame("clusters", params, true);
    params.completion.method = core::many_lights::CompletionMethod::matching;
    expectSame("completion", params, true);
    params.receivers = 4;
    expectSame("receivers", params, true);
    params.clamp = 0;
    expectSame("no clamp", params, true);
    params.clamp = 1;
    expectSame("clamp", params, true);
    params.technique = core::many_lights::Technique::lightcuts;
    expectSame("technique", params, true);
    params.maxDepth = 3;
    expectSame("depth", params, false);
    params.sampler = core::SamplerKind::independent;
    expectSame("sampler", params, false);
    params.seed = 2;
    expectSame("seed", params, false);
}

/// Sets of lights that are large for the machine are not kept beside those at work.
TEST(ManyLightsStats, LargeLightsAreNotKept)
{
    const auto world = box();
    const auto renderer = core::makeRenderer("manylights");
    renderer->setWorld(world, {});
    const core::MemoryLimit little(1 << 20);  // of which lights take a third
    for (int view = 0; view < 2; ++view) {
        renderer->setView({world->cameras.at(0), {16, 16}, few()}, core::Start::anew);
        renderer->advance({.samples = 1}, {});
        EXPECT_GT(number(*renderer, "seconds_lights"), 0) << view;
    }
}

/// Numbers of rays are all of the whole picture.
TEST(ManyLightsStats, RaysAddUpOverSamples)
{
    const auto world = box();
    const auto renderer = core::makeRenderer("manylights");
    renderer->setWorld(world, {});
    core::ManyLightsParams params = few();
    params.technique = core::many_lights::Technique::rowColumn;
    renderer->setView({world->cameras.at(0), {24, 24}, params}, core::Start::anew);
    double technique = 0;
    for (int sample = 1; sample <= 2; ++sample) {
        renderer->advance({.samples = 1}, {});
        EXPECT_GT(number(*renderer, "technique_rays"), technique);
        technique = number(*renderer, "technique_rays");
        double sum = 0;
        for (const char* part :
             {"light_rays", "camera_rays", "technique_rays", "visibility_rays", "lost_light_rays"})
            sum += number(*renderer, part);
        EXPECT_EQ(sum, double(renderer->stats().rays));
    }
}

/// Sums on the CPU until it is told to fail.
class Failing final : public core::ManyLightsDevice {
public:
    explicit Failing(const std::atomic<bool>& fails) : fails_(fails) {}
    void setWorld(std::shared_ptr<const core::World> world, const core::Progress&) override
    {
        world_ = std::move(world);
    }
    void prepare(const core::many_lights::SumRules&) override {}
    void setPace(const core::Pace&) override {}
    void addTo(core::RenderStats&) const override {}
    uint64_t batchEntries() const override { return 1 << 20; }
    double sum(std::span<const core::many_lights::SlicePiece> pieces,
               const core::many_lights::SumRules& rules, std::span<vec3> radiance) override
    {
        if (fails_) throw core::Error("the device is lost", core::ExitCode::deviceLost);
        return tests::SliceTwin(*world_).sum(pieces, rules, radiance);
    }

private:
    const std::atomic<bool>& fails_;
    std::shared_ptr<const core::World> world_;
};

/// Counts what a device is asked for.
class Counting final : public core::ManyLightsDevice {
public:
    explicit Counting(int& calls) : calls_(calls) {}
    void setWorld(std::shared_ptr<const core::World> world, const core::Progress&) override
    {
        ++calls_;
        world_ = std::move(world);
    }
    void prepare(const core::many_lights::SumRules&) override { ++calls_; }
    void setPace(const core::Pace&) override {}
    void addTo(core::RenderStats& stats) const override { stats.device = "twin"; }
    uint64_t batchEntries() const override { return 1 << 20; }
    double sum(std::span<const core::many_lights::SlicePiece> pieces,
               const core::many_lights::SumRules& rules, std::span<vec3> radiance) override
    {
        ++calls_;
        return tests::SliceTwin(*world_).sum(pieces, rules, radiance);
    }

private:
    int& calls_;
    std::shared_ptr<const core::World> world_;
};

/// Neither scenes nor kernels are made for a device whose sums nobody asks for; it gets them as
/// soon as somebody does, of the pose that is shown then.
TEST(ManyLightsStats, TechniquesOfTheCpuLeaveTheDeviceAlone)
{
    const auto world = box();
    int calls = 0;
    const auto renderer = core::makeManyLights(std::make_unique<Counting>(calls));
    core::ManyLightsParams params = few();
    const auto render = [&](core::many_lights::Technique technique) {
        params.technique = technique;
        renderer->setView({world->cameras.at(0), {24, 24}, params}, core::Start::anew);
        renderer->advance({.samples = 1}, {});
        EXPECT_EQ(renderer->progress().samples, 1u);
        return renderer->stats().device;
    };
    using core::many_lights::Technique;
    renderer->setWorld(world, {});
    for (const Technique technique :
         {Technique::lightcuts, Technique::illuminationCut, Technique::matSep})
        EXPECT_EQ(render(technique), "cpu") << core::enumName(technique);
    renderer->setWorld(box(), {});
    EXPECT_EQ(calls, 0);
    EXPECT_EQ(render(Technique::clusters), "twin");
    EXPECT_GE(calls, 3);
    calls = 0;
    renderer->setWorld(box(), {});
    EXPECT_EQ(calls, 1) << "a pose of a view that the device sums goes there at once";
}

/// A sample of which no slice has been lit yet does not hide the one before it.
TEST(ManyLightsStats, TellOfTheLatestSampleThatHasLitSomething)
{
    const auto world = box();
    std::atomic<bool> fails = false;
    const auto renderer = core::makeManyLights(std::make_unique<Failing>(fails));
    renderer->setWorld(world, {});
    renderer->setView({world->cameras.at(0), {24, 24}, few()}, core::Start::anew);
    renderer->advance({.samples = 1}, {});
    const double slices = number(*renderer, "slices"), points = number(*renderer, "receivers");
    EXPECT_GT(slices, 1);
    EXPECT_GT(points, 300);
    fails = true;
    EXPECT_THROW(renderer->advance({.samples = 1}, {}), core::Error);
    EXPECT_EQ(number(*renderer, "slices"), slices);
    EXPECT_EQ(number(*renderer, "receivers"), points);
}

}  // namespace
