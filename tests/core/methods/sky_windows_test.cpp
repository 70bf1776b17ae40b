// T36: drawing the sky by regions changes the noise of a picture and nothing else; scenes that need
// no regions keep their bits.
#include <gtest/gtest.h>

#include "core/methods/method.h"
#include "tests/support/methods/sky_preparing.h"
#include "tests/support/scenes/sky_rooms.h"
#include "tests/support/statistics/compare_films.h"

namespace {

using namespace tests;
using core::SkySampling;

core::PathParams params(SkySampling sky, uint32_t seed)
{
    core::PathParams p = independentParams(core::Strategy::mis, 6);
    p.sky = sky;
    p.seed = seed;
    return p;
}

bool hasRegions(const core::Renderer& renderer)
{
    for (const core::StatsDetail& detail : renderer.stats().details)
        if (detail.name == "sky_regions") return true;
    return false;
}

double meanVariance(const core::Estimate& e)
{
    double sum = 0;
    for (const float v : e.variance.pixels) sum += static_cast<double>(v);
    return sum / static_cast<double>(e.variance.pixels.size());
}

void expectTheSamePicture(const char* name, const SceneBuilder& builder, uint32_t samples)
{
    const auto world = builder.world();
    const core::Estimate regions =
        render(world, 48, 48, samples, params(SkySampling::automatic, 1));
    const core::Estimate whole = render(world, 48, 48, samples, params(SkySampling::whole, 2));
    const FilmComparison c = compareFilms(regions, whole);
    EXPECT_TRUE(c.agree()) << name << ": " << c.describe();
    EXPECT_LT(c.detectable, 0.02) << name << " is underpowered: " << c.describe();
    EXPECT_LT(1.5 * meanVariance(regions), meanVariance(whole)) << name << ": no gain";
}

TEST(SkyWindows, DiffuseRoomKeepsItsMean)
{
    expectTheSamePicture("diffuse", windowRoom(false), 400);
}

TEST(SkyWindows, GlossyRoomBehindAPaneKeepsItsMean)
{
    SceneBuilder b = windowRoom(false, glossy(glm::vec3(0.6f, 0.5f, 0.4f), 0, 0.3f));
    core::Material pane = lambert(glm::vec3(0.9f));
    pane.data.transmission = 1;
    pane.data.roughness = 0;
    b.quad({1, 0, -0.4f}, {0, 0, 0.8f}, {0, 0.6f, 0}, b.material(pane));
    expectTheSamePicture("glossy", b, 400);
}

/// All that share the choice of an emitter: sky, sun, and lamps in the tree.
TEST(SkyWindows, RoomWithLampsAndSunKeepsItsMean)
{
    SceneBuilder b = roomWithLamps();
    core::Sun sun;
    sun.directionTowards = {0.8f, 0.5f, 0.1f};
    sun.angularRadius = 0.1f;
    sun.radiance = glm::vec3(30);
    b.scene.sun = sun;
    const auto world = b.world();
    const core::Estimate regions = render(world, 48, 48, 400, params(SkySampling::automatic, 1));
    const core::Estimate whole = render(world, 48, 48, 400, params(SkySampling::whole, 2));
    const FilmComparison c = compareFilms(regions, whole);
    EXPECT_TRUE(c.agree()) << c.describe();
    EXPECT_LT(c.detectable, 0.02) << "underpowered: " << c.describe();
}

TEST(SkyWindows, ScenesThatNeedNoneKeepTheirBits)
{
    SceneBuilder open;
    open.quad({-4, 0, 4}, {8, 0, 0}, {0, 0, -8}, open.material(lambert(glm::vec3(0.5f))));
    open.camera({0, 1, 5}, {0, 0, 0}, 0.8);
    addSky(open, true);
    const auto world = open.world();
    EXPECT_EQ(render(world, 16, 16, 4, params(SkySampling::automatic, 1)).mean.pixels,
              render(world, 16, 16, 4, params(SkySampling::whole, 1)).mean.pixels);

    // Nor do regions that were asked for by name change what is drawn without.
    const auto renderer = core::makeRenderer("path");
    renderer->setWorld(world, {});
    for (const SkySampling sky : {SkySampling::regions, SkySampling::automatic}) {
        renderer->setView({world->cameras.at(0), {16, 16}, params(sky, 1)}, core::Start::anew);
        renderer->advance({.samples = 2}, {});
        EXPECT_EQ(hasRegions(*renderer), sky == SkySampling::regions);
    }
}

TEST(SkyWindows, RegionsComeAndGoWithWhatIsAsked)
{
    const auto world = windowRoom(true).world();
    const auto renderer = core::makeRenderer("path");
    renderer->setWorld(world, {});
    const auto picture = [&](SkySampling sky) {
        renderer->setView({world->cameras.at(0), {16, 16}, params(sky, 1)}, core::Start::anew);
        renderer->advance({.samples = 2}, {});
        EXPECT_EQ(hasRegions(*renderer), sky != SkySampling::whole);
        return renderer->read(core::Reading::mean).mean.pixels;
    };
    const auto first = picture(SkySampling::automatic);
    EXPECT_NE(first, picture(SkySampling::whole));
    EXPECT_EQ(first, picture(SkySampling::regions));
    renderer->setWorld(world, {});
    EXPECT_EQ(first, picture(SkySampling::regions));
    EXPECT_EQ(first, picture(SkySampling::automatic));
}

TEST(SkyWindows, MakingRegionsTellsHowFarItIsAndCanBeStopped)
{
    const auto world = windowRoom(true).world();
    core::GuidedParams guided;
    guided.sky = SkySampling::regions;
    for (const core::AnyParams& p :
         {core::AnyParams(params(SkySampling::automatic, 1)), core::AnyParams(guided)}) {
        SCOPED_TRACE(p.id());
        const auto stages = expectStoppable(*core::makeRenderer(p.id()), world, p);
        EXPECT_EQ(stages, std::set<std::string>{"looking for the sky"});
    }
}

TEST(SkyWindows, WhereTheSkyIsDrawnAsAWholeThereIsNothingToPrepare)
{
    const auto world = windowRoom(true).world();
    const auto renderer = core::makeRenderer("path");
    renderer->setWorld(world, {});
    EXPECT_TRUE(prepareUntil(*renderer, params(SkySampling::whole, 1), 0).empty());
    SceneBuilder dark = windowRoom(true);
    dark.scene.environment.reset();
    const auto without = dark.world();
    for (const core::MethodInfo& method : core::methods()) {
        const auto other = core::makeRenderer(method.id());
        other->setWorld(without, {});
        EXPECT_TRUE(prepareUntil(*other, method.defaults, 0).empty()) << method.id();
    }
}

/// A picture that is under way goes on when what another one needs is no longer wanted.
TEST(SkyWindows, AStopLeavesThePictureOfBefore)
{
    const auto world = windowRoom(true).world();
    const auto renderer = core::makeRenderer("path");
    renderer->setWorld(world, {});
    renderer->setView({world->cameras.at(0), {16, 16}, params(SkySampling::whole, 1)},
                      core::Start::anew);
    renderer->advance({.samples = 1}, {});
    prepareUntil(*renderer, params(SkySampling::regions, 1), 3);
    renderer->advance({.samples = 1}, {});
    EXPECT_EQ(renderer->read(core::Reading::mean).mean.pixels,
              render(world, 16, 16, 2, params(SkySampling::whole, 1)).mean.pixels);
}

}  // namespace
