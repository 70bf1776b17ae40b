// M8. Virtual lights against closed forms: the energy that they hold, what they give inside a
// sphere (where every two points exchange the same), and what the clamp takes from it.
#include "core/many_lights/light_paths.h"

#include <gtest/gtest.h>

#include <glm/gtc/packing.hpp>

#include "core/base/machine_memory.h"
#include "core/many_lights/slice_rows.h"
#include "core/methods/method.h"
#include "core/trace/scene_view.h"
#include "tests/support/methods/light_frames.h"
#include "tests/support/methods/stats_number.h"
#include "tests/support/scenes/test_scenes.h"
#include "tests/support/statistics/stats.h"

namespace core::many_lights {
namespace {

using namespace tests;
using glm::vec3;

shared::PathSettings settingsOf(const core::World& world, uint32_t maxDepth, uint32_t seed)
{
    shared::PathSettings s = core::worldSettings(world);
    s.maxDepth = maxDepth;
    s.rouletteDepth = 2;
    s.seed = seed;
    s.samplerKind = shared::kSamplerIndependent;
    s.imageWidth = s.imageHeight = 16;
    return s;
}

/// A closed box of albedo `a` that emits 1 everywhere, and its area.
std::shared_ptr<const core::World> boxFurnace(float a, double& area)
{
    SceneBuilder b;
    b.box({-1, -1, -1}, {1, 1, 1}, b.material(emitter(vec3(1), vec3(a))), true);
    b.camera({0.1, 0.2, 0.3}, {1, 0.4, -0.5}, 1.2);
    const auto world = b.world();
    area = 24 * world->placement.scale * world->placement.scale;
    return world;
}

/// Power of all lights, over many sets of them.
Moments powers(const core::Accel& accel, uint32_t maxDepth, uint32_t paths, uint32_t sets)
{
    Moments power;
    const shared::PathSettings settings = settingsOf(accel.world(), maxDepth, 3);
    for (uint32_t frame = 0; frame < sets; ++frame) {
        double sum = 0;
        const LightSet set = *traceVirtualLights(accel, settings, frame, paths);
        for (const VirtualLight& l : set.lights)
            sum += double(shared::kPi) * double(shared::luminance(l.intensity));
        power.add(sum);
    }
    return power;
}

void expectMean(const Moments& m, double exact, double detects)
{
    const double error = std::sqrt(m.varianceOfMean());
    EXPECT_LT(std::abs(m.mean() - exact), kScore * error + 1e-5 * exact)
        << m.mean() << " instead of " << exact;
    EXPECT_LT((kScore + 2.33) * error, detects * exact) << "underpowered";
}

/// Light that is emitted and scattered without end is Phi / (1 - a). Roulette that does not divide
/// by its probability would give Phi (1 + a / (1 - a^2)): 1.67 instead of 2.
TEST(VirtualLights, HoldTheEnergyOfAClosedBox)
{
    for (const float a : {0.5f, 0.8f}) {
        double area;
        const core::Accel accel(boxFurnace(a, area));
        expectMean(powers(accel, 4096, 256, 400), double(shared::kPi) * area / (1 - double(a)),
                   0.02);
    }
}

/// Up to k surface lights of a path: Phi (1 - a^(k+1)) / (1 - a).
TEST(VirtualLights, EndWithTheDepthOfThePaths)
{
    double area;
    const core::Accel accel(boxFurnace(0.8f, area));
    for (const uint32_t k : {0u, 1u, 3u}) {
        const double exact = double(shared::kPi) * area * (1 - std::pow(0.8, k + 1)) / (1 - 0.8);
        expectMean(powers(accel, k + 1, 256, 400), exact, 0.02);
    }
    EXPECT_TRUE(traceVirtualLights(accel, settingsOf(accel.world(), 0, 1), 0, 64)->lights.empty());
}

TEST(VirtualLights, DoNotDependOnThreadsAndDifferBetweenFrames)
{
    double area;
    const core::Accel accel(boxFurnace(0.5f, area));
    const shared::PathSettings settings = settingsOf(accel.world(), 8, 5);
    const LightSet all = *traceVirtualLights(accel, settings, 0, 5000);
    const core::ThreadLimit one(1);
    const LightSet again = *traceVirtualLights(accel, settings, 0, 5000);
    ASSERT_EQ(all.lights.size(), again.lights.size());
    for (size_t i = 0; i < all.lights.size(); ++i) {
        ASSERT_EQ(all.lights[i].position, again.lights[i].position);
        ASSERT_EQ(all.lights[i].intensity, again.lights[i].intensity);
    }
    const LightSet other = *traceVirtualLights(accel, settings, 1, 5000);
    EXPECT_NE(all.lights[0].position, other.lights[0].position);
    std::stop_source stop;
    stop.request_stop();
    EXPECT_FALSE(traceVirtualLights(accel, settings, 0, 5000, stop.get_token()));
}

TEST(VirtualLights, ThereAreAboutAsManyAsAskedFor)
{
    double area;
    const core::Accel accel(boxFurnace(0.8f, area));
    const shared::PathSettings settings = settingsOf(accel.world(), 4096, 5);
    const LightSet pilot = *traceVirtualLights(accel, settings, kPilotFrame, 2048);
    const uint32_t paths = pathsForLights(pilot, 20000);
    const double found = double(traceVirtualLights(accel, settings, 0, paths)->lights.size());
    // The length of a path is geometric: its relative deviation is below one.
    EXPECT_NEAR(found / 20000, 1, kScore * std::sqrt(1.0 / 2048 + 1.0 / paths));
    EXPECT_EQ(pathsForLights({}, 1000), 0u);
    // Paths that have placed none may yet: no more of them than there ever are.
    LightSet none;
    none.paths = 1024;
    EXPECT_EQ(pathsForLights(none, 1000), 64'000u);
}

/// A lamp of one square unit that shines at one of 64x64 texels alone.
std::shared_ptr<const core::World> texelLamp(double& power)
{
    SceneBuilder b;
    core::Texture map;
    map.width = map.height = 64;
    const auto one = glm::packHalf1x16(1);
    map.texels.assign(64 * 64, {0, 0, 0, one});
    map.texels[20 * 64 + 30] = {one, one, one, one};
    b.scene.textures.push_back(map);
    core::TextureUse use;
    use.texture = 0;
    use.record.row0 = vec3(1, 0, 0);
    use.record.row1 = vec3(0, 1, 0);
    b.scene.textureUses.push_back(use);
    core::Material lamp = emitter(vec3(1));
    lamp.textures[shared::kTextureEmissive] = 0;
    const int index = b.mesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}},
                             b.material(lamp));
    core::Mesh& mesh = b.scene.meshes[static_cast<size_t>(index)];
    mesh.hasNormals = mesh.hasTexCoords = true;
    for (const vec3& p : mesh.positions)
        mesh.attributes.push_back(
            {shared::packOct(vec3(0, 0, 1)), p.x, p.y, shared::packTangent(vec3(1, 0, 0), 1)});
    b.camera({0.5, 0.5, 1}, {0.5, 0.5, 0}, 1);
    const auto world = b.world();
    const double scale = world->placement.scale;
    power = double(shared::kPi) * scale * scale / (64 * 64);
    return world;
}

