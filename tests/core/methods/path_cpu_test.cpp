// The CPU path tracer as a program: the same bits whatever the threads, steps and interruptions
// (T23, T24), an error that falls as it must (T20), first-hit data, scale and distance (N1, N2),
// grazing views (N4).
#include <cmath>
#include <numbers>
#include <thread>

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/methods/method.h"
#include "tests/support/scenes/test_scenes.h"
#include "tests/support/statistics/stats.h"

namespace {

using namespace tests;

std::shared_ptr<const core::World> testRoom()
{
    return room(lambert(glm::vec3(0.7f)), glossy(glm::vec3(0.8f), 0.3f, 0.3f)).world();
}

std::unique_ptr<core::Renderer> rendererFor(const std::shared_ptr<const core::World>& world,
                                            uint32_t width, uint32_t height,
                                            const core::PathParams& params)
{
    auto renderer = core::makeRenderer("path");
    renderer->setWorld(world, {});
    renderer->setView({world->cameras[0], {width, height}, params}, core::Start::anew);
    return renderer;
}

core::Estimate readFilm(core::Renderer& renderer)
{
    return renderer.read(core::Reading::everything);
}

void expectSameMoments(const core::Estimate& a, const core::Estimate& b)
{
    EXPECT_EQ(a.samples, b.samples);
    EXPECT_TRUE(a.mean.pixels == b.mean.pixels);
    EXPECT_TRUE(a.variance.pixels == b.variance.pixels);
}

TEST(PathCpu, SameBitsForAnyStepsAndThreads)
{
    const auto world = testRoom();
    for (const core::SamplerKind sampler :
         {core::SamplerKind::sobol, core::SamplerKind::independent}) {
        core::PathParams params;
        params.sampler = sampler;
        const auto whole = rendererFor(world, 53, 37, params);
        whole->advance({.samples = 12}, {});
        const core::Estimate expected = readFilm(*whole);

        const auto again = rendererFor(world, 53, 37, params);
        again->advance({.samples = 12}, {});
        expectSameMoments(expected, readFilm(*again));

        const auto steps = rendererFor(world, 53, 37, params);
        for (const uint32_t count : {1u, 4u, 0u, 7u}) steps->advance({.samples = count}, {});
        expectSameMoments(expected, readFilm(*steps));

        // Away to another size and back.
        steps->setView({world->cameras[0], {20, 10}, params}, core::Start::anew);
        steps->advance({.samples = 3}, {});
        steps->setView({world->cameras[0], {53, 37}, params}, core::Start::anew);
        EXPECT_EQ(steps->progress().samples, 0u);
        steps->advance({.samples = 12}, {});
        expectSameMoments(expected, readFilm(*steps));

        const core::ThreadLimit limit(1);
        const auto alone = rendererFor(world, 53, 37, params);
        alone->advance({.samples = 12}, {});
        expectSameMoments(expected, readFilm(*alone));
    }
}

TEST(PathCpu, SeedsAndParametersMatter)
{
    const auto world = testRoom();
    core::PathParams params;
    const auto renderer = rendererFor(world, 16, 16, params);
    renderer->advance({.samples = 2}, {});
    const core::Estimate first = readFilm(*renderer);
    params.seed = 2;
    renderer->setView({world->cameras[0], {16, 16}, params}, core::Start::anew);
    renderer->advance({.samples = 2}, {});
    EXPECT_FALSE(first.mean.pixels == readFilm(*renderer).mean.pixels);
}

/// A stop in the middle leaves whole tiles, and what follows goes on from there: no bit changes.
TEST(PathCpu, StopLeavesWholeTiles)
{
    const auto world = testRoom();
    const core::PathParams params;
    const auto renderer = rendererFor(world, 128, 128, params);
    renderer->advance({.samples = 1}, {});
    std::stop_source source;
    std::jthread stopper([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(60));
        source.request_stop();
    });
    renderer->advance({.samples = 1'000'000}, source.get_token());
    const core::Estimate stopped = readFilm(*renderer);
    const core::RenderProgress where = renderer->progress();
    ASSERT_GE(stopped.samples, 1u);
    ASSERT_LT(stopped.samples, 1'000'000u);
    EXPECT_EQ(stopped.samples, where.samples);
    size_t ahead = 0;
    for (const float weight : stopped.weight.pixels) {
        EXPECT_GE(weight, static_cast<float>(stopped.samples));
        ahead += weight > static_cast<float>(stopped.samples) ? 1u : 0u;
    }
    EXPECT_DOUBLE_EQ(where.fraction, double(ahead) / (128 * 128));
    renderer->advance({.samples = 5}, source.get_token());  // stopped before it begins
    EXPECT_EQ(renderer->progress().version, where.version);

