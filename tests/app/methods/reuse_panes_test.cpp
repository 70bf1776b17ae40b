// Light of point and directional lights that comes through panes, and sample reuse on every device:
// at rest it is what path tracing finds, and a move leaves it as bright and as coloured as it is.
#include <array>
#include <functional>

#include <glm/gtc/matrix_transform.hpp>

#include "tests/support/methods/reuse_flights.h"
#include "tests/support/scenes/test_scenes.h"
#include "tests/support/statistics/compare_films.h"
#include "tests/support/statistics/stats.h"

namespace {

using namespace tests;
using glm::vec3;

/// A pane in the window of a room, from the window's front edge on.
struct WindowPane {
    vec3 tint;
    float part;   // of the window that it covers
    float apart;  // from the wall
};

/// What is in the window of the test's rooms.
struct Glazing {
    const char* name;
    std::vector<WindowPane> panes;
};

const std::vector<Glazing>& glazings()
{
    static const std::vector<Glazing> kAll{
        {"clear", {{vec3(1), 1, 0}}},
        {"coloured", {{vec3(0.9f, 0.35f, 0.1f), 0.6f, 0}}},
        {"two", {{vec3(0.4f, 0.8f, 0.9f), 1, 0}, {vec3(0.9f, 0.7f, 0.3f), 0.5f, 0.1f}}},
    };
    return kAll;
}

core::Material glassOf(const vec3& tint)
{
    core::Material glass = lambert(tint);
    glass.data.transmission = glass.data.specular = 1;
    glass.data.roughness = 0;
    glass.data.ior = 1.5f;
    return glass;
}

/// A lamp without extent, and the sun, which shines in that direction.
void addLights(SceneBuilder& b, const glm::dvec3& lamp, float ofSun, const glm::dvec3& direction)
{
    core::PunctualLight light;
    light.intensity = 1.5f;
    b.light(light, glm::translate(glm::dmat4(1), lamp));
    light.kind = shared::kEmitterDirectional;
    light.intensity = ofSun;
    b.light(light, glm::inverse(glm::lookAt(glm::dvec3(0), direction, {0, 1, 0})));
}

/// A room with a window in its left wall, behind which the sun shines and a lamp without extent
/// hangs; within it is a lamp that has one.
std::shared_ptr<const core::World> windowRoom(const Glazing& glazing)
{
    SceneBuilder b;
    const int wall = b.material(lambert(vec3(0.6f)));
    b.quad({-1, -1, 1}, {2, 0, 0}, {0, 0, -2}, wall);
    b.quad({-1, 1, -1}, {2, 0, 0}, {0, 0, 2}, wall);
    b.quad({-1, -1, -1}, {2, 0, 0}, {0, 2, 0}, wall);
    b.quad({1, -1, -1}, {0, 0, 2}, {0, 2, 0}, wall);
    b.quad({-1, -1, 1}, {0, 0, -2}, {0, 0.7f, 0}, wall);
    b.quad({-1, 0.7f, 1}, {0, 0, -2}, {0, 0.3f, 0}, wall);
    b.quad({-1, -0.3f, 1}, {0, 0, -0.4f}, {0, 1, 0}, wall);
    b.quad({-1, -0.3f, -0.6f}, {0, 0, -0.4f}, {0, 1, 0}, wall);
    b.box({0.1f, -1, -0.5f}, {0.6f, -0.3f, 0.1f}, b.material(glossy(vec3(0.5f), 0, 0.4f)), false);
    for (const WindowPane& pane : glazing.panes)
        b.quad({-1 - pane.apart, -0.3f, 0.6f}, {0, 0, -1.2f * pane.part}, {0, 1, 0},
               b.material(glassOf(pane.tint)));
    b.quad({-0.3f, 0.99f, -0.3f}, {0.6f, 0, 0}, {0, 0, 0.6f}, b.material(emitter(vec3(1))));
    addLights(b, {-1.7, 0.5, 0.3}, 3, {0.8, -0.5, -0.2});
    b.camera({0, 0, 3.8}, {0, 0, 0}, 0.68);
    return b.world();
}

double meanOfChannel(const core::Image& image, size_t channel)
{
    double sum = 0;
    for (size_t i = channel; i < image.pixels.size(); i += 3) sum += double(image.pixels[i]);
    return sum / (double(image.width) * image.height);
}

/// Into so many columns and rows a picture is divided.
struct Blocks {
    uint32_t columns, rows;
    uint32_t count() const { return columns * rows; }
};

double meanOfBlock(const core::Image& image, Blocks blocks, uint32_t block)
{
    const uint32_t width = image.width / blocks.columns, height = image.height / blocks.rows;
    const uint32_t x0 = block % blocks.columns * width, y0 = block / blocks.columns * height;
    double sum = 0;
    for (uint32_t y = y0; y < y0 + height; ++y)
        for (uint32_t x = x0; x < x0 + width; ++x)
            for (uint32_t c = 0; c < 3; ++c) sum += double(image.at(x, y)[c]);
    return sum / (3.0 * width * height);
}

/// A floor and a wall under a wide roof of orange and blue glass, which nothing shadows: the blue
/// one covers `part` of what is seen, from the left.
std::shared_ptr<const core::World> greenhouse(float part)
{
    SceneBuilder b;
    const int wall = b.material(lambert(vec3(0.5f)));
    b.quad({-1, -1, 1}, {2, 0, 0}, {0, 0, -2}, wall);
    b.quad({-1, -1, -1}, {2, 0, 0}, {0, 1.8f, 0}, wall);
    const auto roof = [&](const vec3& tint, float y, float right) {
        b.quad({-20, y, -20}, {20 + right, 0, 0}, {0, 0, 40}, b.material(glassOf(tint)));
    };
    roof(vec3(0.95f, 0.5f, 0.3f), 1, 20);
    roof(vec3(0.3f, 0.6f, 0.9f), 1.2f, part < 1 ? 2 * part - 1 : 20);
    addLights(b, {-0.6, 1.7, 0.4}, 2, {0.1, -0.8, -0.3});
    b.camera({0, 0, 3.8}, {0, 0, 0}, 0.68);
    return b.world();
}

class ReusePanes : public ReuseFlights {
protected:
    static ReuseParams shallow(ReuseStrategy strategy, uint32_t seed, float rays = 1)
    {
        ReuseParams params = with(strategy, seed, rays);
        params.maxDepth = 4;
        return params;
    }