/// Some pilots place no light: in the mean frames have all of it nevertheless.
TEST(VirtualLights, AreThereWhereTheFirstPathsFindNone)
{
    double exact;
    const core::Accel accel(texelLamp(exact));
    FrameSettings settings = frameSettings(accel.world(), 8);
    settings.path.maxDepth = 1;
    settings.path.samplerKind = shared::kSamplerIndependent;
    settings.lights = 50;
    settings.clamp = 0;
    Moments power;
    uint32_t none = 0;
    for (uint32_t seed = 0; seed < 400; ++seed) {
        settings.path.seed = seed;
        if (traceVirtualLights(accel, settings.path, kPilotFrame, 1024)->lights.empty()) ++none;
        double sum = 0;
        const LightPlan plan = planLights(accel, settings);
        const auto frame = makeFrameLights(accel, settings, plan, 0, {});
        for (const VirtualLight& l : frame->set.lights)
            sum += double(shared::kPi) * double(shared::luminance(l.intensity));
        power.add(sum);
    }
    EXPECT_GT(none, 40u);
    expectMean(power, exact, 0.2);
}

/// Lights that are not numbers are left out, and counted.
TEST(VirtualLights, CountsThoseThatAreNotNumbers)
{
    for (const bool punctual : {false, true}) {
        SceneBuilder b;
        b.box({-1, -1, -1}, {1, 1, 1}, b.material(lambert(vec3(0))), true);
        b.quad({-0.3f, 0.9f, -0.3f}, {0.6f, 0, 0}, {0, 0, 0.6f},
               b.material(emitter(vec3(punctual ? 1.0f : 1e33f))));
        core::PunctualLight light;
        light.intensity = punctual ? 1e31f : 1.0f;
        b.light(light, glm::dmat4(1));
        b.camera({0, 0, 0.9}, {0, 0, 0}, 1);
        const auto world = b.world();
        const core::Accel accel(world);
        const LightSet set = *traceVirtualLights(accel, settingsOf(*world, 1, 1), 0, 64);
        EXPECT_GT(set.dropped, 0u) << punctual;
        for (const VirtualLight& l : set.lights) EXPECT_LT(l.importance, 1e30f);
        const auto renderer = core::makeRenderer("manylights");
        renderer->setWorld(world, {});
        core::ManyLightsParams params;
        params.lights = 64;
        params.maxDepth = 1;
        renderer->setView({world->cameras.at(0), {4, 4}, params}, core::Start::anew);
        renderer->advance({.samples = 1}, {});
        const double first = number(*renderer, "lights_dropped");
        EXPECT_GT(first, 0) << punctual;
        renderer->advance({.samples = 1}, {});
        EXPECT_GT(number(*renderer, "lights_dropped"), first) << punctual;
    }
}