    renderer->advance({.samples = 0}, {});  // completes the step that was cut
    EXPECT_EQ(renderer->progress().fraction, 0);
    const auto other = rendererFor(world, 128, 128, params);
    other->advance({.samples = static_cast<uint32_t>(renderer->progress().samples)}, {});
    expectSameMoments(readFilm(*other), readFilm(*renderer));
    renderer->advance({.samples = 1}, {});
    other->advance({.samples = 1}, {});
    expectSameMoments(readFilm(*other), readFilm(*renderer));
}

/// Time that is over ends a step between two tiles, and one tile at least is done each time.
TEST(PathCpu, TimeThatIsOverLeavesWholeTiles)
{
    const auto world = testRoom();
    const auto renderer = rendererFor(world, 96, 64, {}), other = rendererFor(world, 96, 64, {});
    other->advance({.samples = 3}, {});
    uint64_t version = renderer->progress().version;
    bool partial = false;
    while (renderer->progress().samples < 3) {
        renderer->advance({.samples = 1, .seconds = 0}, {});
        ASSERT_GT(renderer->progress().version, version);
        version = renderer->progress().version;
        partial = partial || renderer->progress().fraction > 0;
    }
    EXPECT_TRUE(partial);
    renderer->advance({.samples = 0}, {});
    expectSameMoments(readFilm(*other), readFilm(*renderer));
}

TEST(PathCpu, MethodsAreFoundByName)
{
    ASSERT_FALSE(core::methods().empty());
    for (const core::MethodInfo& method : core::methods()) {
        EXPECT_EQ(core::findMethod(method.id()), &method);
        if (method.whileMoving != nullptr) {
            EXPECT_EQ(method.whileMoving(method.defaults), method.defaults) << method.id();
        }
        if (method.make == nullptr)
            EXPECT_STRNE(method.whyNot, nullptr) << method.id();
        else
            EXPECT_NE(core::makeRenderer(method.id()), nullptr);
    }
    EXPECT_EQ(core::findMethod("magic"), nullptr);
    EXPECT_THROW(core::makeRenderer("magic"), core::Error);
}

// --- T20

/// Mean squared error against the known answer of a furnace, after 1, 2, 4, ... samples, over
/// replicates.
std::vector<double> errorsByDoubling(core::SamplerKind sampler, int doublings, uint32_t replicates)
{
    SceneBuilder b;
    b.box({-1, -1, -1}, {1, 1, 1}, b.material(emitter(glm::vec3(1), glm::vec3(0.5f))), true);
    b.camera({0.1, 0.2, 0.3}, {1, 0.4, -0.5}, 1.2);
    const auto world = b.world();
    std::vector<double> errors(static_cast<size_t>(doublings) + 1, 0.0);
    const uint32_t size = 16;
    core::PathParams params = independentParams();
    params.sampler = sampler;
    const auto renderer = rendererFor(world, size, size, params);
    for (uint32_t replicate = 0; replicate < replicates; ++replicate) {
        params.seed = 100 + replicate;
        renderer->setView({world->cameras[0], {size, size}, params}, core::Start::anew);
        for (int k = 0; k <= doublings; ++k) {
            renderer->advance({.samples = k == 0 ? 1u : 1u << (k - 1)}, {});
            const core::Estimate film = readFilm(*renderer);
            for (size_t i = 0; i < film.mean.pixels.size(); i += 3) {
                const double error = static_cast<double>(film.mean.pixels[i]) - 2.0;
                errors[static_cast<size_t>(k)] += error * error / (size * size * replicates);
            }
        }
    }
    return errors;
}

TEST(PathCpu, ErrorFallsWithTheRootOfSamples)
{
    const int doublings = 10;
    const std::vector<double> errors =
        errorsByDoubling(core::SamplerKind::independent, doublings, 16);
    double sxy = 0, sxx = 0, mean = 0;
    for (const double e : errors) mean += std::log2(e) / (doublings + 1);
    for (int k = 0; k <= doublings; ++k) {
        const double x = k - 0.5 * doublings;
        sxy += x * (std::log2(errors[static_cast<size_t>(k)]) - mean);
        sxx += x * x;
    }
    EXPECT_GT(sxy / sxx, -1.05);
    EXPECT_LT(sxy / sxx, -0.95);
    for (size_t k = 0; k + 4 <= doublings; ++k) {
        EXPECT_GT(16 * errors[k + 4] / errors[k], 0.85) << k;
        EXPECT_LT(16 * errors[k + 4] / errors[k], 1.18) << k;
    }
}

TEST(PathCpu, SobolConvergesFaster)
{
    const double sobol = errorsByDoubling(core::SamplerKind::sobol, 6, 8).back();
    const double independent = errorsByDoubling(core::SamplerKind::independent, 6, 8).back();
    EXPECT_LT(sobol, 0.8 * independent);
}

// --- AOVs, scale, grazing

