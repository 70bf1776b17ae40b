// The render thread with pretended renderers, so that every rule can be observed: what restarts,
// what is stopped, what is published, limits, ends. Then with the real ones: the picture is that of
// a direct render, bit by bit.
#include <cmath>
#include <random>

#include "app/pictures/error_point.h"
#include "core/base/check.h"
#include "core/gltf/gltf.h"
#include "core/methods/method.h"
#include "tests/support/session/pretender.h"

namespace {

using namespace tests;

using Work = std::array<int, 3>;

std::shared_ptr<const app::Reference> flatReference(float value)
{
    auto reference = std::make_shared<app::Reference>();
    reference->mean = core::Image(32, 16, 3);
    std::ranges::fill(reference->mean.pixels, value);
    return reference;
}

TEST_F(RenderThread, ABlackPictureSaysSo)
{
    start();
    order.camera.position.x = 0;
    post();
    EXPECT_TRUE(finished()->black);
    order.moving = true;
    order.camera.position.y = 1;
    post();
    ASSERT_TRUE(until([&] { return newest()->generation == generation; }));
    EXPECT_FALSE(newest()->black) << "few paths of few pixels prove nothing";
    order.moving = false;
    order.camera.position.x = 0.5;
    post();
    EXPECT_FALSE(finished()->black);
}

TEST_F(RenderThread, RendersUpToTheLimitAndRests)
{
    start();
    EXPECT_EQ(newest(), nullptr);
    EXPECT_EQ(post(), 1u);
    const auto picture = finished();
    EXPECT_EQ(picture->samples, 4u);
    EXPECT_EQ(picture->fullSize, order.size);
    EXPECT_EQ(picture->mean.width, 32u);
    EXPECT_EQ(picture->mean.height, 16u);
    for (const float v : picture->mean.pixels) ASSERT_EQ(v, 1.0f);
    EXPECT_FALSE(picture->preview);
    EXPECT_EQ(picture->params, order.params);
    EXPECT_EQ(work(), (Work{1, 1, 1}));
    ASSERT_TRUE(until([&] { return thread->status().stage == "idle"; }));
    EXPECT_FALSE(thread->status().rendering);
    const int advances = book.get(&Book::advances), pictures = book.get(&Book::pictures);
    EXPECT_GE(pictures, 1);
    EXPECT_LE(pictures, advances);
    std::this_thread::sleep_for(30ms);
    EXPECT_EQ(book.get(&Book::advances), advances);
    EXPECT_EQ(book.get(&Book::pictures), pictures);
    EXPECT_EQ(newest(), picture);
}

TEST_F(RenderThread, WithoutASceneThereIsARendererAndNothingElse)
{
    start();
    const auto world = std::exchange(order.world, nullptr);
    post();
    std::this_thread::sleep_for(20ms);
    EXPECT_EQ(work(), (Work{1, 0, 0}));
    EXPECT_EQ(newest(), nullptr);
    EXPECT_EQ(book.get(&Book::pictures), 0);
    EXPECT_EQ(thread->status().stage, "idle");
    order.world = world;
    post();
    finished();
    EXPECT_EQ(work(), (Work{0, 1, 1})) << "the same renderer";
}

TEST_F(RenderThread, OnlyWhatAChangeInvalidatesIsMadeAnew)
{
    start();
    post();
    finished();
    work();
    const auto expect = [&](const char* what, const Work& wanted) {
        post();
        const auto picture = finished();
        EXPECT_EQ(work(), wanted) << what;
        EXPECT_EQ(picture->generation, generation) << what;
    };
    const Work nothing{0, 0, 0}, view{0, 0, 1}, world{0, 1, 1}, renderer{1, 1, 1};
    expect("the same again", nothing);
    order.params.sppLimit = 8;
    expect("more samples", nothing);
    EXPECT_EQ(newest()->samples, 8u);
    order.params.sppLimit = 3;
    expect("a limit below what there is", nothing);
    EXPECT_EQ(newest()->samples, 8u);
    order.targetFrameSeconds = 0.5;
    order.movingDepth = 7;
    expect("settings of previews", nothing);
    order.moving = true;
    expect("a hand on the camera that does not move it", nothing);
    EXPECT_FALSE(newest()->preview);
    order.moving = false;
    expect("and lets go", nothing);
    order.paused = true;
    expect("a pause", nothing);
    order.paused = false;
    order.wantVariance = true;
    expect("the variance", nothing);
    ASSERT_NE(newest()->variance, nullptr);
    EXPECT_NEAR(newest()->variance->pixels[0], 1.0 / 7, 1e-6);
    order.wantAovs = true;
    expect("first hits", nothing);
    ASSERT_NE(newest()->aovs, nullptr);
    EXPECT_EQ(newest()->aovs->depth.width, 32u);
    order.camera.position.x = 2;
    expect("the camera", view);
    EXPECT_EQ(newest()->mean.pixels[0], 2.0f);
    order.size = {33, 16};
    expect("the size", view);
    order.params.method.as<core::PathParams>().maxDepth = 3;
    expect("a parameter", view);
    ++order.restarts;
    expect("a restart", view);
    order.world = std::make_shared<core::World>();
    expect("the scene", world);
    order.validation = true;
    expect("validation", renderer);
    order.params.device = app::DeviceKind::vulkan;
    expect("the device", renderer);
    order.params.deviceIndex = 1;
    expect("which device", renderer);
    for (const core::MethodInfo& method : core::methods()) {
        if (method.id() == order.params.method.id()) continue;
        order.params.method = method.defaults;
        expect("the method", renderer);
    }
}

TEST_F(RenderThread, ASceneThatIsLeftIsLetGo)
{
    start();
    post();
    finished();
    const std::weak_ptr<const core::World> before = order.world;
    order.world = std::make_shared<core::World>();
    post();
    finished();
    EXPECT_TRUE(until([&] { return before.expired(); }));
}

TEST_F(RenderThread, APauseKeepsTheFilmAndANewViewStillGetsItsPicture)
{
    order.params.sppLimit = 0;
    order.paused = true;
    start();
    post();
    ASSERT_TRUE(until([&] { return newest() && newest()->samples == 1; }));
    ASSERT_TRUE(until([&] { return thread->status().stage == "idle"; }));
    EXPECT_EQ(newest()->samples, 1u);
    order.camera.position.x = 5;
    post();
    ASSERT_TRUE(until([&] { return newest()->generation == generation; }));
    EXPECT_EQ(newest()->mean.pixels[0], 5.0f);
    EXPECT_EQ(newest()->samples, 1u);
    order.paused = false;
    post();
    ASSERT_TRUE(until([&] { return newest()->samples > 20; }));
    order.paused = true;
    post();
    ASSERT_TRUE(until(
        [&] { return newest()->generation == generation && thread->status().stage == "idle"; }));
    const uint64_t samples = newest()->samples;
    order.paused = false;
    order.params.sppLimit = samples + 5;
    post();
    EXPECT_EQ(finished()->samples, samples + 5);
    EXPECT_EQ(book.get(&Book::views), 2);
}

TEST_F(RenderThread, AnEditStopsASampleThatWouldTakeForever)
{
    start();
    for (int i = 0; i < 20; ++i) {
        book.set(&Book::secondsPerPixel, 1.0);  // ten minutes for the picture
        order.camera.position.x = 10 + i;
        post();
        ASSERT_TRUE(until([&] { return book.get(&Book::advances) > 0; }));
        std::this_thread::sleep_for(std::chrono::microseconds(500 * i));
        book.set(&Book::secondsPerPixel, 0.0);
        order.camera.position.x = 100 + i;
        post();
        const auto picture = finished();
        EXPECT_EQ(picture->mean.pixels[0], 100.0f + static_cast<float>(i));
    }
    EXPECT_GT(thread->status().lastStopSeconds, 0);
    EXPECT_LT(thread->status().lastStopSeconds, 5);
}

TEST_F(RenderThread, GoingBackToWhatWasInterruptedStillGivesAPicture)
{
    start();
    book.set(&Book::secondsPerPixel, 1e-4);
    for (int i = 0; i < 10; ++i) {
        post();
        std::this_thread::sleep_for(10ms);
        order.camera.position.x += 1;
        post();  // stops it
        order.camera.position.x -= 1;
    }
    post();
    EXPECT_EQ(finished()->samples, 4u);
    EXPECT_EQ(newest()->mean.pixels[0], 1.0f);
}

TEST_F(RenderThread, SecondsAndErrorAreLimits)
{
    start();
    book.set(&Book::secondsPerPixel, 2e-3 / (32 * 16));
    order.params.sppLimit = 0;
    order.params.secondsLimit = 0.1;
    post();
    const auto timed = finished();
    EXPECT_GE(timed->seconds, 0.1);
    EXPECT_LT(timed->samples, 60u);

    book.set(&Book::secondsPerPixel, 0.0);
    order.params.secondsLimit = 0;
    order.params.errorLimit = 0.1;  // the spread's is 1 / sqrt(n - 1)
    ++order.restarts;
    post();
    const auto precise = finished();
    EXPECT_GE(precise->samples, 101u);
    EXPECT_LE(precise->samples, 200u);
    EXPECT_LE(precise->curve.back().estimated, 0.1);
}

TEST_F(RenderThread, TheCurveHasAPointAtEachGrowthAndKnowsTheReference)
{
    start();
    auto reference = std::make_shared<app::Reference>();
    reference->mean = core::Image(32, 16, 3);
    reference->mean.pixels.assign(reference->mean.pixels.size(), 1.5f);
    order.reference = reference;
    order.params.sppLimit = 200;
    post();
    auto picture = finished();
    ASSERT_GT(picture->curve.size(), 5u);
    for (size_t i = 0; i < picture->curve.size(); ++i) {
        const app::ErrorPoint& point = picture->curve[i];
        EXPECT_DOUBLE_EQ(point.rmse, 0.5);
        EXPECT_NEAR(point.rmseSe, 0, 1e-12);  // the error is the same everywhere
        EXPECT_NEAR(point.estimated, 1 / std::sqrt(double(point.samples) - 1), 1e-6);
        if (i == 0) continue;
        EXPECT_GT(point.samples, picture->curve[i - 1].samples);
        EXPECT_GE(point.seconds, picture->curve[i - 1].seconds);
    }
    EXPECT_EQ(picture->curve.back().samples, 200u);

    auto other = std::make_shared<app::Reference>(*reference);
    other->mean.pixels.assign(other->mean.pixels.size(), 3.0f);
    order.reference = other;  // of a picture that is done
    post();
    ASSERT_TRUE(until([&] { return newest()->generation == generation; }));
    EXPECT_DOUBLE_EQ(newest()->curve.back().rmse, 2);
    EXPECT_EQ(newest()->samples, 200u);

    other = std::make_shared<app::Reference>(*reference);
    other->mean = core::Image(8, 8, 3);
    order.reference = other;  // of another size: not this picture's
    post();
    ASSERT_TRUE(until([&] { return newest()->generation == generation; }));
    EXPECT_EQ(newest()->curve.back().rmse, 0);
    EXPECT_EQ(book.get(&Book::views), 1);
}

/// A curve that mixed them would tell a slope that no picture has.
TEST_F(RenderThread, ErrorsAgainstAReferenceBeforeCountNoMore)
{
    start();
    order.reference = flatReference(1.5f);
    order.params.sppLimit = 50;
    post();
    ASSERT_GT(finished()->curve.size(), 5u);
    order.reference = flatReference(3);
    order.params.sppLimit = 100;
    post();
    const auto picture = finished();
    EXPECT_EQ(picture->curve.back().samples, 100u);
    for (const app::ErrorPoint& point : picture->curve) {
        EXPECT_DOUBLE_EQ(point.rmse, point.samples < 50 ? 0 : 2) << point.samples;
        EXPECT_NEAR(point.estimated, 1 / std::sqrt(double(point.samples) - 1), 1e-6);
        EXPECT_NEAR(point.rmseSe, 0, 1e-12);
    }
}

TEST_F(RenderThread, AReferenceThatComesDuringASampleIsMeasuredAfterIt)
{
    start();
    book.set(&Book::secondsPerPixel, 0.12 / (32 * 16));  // more than a call of the renderer takes
    order.reference = flatReference(1.5f);
    order.params.sppLimit = 100;
    post();
    ASSERT_TRUE(until([&] { return newest() && newest()->samples >= 12; }));
    std::this_thread::sleep_for(40ms);
    order.reference = flatReference(3);
    post();
    ASSERT_TRUE(until([&] { return newest()->generation == generation; }));
    EXPECT_NE(newest()->curve.back().rmse, 0.5) << "that against the reference before";
    ASSERT_TRUE(until([&] { return newest()->samples >= 15; }));
    const auto picture = newest();
    const auto first = std::ranges::find(picture->curve, 2.0, &app::ErrorPoint::rmse);
    ASSERT_NE(first, picture->curve.end());
    EXPECT_GT(first->samples, 12u);
    EXPECT_LT(first->samples, 15u) << "that is where the next point would be by itself";
}

TEST_F(RenderThread, EndsSoonWhateverItDoes)
{
    book.set(&Book::secondsPerPixel, 1.0);
    for (int Book::*const stage : {&Book::worlds, &Book::preparations, &Book::advances}) {
        book.set(&Book::endlessWorld, stage == &Book::worlds);
        book.set(&Book::endlessPrepare, stage == &Book::preparations);
        start();
        const int before = book.get(stage);
        post();
        ASSERT_TRUE(until([&] { return book.get(stage) > before; }));
        const auto begin = Clock::now();
        thread.reset();
        EXPECT_LT(Clock::now() - begin, 1s);
    }
}

TEST_F(RenderThread, NoPictureBelongsToAnotherOrderThanItSays)
{
    start();
    std::mt19937 random(11);
    std::vector<std::shared_ptr<const core::World>> scenes;
    for (int i = 0; i < 3; ++i) scenes.push_back(std::make_shared<core::World>());
    std::vector<app::RenderRequest> orders{{}};
    uint64_t last = 0, looked = 0;
    for (int step = 0; step < 4000; ++step) {
        switch (random() % 13) {
        case 0:
            order.world = scenes[random() % 3];
            break;
        case 1:
            order.size = {8 + random() % 20, 8 + random() % 20};
            break;
        case 2:
            order.moving = !order.moving;
            break;
        case 3:
            order.paused = !order.paused;
            break;
        case 4:
            order.params.sppLimit = random() % 50;
            break;
        case 5:
            order.params.device =
                random() % 2 == 0 ? app::DeviceKind::cpu : app::DeviceKind::vulkan;
            break;
        case 6:
            book.set(&Book::secondsPerPixel, random() % 2 == 0 ? 0.0 : 1e-5);
            break;
        case 7:
            order.wantVariance = !order.wantVariance;
            break;
        case 8:
            std::this_thread::sleep_for(std::chrono::microseconds(random() % 2000));
            break;
        case 9:
            order.movingShows = random() % 2 == 0 ? app::Moving::filled : app::Moving::path;
            order.movingDetail = true;
            break;
        default:
            order.camera.position.x = double(random() % 1000);
            break;
        }
        post();
        orders.push_back(order);
        ASSERT_EQ(generation + 1, orders.size());
        const auto picture = newest();
        if (!picture) continue;
        ++looked;
        ASSERT_GE(picture->generation, last);  // never backwards
        last = picture->generation;
        ASSERT_LT(picture->generation, orders.size());
        const app::RenderRequest& its = orders[picture->generation];
        ASSERT_EQ(double(picture->mean.pixels[0]), its.camera.position.x);
        ASSERT_EQ(picture->camera, its.camera);
        ASSERT_EQ(picture->fullSize, its.size);
        ASSERT_EQ(picture->params, its.params);
        if (picture->samples == 0) {  // a part of the first sample, over the small picture
            ASSERT_TRUE(picture->preview);
            ASSERT_GT(picture->fraction, 0);
            ASSERT_FALSE(picture->finished);
        }
        ASSERT_TRUE(picture->preview || picture->mean.width == its.size.x);
    }
    EXPECT_GT(looked, 1000u);
    order.moving = order.paused = false;
    order.params.sppLimit = 3;
    book.set(&Book::secondsPerPixel, 0.0);
    post();
    EXPECT_GE(finished()->samples, 3u);
    EXPECT_EQ(thread->status().errorCount, 0u);
}

void expectDirectRender(app::DeviceKind device)
{
    app::RenderThread thread;
    app::RenderRequest order;
    order.world =
        core::makeWorld(core::loadGltf(REKINDLE_SOURCE_DIR "/assets/cornell-glossy.gltf"));
    order.camera = order.world->cameras.at(0);
    order.size = {75, 50};
    order.params.device = device;
    order.params.sppLimit = 21;
    order.wantVariance = true;
    order.wantAovs = true;
    const uint64_t generation = thread.request(order);
    std::shared_ptr<const app::Picture> picture;
    for (const auto end = Clock::now() + 60s; Clock::now() < end;
         std::this_thread::sleep_for(1ms)) {
        picture = thread.newest();
        if (picture && picture->finished) break;
    }
    ASSERT_TRUE(picture && picture->finished) << thread.status().error;
    EXPECT_EQ(picture->generation, generation);
    EXPECT_GT(picture->stats.rays, 0u);

    const auto renderer = app::viewRenderers()(order.params, false);
    renderer->setWorld(order.world, {});
    renderer->setView({order.camera, order.size, order.params.method}, core::Start::anew);
    renderer->advance({.samples = 21}, {});
    const core::Estimate direct = renderer->read(core::Reading::everything);
    EXPECT_EQ(picture->mean.pixels, direct.mean.pixels);
    EXPECT_EQ(picture->variance->pixels, direct.variance.pixels);
    EXPECT_EQ(picture->aovs->depth.pixels, renderer->aovs().depth.pixels);
    EXPECT_TRUE(picture->counters.clean());
}

TEST(RenderThreadReal, ThePictureIsThatOfADirectRenderOnTheCpu)
{
    expectDirectRender(app::DeviceKind::cpu);
}

TEST(RenderThreadReal, ThePictureIsThatOfADirectRenderOnVulkan)
{
    expectDirectRender(app::DeviceKind::vulkan);
}

}  // namespace