/// What lights, the rows of row-column sampling and slices need is asked of the machine before it
/// is taken.
TEST(VirtualLights, SayWhatTheyNeedBeforeItIsTaken)
{
    double area;
    const core::Accel accel(boxFurnace(0.5f, area));
    FrameSettings settings = frameSettings(accel.world(), 32);
    settings.lights = 2000;
    const auto frame = [&](std::string_view what, std::string_view remedy) {
        try {
            const LightPlan plan = planLights(accel, settings);
            const auto lights = makeFrameLights(accel, settings, plan, 0, {});
            Frame::begin(accel, settings, plan, lights, makeFrameReceivers(accel, settings, 0, {}),
                         0, {}, [](size_t, const vec3&) {});
            EXPECT_EQ(what, "");
        } catch (const core::Error& error) {
            EXPECT_EQ(error.code(), core::ExitCode::commandLine);
            const std::string text = error.what();
            EXPECT_NE(what, "") << text;
            EXPECT_NE(text.find(what), std::string::npos) << text;
            EXPECT_NE(text.find(remedy), std::string::npos) << text;
        }
    };
    const core::ThreadLimit one(1);
    {
        const core::MemoryLimit little(300e3);
        frame("2000 lights", "--lights");
    }
    const core::MemoryLimit some(2e6);
    settings.clusters = 1000;
    frame("", "");
    settings.technique = Technique::rowColumn;
    frame("row-column of ", "--lights");
    settings.technique = Technique::matSep;
    frame("matsep of slices of ", "--slice-size");
    settings.technique = Technique::clusters;
    for (const CompletionMethod method : {CompletionMethod::svt, CompletionMethod::amc}) {
        settings.completion.method = method;
        frame(std::string(core::enumName(method)) + " of slices of ", "--clusters");
    }
    settings.clusters = 10;
    frame("", "");
}