    core::Estimate reference(uint32_t samples)
    {
        ReuseParams params = shallow(ReuseStrategy::discard, 991);
        params.cap = 1024;
        look(swung(*world_, 0), params, core::Start::anew, samples);
        return renderer_->read(core::Reading::everything);
    }
};

/// T-39. While a view rests its picture is one of new paths alone: first connections and deeper
/// ones bring what they bring to the path tracer.
TEST_P(ReusePanes, AtRestTheyArePathTracing)
{
    constexpr uint32_t kSamples = 128;
    for (const Glazing& glazing : glazings()) {
        begin(windowRoom(glazing), {32, 32});
        core::Renderer& tracer = sharedRenderer("path", app::DeviceKind::cpu);
        tracer.setWorld(world_, {});
        core::PathParams path;
        path.seed = 6;
        path.maxDepth = 4;
        path.sampler = core::SamplerKind::independent;
        tracer.setView({world_->cameras.at(0), size_, path}, core::Start::anew);
        tracer.advance({.samples = kSamples}, {});
        const core::Estimate expected = tracer.read(core::Reading::everything);
        for (const ReuseStrategy strategy :
             {ReuseStrategy::discard, ReuseStrategy::ra, ReuseStrategy::full}) {
            ReuseParams params = shallow(strategy, 7);
            params.jitter = PixelJitter::always;
            params.cap = 1024;  // or plain paths would go on by and by
            look(world_->cameras.at(0), params, core::Start::anew, kSamples);
            const core::Estimate found = renderer_->read(core::Reading::everything);
            EXPECT_TRUE(found.counters.clean());
            const FilmComparison c = compareFilms(found, expected);
            EXPECT_TRUE(c.agree())
                << glazing.name << ", " << core::enumName(strategy) << ": " << c.describe();
        }
    }
}

/// Connections that are kept stay as dim and as coloured as panes have made them: each channel's
/// mean after a flight is within half a per cent, though nothing is traced again. Where some is, it
/// is known that the light was seen through the panes before.
TEST_P(ReusePanes, AMoveLeavesTheMeanAsItIs)
{
    constexpr uint32_t kFlights = 40, kFrames = 6;
    constexpr double kBound = 0.005;
    struct Case {
        ReuseStrategy strategy;
        float rays = 1;
        core::ReuseBias bias = core::ReuseBias::fast;
    };
    begin(greenhouse(1), {24, 24});
    const core::Image truth = reference(2048).mean;
    for (const Case& one :
         {Case{ReuseStrategy::ra}, Case{ReuseStrategy::ra, 1, core::ReuseBias::bounded},
          Case{ReuseStrategy::ra, 0.5f}, Case{ReuseStrategy::mis}, Case{ReuseStrategy::reweighting},
          Case{ReuseStrategy::rejectionAugmentation}, Case{ReuseStrategy::restirGi},
          Case{ReuseStrategy::full}}) {
        std::array<Moments, 3> means;
        for (uint32_t flight = 0; flight < kFlights; ++flight) {
            ReuseParams params = shallow(one.strategy, 100 + flight, one.rays);
            params.bias = one.bias;
            const core::Estimate e = fly(params, kFrames, 1);
            EXPECT_TRUE(e.counters.clean());
            for (size_t c = 0; c < 3; ++c) means[c].add(meanOfChannel(e.mean, c));
        }
        for (size_t c = 0; c < 3; ++c) {
            const double expected = meanOfChannel(truth, c);
            const double error = std::sqrt(means[c].varianceOfMean());
            EXPECT_LT(std::abs(means[c].mean() - expected), kBound * expected + kScore * error)
                << core::enumName(one.strategy) << ", rays " << one.rays << ", "
                << core::enumName(one.bias) << ", channel " << c << ": " << means[c].mean()
                << " of " << expected << " +- " << error;
            EXPECT_LT(error, 0.01 * expected) << core::enumName(one.strategy) << " underpowered";
        }
    }
}

class ReusePanesAsked : public ReusePanes {
protected:
    /// Compares the mean of so many flights with the truth block by block; `slack`: a relative
    /// error.
    void expectBlocks(Blocks blocks, const std::function<ReuseParams(uint32_t seed)>& params,
                      uint32_t frames, double slack, uint32_t flights)
    {
        const core::Image truth = reference(4096).mean;
        std::vector<Moments> means(blocks.count());
        for (uint32_t flight = 0; flight < flights; ++flight) {
            const core::Image found = fly(params(4000 + flight), frames, 4).mean;
            for (uint32_t k = 0; k < means.size(); ++k) means[k].add(meanOfBlock(found, blocks, k));
        }
        for (uint32_t k = 0; k < means.size(); ++k) {
            const double expected = meanOfBlock(truth, blocks, k);
            const double error = std::sqrt(means[k].varianceOfMean());
            EXPECT_LT(std::abs(means[k].mean() - expected), slack * expected + kScore * error)
                << "block " << k << ": " << means[k].mean() << " of " << expected << " +- "
                << error;
            EXPECT_LT(error, 0.03 * expected) << "block " << k << " underpowered";
        }
    }
};

/// Where old connections are left to new ones nothing is wrong in any part of the picture.
TEST_P(ReusePanesAsked, UnbiasedIsUnbiased)
{
    for (const size_t glazing : {1u, 2u}) {
        begin(windowRoom(glazings()[glazing]), {24, 24});
        SCOPED_TRACE(glazings()[glazing].name);
        expectBlocks(
            {3, 3},
            [](uint32_t seed) {
                ReuseParams params = shallow(ReuseStrategy::ra, seed);
                params.bias = core::ReuseBias::unbiased;
                return params;
            },
            4, 0, 96);
    }
}

/// Where nearly all of them are asked for again, panes on their way count anew: next to nothing is
/// wrong on either side of the edge of a pane's coloured shadow. The blocks at the border, where
/// little has a history, take the most flights.
TEST_P(ReusePanesAsked, PanesCountAnew)
{
    begin(greenhouse(0.5f), {24, 24});
    expectBlocks(
        {12, 1},
        [](uint32_t seed) {
            ReuseParams params = shallow(ReuseStrategy::ra, seed);
            params.bias = core::ReuseBias::bounded;
            params.bound = 1e-5f;
            return params;
        },
        10, 0.01, 192);
}

INSTANTIATE_TEST_SUITE_P(Devices, ReusePanes,
                         testing::Values(app::DeviceKind::cpu, app::DeviceKind::vulkan),
                         DeviceName());
INSTANTIATE_TEST_SUITE_P(Devices, ReusePanesAsked,
                         testing::Values(app::DeviceKind::cpu, app::DeviceKind::vulkan),
                         DeviceName());

}  // namespace