TEST(PathCpu, AovsAreThoseOfTheFirstHit)
{
    SceneBuilder b;
    b.quad({-1, -1, 0}, {1, 0, 0}, {0, 2, 0}, b.material(lambert(glm::vec3(0.1f, 0.2f, 0.3f))));
    b.quad({1, -1, -1}, {-0.5f, 0, 0}, {0, 2, 0},
           b.material(emitter(glm::vec3(1), glm::vec3(0.4f))));  // its back
    b.camera({0, 0, 5}, {0, 0, 0}, 2 * std::atan(0.2));
    const auto world = b.world();
    const auto renderer = rendererFor(world, 20, 20, {});
    const core::Aovs aovs = renderer->aovs();
    // Left half: the first sheet, 5 m away along the axis; pixel (5, 10) looks through (-0.45,
    // -0.05) there.
    EXPECT_NEAR(static_cast<double>(*aovs.depth.at(5, 10)),
                std::sqrt(25 + 0.45 * 0.45 + 0.05 * 0.05), 1e-5);
    EXPECT_NEAR(static_cast<double>(aovs.normal.at(5, 10)[2]), 1.0, 1e-6);
    EXPECT_NEAR(static_cast<double>(aovs.albedo.at(5, 10)[1]), 0.2, 1e-6);
    EXPECT_EQ(world->triangles[static_cast<size_t>(aovs.ids.at(5, 10)[0])].material, 0u);
    EXPECT_EQ(aovs.ids.at(5, 10)[1], 0.0f);
    EXPECT_EQ(aovs.ids.at(5, 10)[2], -1.0f);
    // Right: the second sheet, 6 m away, seen from behind: the normal is on the viewer's side.
    EXPECT_NEAR(static_cast<double>(*aovs.depth.at(16, 10)),
                6 * std::sqrt(1 + 0.13 * 0.13 + 0.01 * 0.01), 1e-5);
    EXPECT_NEAR(static_cast<double>(aovs.normal.at(16, 10)[2]), 1.0, 1e-6);
    EXPECT_EQ(aovs.ids.at(16, 10)[1], 1.0f);
    EXPECT_GE(aovs.ids.at(16, 10)[2], 0.0f);
    // Between them nothing.
    EXPECT_EQ(*aovs.depth.at(12, 10), 0.0f);
    EXPECT_EQ(aovs.ids.at(12, 10)[0], -1.0f);
}

/// N1, N2: the room at other scales and far from the origin shows the same image. Scales that are
/// powers of two, and shifts, give the very same bits.
TEST(PathCpu, ScaleAndPlaceDoNotMatter)
{
    const auto moved = [](const glm::dmat4& matrix) {
        SceneBuilder b = room(lambert(glm::vec3(0.7f)), lambert(glm::vec3(0.5f)));
        for (core::Node& node : b.scene.nodes)
            node.local = glm::dmat4x3(matrix * glm::dmat4(std::get<glm::dmat4x3>(node.local)));
        return b.world();
    };
    const core::PathParams params = independentParams(core::Strategy::mis, 5);
    const core::Estimate here = render(moved(glm::dmat4(1)), 32, 32, 384, params);
    for (const glm::dvec3 shift : {glm::dvec3(1e4, 0, 0), glm::dvec3(148376, 1234, -223423)}) {
        const core::Estimate there =
            render(moved(glm::translate(glm::dmat4(1), shift)), 32, 32, 384, params);
        EXPECT_TRUE(here.mean.pixels == there.mean.pixels) << shift.x;
    }
    for (const double scale : {1e-4, 1e-2, 1e2, 1e6}) {
        core::PathParams other = params;
        other.seed = 7;
        const core::Estimate there =
            render(moved(glm::scale(glm::dmat4(1), glm::dvec3(scale))), 32, 32, 384, other);
        const PictureMean a = estimate(here), b = estimate(there);
        EXPECT_LT(std::abs(score(a, b)), kScore) << scale;
        EXPECT_LT(detectable(a, b), 0.03) << "underpowered";
    }
}

/// N4: a floor seen and lit at 89, 89.9 and 89.99 degrees: not one sample is lost, and the answer
/// is the closed one.
TEST(PathCpu, GrazingViewsAreClean)
{
    for (const double degrees : {89.0, 89.9, 89.99}) {
        const double angle = degrees / 180 * std::numbers::pi, height = 5 * std::cos(angle);
        SceneBuilder b;
        b.quad({-8, 0, 8}, {16, 0, 0}, {0, 0, -16}, b.material(lambert(glm::vec3(0.5f))));
        core::PunctualLight light;
        light.kind = shared::kEmitterDirectional;
        light.intensity = 1000;
        const glm::dvec3 towards(std::sin(angle), std::cos(angle), 0);
        b.light(light, glm::inverse(glm::lookAt(towards, glm::dvec3(0), glm::dvec3(0, 0, 1))));
        b.camera({0, height, 5 * std::sin(angle)}, {0, 0, 0}, 1e-5);
        const double exact = 0.5 / std::numbers::pi * 1000 * std::cos(angle);
        const PictureMean e = estimate(render(b.world(), 8, 8, 16, independentParams()));
        EXPECT_NEAR(e.mean / exact, 1.0, 2e-3) << degrees;
    }
}

}  // namespace