/// Lights without extent are lights by themselves; a path from one places none where light may
/// scatter once only.
TEST(VirtualLights, NoPathIsTracedThatCanPlaceNone)
{
    const auto plan = [](bool lamp, uint32_t maxDepth) {
        SceneBuilder b;
        b.box({-1, -1, -1}, {1, 1, 1}, b.material(lambert(vec3(0.5f))), true);
        core::PunctualLight light;
        light.kind = shared::kEmitterPoint;
        light.color = vec3(1);
        b.light(light, glm::dmat4(1));
        if (lamp)
            b.quad({-0.3f, 0.9f, -0.3f}, {0.6f, 0, 0}, {0, 0, 0.6f}, b.material(emitter(vec3(1))));
        b.camera({0, 0, 0.9}, {0, 0, 0}, 1);
        const core::Accel accel(b.world());
        FrameSettings settings = frameSettings(accel.world(), 8);
        settings.lights = 1000;
        settings.path.maxDepth = maxDepth;
        const LightPlan found = planLights(accel, settings);
        EXPECT_GT(makeFrameLights(accel, settings, found, 0, {})->set.lights.size(), 0u);
        return found;
    };
    EXPECT_EQ(plan(false, 1).paths, 0u);
    EXPECT_GT(plan(false, 2).paths, 0u);
    EXPECT_GT(plan(true, 1).paths, 0u);
}

/// Rows inside a sphere of radius 1 (in the world's metres `radius`).
struct Sphere {
    std::shared_ptr<const core::World> world;
    std::unique_ptr<core::Accel> accel;
    std::vector<Receiver> receivers;
    std::vector<uint32_t> chosen;
    SliceRows rows;
    float radius;

    explicit Sphere(float albedo)
    {
        SceneBuilder b;
        b.sphere({0, 0, 0}, 1, 6, b.material(emitter(vec3(1), vec3(albedo))), true);
        b.camera({0.1, 0.2, 0.3}, {1, 0.4, -0.5}, 2.0);
        world = b.world();
        radius = float(world->placement.scale);
        accel = std::make_unique<core::Accel>(world);
        ReceiverJob job;
        job.accel = accel.get();
        job.settings = settingsOf(*world, 4096, 1);
        job.camera = core::cameraData(world->cameras[0], 16, 16);
        std::vector<vec3> direct(256);
        traceReceivers(job, {0, 0, 16, 16}, receivers, direct);
        for (uint32_t i = 0; i < receivers.size(); ++i) chosen.push_back(i);
        rows.reset(core::sceneView(*world), receivers, chosen);
    }
};

/// G = 1 / (4 R^2) between any two points: all rows get the same from every light, and all of it
/// makes E / (1 - a).
TEST(VirtualLights, GiveTheSameEverywhereInsideASphere)
{
    for (const float a : {0.5f, 0.8f}) {
        Sphere sphere(a);
        ASSERT_EQ(sphere.rows.count(), 256u);
        const shared::PathSettings settings = settingsOf(*sphere.world, 4096, 2);
        const double exchanged = 1 / (4 * double(sphere.radius) * double(sphere.radius));
        Moments gathered, weights;
        std::vector<float> w(256);
        for (uint32_t frame = 0; frame < 100; ++frame) {
            const LightSet set = *traceVirtualLights(*sphere.accel, settings, frame, 256);
            double sum = 0;
            for (const VirtualLight& light : set.lights) {
                sphere.rows.weigh({&light, 1, 0}, {4096, 0}, w);
                for (const float x : w) weights.add(double(x) / exchanged);
                sum += double(SliceRows::brightness({&light, 1, 0}, w)) / 256;
            }
            gathered.add(1 + double(a) / double(shared::kPi) * sum);
        }
        // Facets of 1.4 degrees: neighbours on one facet see nothing of each other.
        EXPECT_NEAR(weights.mean(), 1, 2e-3);
        EXPECT_LT(std::sqrt(weights.variance()), 0.05);
        const double exact = 1 / (1 - double(a));
        const double error = std::sqrt(gathered.varianceOfMean());
        EXPECT_LT(std::abs(gathered.mean() - exact), kScore * error + 2e-3 * exact);
        EXPECT_LT((kScore + 2.33) * error, 0.04 * exact) << "underpowered";
    }
}

