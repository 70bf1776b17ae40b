// M11, M12. Rendering with many lights against the plain sum over all lights, ray by ray, and
// against the path tracer; what its biased options cost; what a stop leaves.
#include <gtest/gtest.h>

#include "core/many_lights/light_paths.h"
#include "core/methods/method.h"
#include "core/trace/scene_view.h"
#include "shared/path.h"
#include "tests/support/methods/completion_runs.h"
#include "tests/support/methods/light_frames.h"
#include "tests/support/methods/many_lights_means.h"
#include "tests/support/methods/stats_number.h"
#include "tests/support/scenes/asset.h"
#include "tests/support/scenes/test_scenes.h"
#include "tests/support/statistics/stats.h"

namespace core::many_lights {
namespace {

using namespace tests;
using glm::vec3;

/// What receiver `r` gets from all lights, one ray each, by the surface model's own functions.
vec3 plainSum(const core::Accel& accel, const LightSet& set, const Receiver& r, float clamp)
{
    const shared::SceneView scene = core::sceneView(accel.world());
    shared::SurfacePoint s =
        shared::makeSurfacePoint(scene, {0, r.barycentrics, r.slot}, r.direction);
    const shared::Bsdf bsdf =
        shared::makeBsdf(shared::evaluateMaterial(scene, s, r.direction).inputs);
    const vec3 wo = shared::toLocal(s.frame, -r.direction);
    glm::dvec3 sum(0);
    for (const VirtualLight& l : set.lights) {
        const vec3 d = l.position - s.position;
        const float distance = glm::length(d);
        if (!(distance > 0)) continue;
        const vec3 wi = d / distance, local = shared::toLocal(s.frame, wi);
        float side;
        if (!shared::sideOf(s, wi, local.z, side)) continue;
        vec3 I = l.intensity * std::max(0.0f, -glm::dot(l.normal, wi));
        if (l.detail != shared::kNone) I *= set.surfaces[l.detail].scattered(-wi);
        const vec3 f = shared::evalBsdf(bsdf, wo, local) * std::abs(local.z) * I /
                       std::max(distance * distance, clamp * clamp);
        if (f == vec3(0)) continue;
        const vec3 origin = shared::originOnSide(s, side);
        if (!accel.occluded({origin, shared::connectionEnd(distance), l.position - origin, 0}))
            sum += f;
    }
    return r.throughput * vec3(sum);
}

/// With a cluster for every light a frame is the sum over all lights, bit of rounding apart.
TEST(ManyLights, AsManyClustersAsLightsAreThePlainSum)
{
    for (const char* name : {"cornell-diffuse", "cornell-glossy"}) {
        const auto world = asset(name);
        const core::Accel accel(world);
        FrameSettings s = frameSettings(*world, 24);
        s.lights = 1000;
        s.clusters = 1000000;
        s.sliceSize = 100;
        s.clamp = 0.2f;
        const LightPlan plan = planLights(accel, s);
        ASSERT_GT(plan.clampDistance, 0);
        const auto lights = makeFrameLights(accel, s, plan, 0, {});
        ASSERT_GT(lights->set.lights.size(), 500u);
        const core::Image image = frameImage(accel, s, plan, lights, s.path.seed);

        std::vector<Receiver> receivers;
        std::vector<vec3> direct(24 * 24);
        const ReceiverJob job{&accel, s.path, s.camera, 1, 0};
        traceReceivers(job, {0, 0, 24, 24}, receivers, direct);
        EXPECT_GT(receivers.size(), 300u);
        double error = 0, total = 0;
        size_t wrong = 0;
        for (const Receiver& r : receivers) {
            const vec3 expected =
                direct[r.place] + plainSum(accel, lights->set, r, plan.clampDistance);
            double largest = 0;
            for (int c = 0; c < 3; ++c) {
                const double found = double(image.pixels[3 * r.place + uint32_t(c)]);
                largest = std::max(largest, std::abs(found - double(expected[c])) /
                                                (1e-3 + double(expected[c])));
                error += std::abs(found - double(expected[c]));
                total += double(expected[c]);
            }
            // Packets and single rays may differ by the last bit at an edge: one light of a
            // thousand.
            wrong += largest > 1e-4 ? 1 : 0;
        }
        EXPECT_LE(wrong, 2u) << name;
        EXPECT_LT(error / total, 1e-4) << name;
    }
}

/// More points than the machine holds, or than places have numbers.
TEST(ManyLights, SaysWhatItsPointsNeedBeforeItTakesIt)
{
    const auto world = asset("cornell-diffuse");
    const core::Accel accel(world);
    FrameSettings s = frameSettings(*world, 65536);
    s.side = 8;
    try {
        makeFrameReceivers(accel, s, 0, {});
        ADD_FAILURE() << "began a sample of 274 billion points";
    } catch (const core::Error& error) {
        EXPECT_EQ(error.code(), core::ExitCode::commandLine);
        const std::string text = error.what();
        EXPECT_NE(text.find("65536x65536 with 64 points per pixel"), std::string::npos) << text;
        EXPECT_NE(text.find("--receivers"), std::string::npos) << text;
    }
}

/// Of the path tracer, rendered once per asset and depth.
const Quarters& paths(std::string_view scene, uint32_t maxDepth)
{
    static std::map<std::pair<std::string, uint32_t>, Quarters> known;
    const std::string name(scene);
    Quarters& q = known[{name, maxDepth}];
    if (q.means[0].count() > 0) return q;
    return q = pathsOf(asset(name), maxDepth, 128);
}

/// The mean is the path tracer's at equal depth: with the light that the clamp takes found by
/// paths.
TEST(ManyLights, AgreesWithThePathTracer)
{
    for (const char* name : {"cornell-diffuse", "cornell-rough", "textured-box"}) {
        const auto world = asset(name);
        expectAgree(manyLights(world, fewClusters(), 16, 8), paths(name, 8), 0.08, name);
    }
}

/// Lights without extent, an environment and a sun.
TEST(ManyLights, AgreesWithThePathTracerOnOtherLights)
{
    for (const char* name : {"lights", "sky"}) {
        const auto world = asset(name);
        expectAgree(manyLights(world, fewClusters(), 16, 8), paths(name, 8), 0.08, name);
    }
}

/// Mirrors, clear and rough glass. What comes by way of them is a fifth of the light on the ground.
TEST(ManyLights, AgreesWithThePathTracerOnGlass)
{
    auto scene =
        std::make_shared<core::Scene>(*core::loadGltf(REKINDLE_SOURCE_DIR "/assets/glass.gltf"));
    // As rough as the scene has it (.3) the ball brings an eighth of its light in a thousandth of
    // the frames (docs/many-lights.md): means of few frames lack up to half of it, at z -11 by
    // their own standard errors, or have one of those frames and tell nothing.
    for (core::Material& m : scene->materials)
        if (m.name == "rough glass") m.data.roughness = 0.8f;
    const auto world = core::makeWorld(scene);
    const Quarters expected = pathsOf(world, 8, 128);
    ManyLightsParams params = fewClusters();
    // Few frames see caustics at their brightest: the means of 16 seeds miss them, by any estimate
    // of their own error.
    expectAgree(manyLights(world, params, 24, 16), expected, 0.1, "glass", true);
    params.lost = LostLight::dropped;
    const Quarters dropped = manyLights(world, params, 16, 16);
    EXPECT_LT(welch(dropped.means[3], expected.means[3]).z, -kScore)
        << "light that comes by way of mirrors is not missed";
}

/// An octahedron with the normals of a ball, in the light of a spot, of which the walls beside it
/// get nothing else. Paths see its rims from behind the horizons of their shading normals, with the
/// normals bent; lights there, and particles, have to send as much that way.
TEST(ManyLights, AgreesWithThePathTracerOnCoarseSmoothMeshes)
{
    SceneBuilder b;
    b.box(vec3(-1), vec3(1), b.material(lambert(vec3(0.5f))), true);
    b.sphere(vec3(0), 0.4f, 0, b.material(glossy(vec3(0.95f), 1, 0.7f)), false, true);
    core::PunctualLight spot;
    spot.kind = shared::kEmitterSpot;
    spot.intensity = 30;
    spot.outerCone = 0.42f;
    b.light(spot, glm::translate(glm::dmat4(1), glm::dvec3(0, 0, 0.95)));
    b.camera({0.9, 0.9, 0.6}, {-0.4, -0.3, -1}, 0.9);
    const auto world = b.world();
    ManyLightsParams params = fewClusters();
    params.lights = params.clusters = 1000;
    params.maxDepth = 4;
    expectAgree(manyLights(world, params, 16, 4), pathsOf(world, 4, 256), 0.1, "octahedron");
}

TEST(ManyLights, AgreesWithThePathTracerWithoutAClamp)
{
    const auto world = asset("cornell-diffuse");
    ManyLightsParams params = fewClusters();
    params.clamp = 0;
    expectAgree(manyLights(world, params, 16, 8), paths("cornell-diffuse", 8), 0.1,
                "cornell-diffuse");
}

/// What is cut off by depth is cut off exactly.
TEST(ManyLights, AgreesWithThePathTracerAtEveryDepth)
{
    const auto world = asset("cornell-diffuse");
    for (const uint32_t depth : {1u, 2u, 3u}) {
        ManyLightsParams params = fewClusters();
        params.maxDepth = depth;
        expectAgree(manyLights(world, params, 16, 8), paths("cornell-diffuse", depth), 0.06,
                    "cornell-diffuse");
    }
}

/// The clamp only ever takes light, and takes much of it when it is the thesis's.
TEST(ManyLights, DroppedLightIsMissing)
{
    const auto world = asset("cornell-diffuse");
    const auto renderer = core::makeRenderer("manylights");
    renderer->setWorld(world, {});
    const auto pictureOf = [&](LostLight lost) {
        ManyLightsParams params = fewClusters();
        params.clamp = 1;
        params.lost = lost;
        renderer->setView({world->cameras.at(0), {32, 32}, params}, core::Start::anew);
        renderer->advance({.samples = 8}, {});
        return renderer->read(core::Reading::mean).mean;
    };
    // The same lights in both: they differ by what the clamp takes alone.
    const core::Image dropped = pictureOf(LostLight::dropped), found = pictureOf(LostLight::paths);
    double kept = 0, all = 0;
    for (size_t i = 0; i < found.pixels.size(); ++i) {
        EXPECT_LE(dropped.pixels[i], found.pixels[i]);
        kept += double(dropped.pixels[i]);
        all += double(found.pixels[i]);
    }
    EXPECT_LT(kept, 0.99 * all);
    EXPECT_GT(kept, 0.5 * all);
}

/// More samples, less error: with the root of their number, against the path tracer.
TEST(ManyLights, ErrorFallsWithTheRootOfTheSamples)
{
    const auto world = asset("cornell-diffuse");
    const core::Estimate reference =
        render(world, 24, 24, 4096, independentParams(core::Strategy::mis, 8));
    const auto renderer = core::makeRenderer("manylights");
    renderer->setWorld(world, {});
    std::array<double, 2> errors{};
    for (uint32_t seed = 0; seed < 8; ++seed) {
        ManyLightsParams params = fewClusters();
        params.sampler = core::SamplerKind::independent;
        params.seed = 50 + seed;
        renderer->setView({world->cameras.at(0), {24, 24}, params}, core::Start::anew);
        uint32_t had = 0;
        for (const uint32_t samples : {4u, 64u}) {
            renderer->advance({.samples = samples - had}, {});
            had = samples;
            const core::Image mean = renderer->read(core::Reading::mean).mean;
            double sum = 0;
            for (size_t i = 0; i < mean.pixels.size(); ++i) {
                const double d = double(mean.pixels[i]) - double(reference.mean.pixels[i]);
                sum += d * d;
            }
            errors[samples == 4 ? 0 : 1] += sum;
        }
    }
    const double slope = 0.5 * std::log(errors[1] / errors[0]) / std::log(16.0);
    EXPECT_NEAR(slope, -0.5, 0.12);
}

/// A frame of 100 clusters from 1000 lights, seen from 64 x 64 pixels.
core::Image frameOf(core::Renderer& renderer, const core::World& world, CompletionParams completion,
                    uint32_t seed, uint32_t clusters = 100)
{
    ManyLightsParams params = fewClusters();
    params.lights = 1000;
    params.clusters = clusters;
    params.sliceSize = 400;
    params.seed = seed;
    params.completion = completion;
    renderer.setView({world.cameras.at(0), {64, 64}, params}, core::Start::anew);
    renderer.advance({.samples = 1}, {});
    return renderer.read(core::Reading::mean).mean;
}

double squaredDifference(const core::Image& a, const core::Image& b)
{
    double sum = 0;
    for (size_t i = 0; i < a.pixels.size(); ++i) {
        // As pictures are seen: highlights do not count.
        const double d = std::min(1.0, std::sqrt(double(a.pixels[i]))) -
                         std::min(1.0, std::sqrt(double(b.pixels[i])));
        sum += d * d;
    }
    return sum;
}

TEST(ManyLights, CompletionOfAllRowsIsFullSamplingToTheBit)
{
    const auto world = asset("cornell-glossy");
    const auto renderer = core::makeRenderer("manylights");
    renderer->setWorld(world, {});
    CompletionParams all;
    all.method = CompletionMethod::matching;
    all.rowRate = 1;
    all.rowCap = 1;
    EXPECT_EQ(frameOf(*renderer, *world, all, 1).pixels,
              frameOf(*renderer, *world, fullSampling(), 1).pixels);
}

/// Clusters err much more than what is guessed of their visibility.
TEST(ManyLights, CompletionAddsLittleToTheErrorOfTheClusters)
{
    const auto world = asset("cornell-diffuse");
    const auto renderer = core::makeRenderer("manylights");
    renderer->setWorld(world, {});
    CompletionParams matching;
    matching.method = CompletionMethod::matching;
    double full = 0, completed = 0;
    for (uint32_t seed = 1; seed <= 4; ++seed) {
        const core::Image all = frameOf(*renderer, *world, fullSampling(), seed, 100000);
        full += squaredDifference(frameOf(*renderer, *world, fullSampling(), seed), all);
        completed += squaredDifference(frameOf(*renderer, *world, matching, seed), all);
    }
    const double ratio = std::sqrt(completed / full);
    EXPECT_GT(ratio, 0.9);
    EXPECT_LT(ratio, 1.2);
    EXPECT_LT(number(*renderer, "visibility_percent"), 60);
}

/// Both have the same lights and clusters: over seeds, the mean of their difference is zero.
TEST(ManyLights, ResidualsTakeTheBiasOutOfCompletion)
{
    const auto world = asset("cornell-diffuse");
    const auto renderer = core::makeRenderer("manylights");
    renderer->setWorld(world, {});
    CompletionParams crude;  // guesses badly, so that there is something to take out
    crude.method = CompletionMethod::matching;
    crude.rowMinimum = 4;
    crude.rowRate = 0.005f;
    crude.verificationRate = 0;
    crude.smallSlice = 0;
    crude.adaptiveRows = false;
    CompletionParams mended = crude;
    mended.residualRate = 0.05f;
    Moments difference, brightness;
    double without = 0, with = 0;
    for (uint32_t seed = 1; seed <= 48; ++seed) {
        const core::Image full = frameOf(*renderer, *world, fullSampling(), seed);
        const core::Image guessed = frameOf(*renderer, *world, crude, seed);
        const core::Image corrected = frameOf(*renderer, *world, mended, seed);
        double sum = 0, all = 0;
        for (size_t i = 0; i < full.pixels.size(); ++i) {
            sum += double(corrected.pixels[i]) - double(full.pixels[i]);
            all += double(full.pixels[i]);
        }
        difference.add(sum);
        brightness.add(all);
        without += squaredDifference(guessed, full);
        with += squaredDifference(corrected, full);
    }
    EXPECT_GT(without, 0) << "nothing was guessed wrongly";
    EXPECT_GT(with, 0);
    const double error = std::sqrt(difference.varianceOfMean());
    EXPECT_LT(std::abs(difference.mean()), kScore * error);
    EXPECT_LT((kScore + 2.33) * error, 0.01 * brightness.mean()) << "underpowered";
}

/// Slices appear one after the other, whole pixels only, and a stop gives up those under way.
TEST(ManyLights, AStopKeepsTheSlicesThatAreDone)
{
    const auto world = asset("cornell-diffuse");
    const auto renderer = core::makeRenderer("manylights");
    renderer->setWorld(world, {});
    ManyLightsParams params = fewClusters();
    params.receivers = 4;
    renderer->setView({world->cameras.at(0), {64, 64}, params}, core::Start::anew);
    renderer->advance({.samples = 1, .seconds = 0}, {});
    EXPECT_EQ(renderer->progress().samples, 0u);
    EXPECT_GT(renderer->progress().fraction, 0);
    const core::Estimate part = renderer->read(core::Reading::everything);
    std::stop_source stop;
    stop.request_stop();
    const uint64_t version = renderer->progress().version;
    renderer->advance({.samples = 1}, stop.get_token());
    EXPECT_EQ(renderer->progress().version, version);
    renderer->advance({.samples = 1}, {});
    const core::Estimate whole = renderer->read(core::Reading::everything);
    EXPECT_EQ(whole.samples, 1u);
    size_t there = 0;
    for (size_t i = 0; i < part.weight.pixels.size(); ++i) {
        if (part.weight.pixels[i] == 0) continue;
        ++there;
        for (size_t c = 0; c < 3; ++c)
            ASSERT_EQ(part.mean.pixels[3 * i + c], whole.mean.pixels[3 * i + c]);
    }
    EXPECT_GT(there, 0u);
    EXPECT_LT(there, part.weight.pixels.size());
}

}  // namespace
}  // namespace core::many_lights
