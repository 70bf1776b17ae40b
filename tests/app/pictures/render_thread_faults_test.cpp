// The render thread when things fail: scenes, devices and renderers that cannot be had, and builds
// that are no longer wanted. What was on show stays.
#include <new>

#include "app/pictures/error_point.h"
#include "core/base/check.h"
#include "core/gltf/gltf.h"
#include "core/methods/method.h"
#include "tests/support/session/pretender.h"

namespace {

using namespace tests;

using Work = std::array<int, 3>;

TEST_F(RenderThread, ASceneThatCannotBeHadLeavesTheOldOneInPlace)
{
    start();
    post();
    const auto picture = finished();
    const auto old = order.world;
    work();
    {
        const std::lock_guard lock(book.mutex);
        book.atWorld.emplace_back([] { throw std::bad_alloc(); });
    }
    order.world = std::make_shared<core::World>();
    post();
    ASSERT_TRUE(until([&] { return thread->status().errorCount == 1; }));
    EXPECT_NE(thread->status().error.find("memory"), std::string::npos) << thread->status().error;
    ASSERT_TRUE(until([&] { return thread->status().stage == "idle"; }));
    EXPECT_EQ(book.get(&Book::world), old.get());
    EXPECT_EQ(newest(), picture);
    work();

    order.camera.position.x = 3;  // edits do not try it again
    post();
    std::this_thread::sleep_for(20ms);
    EXPECT_EQ(work(), (Work{0, 0, 0}));
    order.world = old;
    post();
    EXPECT_EQ(finished()->mean.pixels[0], 3.0f);
    EXPECT_EQ(work(), (Work{0, 0, 1})) << "the old scene is still there";
    EXPECT_TRUE(thread->status().error.empty());

    {
        const std::lock_guard lock(book.mutex);
        book.atWorld.emplace_back([] {
            throw core::Error("out of device memory: the BVH needs 9 MiB",
                              core::ExitCode::deviceLost);
        });
    }
    order.world = std::make_shared<core::World>();
    post();
    ASSERT_TRUE(until([&] { return thread->status().errorCount == 2; }));
    EXPECT_EQ(thread->status().error, "out of device memory: the BVH needs 9 MiB");
    ++order.restarts;  // asked for again, it works this time
    post();
    finished();
    EXPECT_EQ(book.get(&Book::world), order.world.get());
}

TEST_F(RenderThread, ALostDeviceGetsOneNewRendererWithHalfThePace)
{
    start();
    post();
    const auto picture = finished();
    const double pace = book.get(&Book::pace).dispatchSeconds;
    work();
    const auto lose = [this](int times) {
        const std::lock_guard lock(book.mutex);
        for (int i = 0; i < times; ++i) {
            book.atAdvance.emplace_back(
                [] { throw core::Error("the device is lost", core::ExitCode::deviceLost); });
        }
    };
    lose(1);
    order.camera.position.x = 2;
    post();
    EXPECT_EQ(finished()->mean.pixels[0], 2.0f);
    EXPECT_EQ(work(), (Work{1, 1, 2}));
    EXPECT_EQ(thread->status().errorCount, 1u);
    EXPECT_TRUE(thread->status().error.empty()) << "the next picture has cleared it";
    EXPECT_NEAR(book.get(&Book::pace).dispatchSeconds, pace / 2, 1e-12);

    const auto before = newest();
    lose(1);
    order.camera.position.x = 3;
    post();
    ASSERT_TRUE(until([&] { return thread->status().errorCount == 2; }));
    ASSERT_TRUE(until([&] { return thread->status().stage == "idle"; }));
    EXPECT_EQ(thread->status().error, "the device is lost");
    EXPECT_EQ(newest(), before) << "the last picture stays";
    EXPECT_EQ(work(), (Work{0, 0, 1})) << "no second automatic try";

    ++order.restarts;
    post();
    EXPECT_EQ(finished()->mean.pixels[0], 3.0f);
    EXPECT_EQ(work(), (Work{1, 1, 1}));
    EXPECT_NEAR(book.get(&Book::pace).dispatchSeconds, pace, 1e-12)
        << "asked for, it starts afresh";
}

TEST_F(RenderThread, AnyOtherFailureStandsUntilTheNextEdit)
{
    start();
    {
        const std::lock_guard lock(book.mutex);
        book.atAdvance.emplace_back([] { throw std::runtime_error("odd"); });
    }
    post();
    ASSERT_TRUE(until([&] { return thread->status().errorCount == 1; }));
    EXPECT_EQ(thread->status().error, "odd");
    post();  // the same again is no edit
    std::this_thread::sleep_for(10ms);
    EXPECT_EQ(book.get(&Book::made), 1);
    order.camera.position.x = 4;
    post();
    EXPECT_EQ(finished()->mean.pixels[0], 4.0f);
    EXPECT_EQ(book.get(&Book::made), 2) << "a renderer that has thrown is not trusted again";
}

TEST_F(RenderThread, ADeviceThatDoesNotExistLeavesTheRendererInPlace)
{
    start();
    post();
    finished();
    work();
    {
        const std::lock_guard lock(book.mutex);
        book.atMake.emplace_back([] { throw core::Error("no such device"); });
    }
    order.params.deviceIndex = 7;
    post();
    ASSERT_TRUE(until([&] { return thread->status().errorCount == 1; }));
    EXPECT_EQ(thread->status().error, "no such device");
    order.params.deviceIndex = -1;
    order.camera.position.x = 2;
    post();
    EXPECT_EQ(finished()->mean.pixels[0], 2.0f);
    EXPECT_EQ(work(), (Work{1, 0, 1}));
}

TEST_F(RenderThread, ABuildThatIsNoLongerWantedEnds)
{
    start();
    book.set(&Book::endlessWorld, true);
    post();
    ASSERT_TRUE(until([&] { return thread->status().stage == "building"; }));
    EXPECT_EQ(thread->status().fraction, 0.5);
    EXPECT_FALSE(thread->status().rendering);
    order.camera.position.x = 9;  // the same scene: goes on
    post();
    std::this_thread::sleep_for(20ms);
    EXPECT_EQ(book.get(&Book::worlds), 1);
    order.world = std::make_shared<core::World>();
    post();
    ASSERT_TRUE(until([&] { return book.get(&Book::worlds) == 2; }));
    book.set(&Book::endlessWorld, false);
    finished();
    EXPECT_EQ(book.get(&Book::world), order.world.get());
    EXPECT_EQ(thread->status().errorCount, 0u);
}

/// What is prepared serves any view of the world: only who wants another one, or asks for another
/// thing, ends it.
TEST_F(RenderThread, APreparationThatIsNoLongerWantedEnds)
{
    start();
    book.set(&Book::endlessPrepare, true);
    post();
    ASSERT_TRUE(until([&] { return thread->status().stage == "preparing"; }));
    EXPECT_EQ(thread->status().fraction, 0.25);
    EXPECT_FALSE(thread->status().rendering);
    order.camera.position.x = 9;
    order.params.method.as<core::PathParams>().maxDepth = 3;
    order.size = {16, 16};
    post();
    std::this_thread::sleep_for(20ms);
    EXPECT_EQ(book.get(&Book::preparations), 1);
    order.params.method.as<core::PathParams>().sky = core::SkySampling::whole;
    post();
    ASSERT_TRUE(until([&] { return book.get(&Book::preparations) == 2; }));
    order.world = std::make_shared<core::World>();
    post();
    ASSERT_TRUE(until([&] { return book.get(&Book::preparations) == 3; }));
    EXPECT_EQ(book.get(&Book::world), order.world.get());
    EXPECT_EQ(book.get(&Book::views), 0);
    book.set(&Book::endlessPrepare, false);
    EXPECT_EQ(finished()->mean.pixels[0], 9.0f);
    EXPECT_EQ(thread->status().errorCount, 0u);
    EXPECT_EQ(work(), (Work{1, 2, 1}));
}

}  // namespace