/// Of what lights bring inside a sphere the clamp leaves 1 - b^2 / (8 R^2), with a deviation from
/// light to light that is known as well.
TEST(VirtualLights, AreDarkerInsideASphereByTheClamp)
{
    Sphere sphere(0.5f);
    const LightSet set =
        *traceVirtualLights(*sphere.accel, settingsOf(*sphere.world, 1, 2), 0, 4000);
    for (const auto& [b, kept, deviation] :
         {std::tuple(0.1, 0.99875, 0.029), std::tuple(0.3, 0.98875, 0.086),
          std::tuple(0.6, 0.95500, 0.167)}) {
        Moments clamped;
        double open = 0, all = 0;
        std::vector<float> w(256), u(256);
        for (const VirtualLight& light : set.lights) {
            sphere.rows.weigh({&light, 1, 0}, {4096, float(b) * sphere.radius}, w);
            sphere.rows.weigh({&light, 1, 0}, {4096, 0}, u);
            for (size_t i = 0; i < 256; ++i) {
                all += double(u[i]);
                open += double(w[i]);
                clamped.add(double(w[i]) * 4 * double(sphere.radius) * double(sphere.radius));
            }
        }
        // 256 rows share each light: the mean over 4000 lights deviates by the deviation / 63.
        EXPECT_NEAR(open / all, kept, 4.21 * deviation / std::sqrt(4000.0) * 0.5 + 3e-4) << b;
        EXPECT_NEAR(std::sqrt(clamped.variance()), deviation, 0.1 * deviation + 0.015) << b;
    }
}

/// A point light is one light, whatever the number of paths, and gives I cos / d^2; a directional
/// one gives E cos at any distance. Only with light that has not been scattered.
TEST(VirtualLights, PunctualLightsAreExact)
{
    for (const bool distant : {false, true}) {
        SceneBuilder b;
        b.quad({-50, 0, 50}, {100, 0, 0}, {0, 0, -100}, b.material(lambert(vec3(0.5f))));
        core::PunctualLight light;
        light.kind = distant ? shared::kEmitterDirectional : shared::kEmitterPoint;
        light.color = vec3(1, 2, 3);
        glm::dmat4 m(1);
        if (distant)  // lights shine along -Z: turned down
            m = glm::dmat4(glm::dvec4(1, 0, 0, 0), glm::dvec4(0, 0, -1, 0), glm::dvec4(0, 1, 0, 0),
                           glm::dvec4(0, 0, 0, 1));
        else
            m[3] = {0, 2, 0, 1};
        b.light(light, m);
        b.camera({0.2, 3, 0.3}, {1, 0, 0}, 0.002);
        const auto world = b.world();
        core::ManyLightsParams params;
        params.maxDepth = 1;
        const core::Estimate e = render(world, 1, 1, 1, params);
        const double d2 = 1 + 4;
        const double cosine = 2 / std::sqrt(d2);
        const double expected = 0.5 / double(shared::kPi) * (distant ? 1.0 : cosine / d2);
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(double(e.mean.pixels[size_t(c)]), expected * (c + 1), 1e-4 * expected)
                << distant;
    }
}

}  // namespace
}  // namespace core::many_lights
