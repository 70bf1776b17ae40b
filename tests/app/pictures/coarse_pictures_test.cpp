// Pictures of fewer pixels than asked for, with pretended renderers: those that precede a slow
// sample and grow towards it, and those shown while the camera moves.
#include <map>
#include <vector>

#include "tests/support/session/pretender.h"

namespace {

using namespace tests;

struct CoarsePictures : RenderThread {
    /// One sample of 256 x 256 pixels that takes that long.
    void orderSlow(double seconds)
    {
        order.params.sppLimit = 1;
        order.size = {256, 256};
        start();
        book.set(&Book::secondsPerPixel, seconds / (256 * 256));
        post();
    }
};

TEST_F(CoarsePictures, PartsOfASlowSampleAreNews)
{
    orderSlow(2.5);
    ASSERT_TRUE(until([&] {
        return newest() && newest()->mean.width == 256 && newest()->samples == 0 &&
               newest()->fraction > 0;
    }));
    const auto part = newest();
    EXPECT_TRUE(part->preview);
    // What has not been rendered yet shows the small picture.
    for (const float value : part->mean.pixels) ASSERT_EQ(value, 1.0f);
    ASSERT_TRUE(until([&] { return newest()->fraction > part->fraction; }));
    EXPECT_EQ(newest()->samples, 0u);
    EXPECT_EQ(finished()->samples, 1u);
    EXPECT_EQ(newest()->fraction, 0);
    EXPECT_FALSE(newest()->preview);
    EXPECT_EQ(book.get(&Book::views), 3);  // two small ones and the full one
}

/// Where kernels have to be compiled, first hits come before: once for a scene, and not for who
/// wants paths alone.
TEST_F(CoarsePictures, OfANewSceneFirstHitsAreShownUntilThereAreSamples)
{
    order.params.sppLimit = 1;
    order.size = {256, 256};
    order.movingShows = app::Moving::filled;
    start();
    book.set(&Book::looks, true);
    const auto first = [&] {
        std::shared_ptr<const app::Picture> picture;
        book.then(&Book::atAdvance, [&] { picture = newest(); });
        post();
        finished();
        return picture;
    };
    const auto look = first();
    ASSERT_NE(look, nullptr);
    EXPECT_EQ(look->generation, generation);
    EXPECT_TRUE(look->shaded);
    EXPECT_TRUE(look->preview);
    EXPECT_FALSE(look->finished);
    EXPECT_EQ(look->mean.width, 64u);
    EXPECT_EQ(look->fullSize, order.size);
    EXPECT_EQ(look->world.lock(), order.world);
    ASSERT_NE(look->guide, nullptr);
    EXPECT_EQ(newest()->mean.pixels[0], 1.0f) << "nothing of it is in the picture";
    EXPECT_FALSE(newest()->shaded);

    order.camera.position.x = 2;  // the same scene
    EXPECT_FALSE(first()->shaded);
    order.world = std::make_shared<core::World>();
    EXPECT_TRUE(first()->shaded);
    order.world = std::make_shared<core::World>();
    order.movingShows = app::Moving::path;
    EXPECT_FALSE(first()->shaded);
}

TEST_F(CoarsePictures, AVerySlowPictureComesByHalvesOfItsSides)
{
    orderSlow(1.6);
    std::vector<uint32_t> widths;
    ASSERT_TRUE(until([&] {
        const auto p = newest();
        if (!p) return false;
        EXPECT_EQ(p->preview, p->samples == 0 || p->mean.width < 256);
        if (widths.empty() || widths.back() != p->mean.width) widths.push_back(p->mean.width);
        return p->finished;
    }));
    EXPECT_EQ(widths, (std::vector<uint32_t>{64, 128, 256}));
    EXPECT_EQ(thread->status().movingSeconds, 0) << "the camera has not moved";
    EXPECT_EQ(newest()->mean.pixels[0], 1.0f);
}

TEST_F(CoarsePictures, ACameraThatMovesWaitsForNoPictureOfHalfTheSides)
{
    orderSlow(40.0);
    ASSERT_TRUE(until([&] { return newest() && newest()->mean.width == 128; }));
    EXPECT_TRUE(newest()->preview);
    EXPECT_EQ(newest()->samples, 0u);
    book.set(&Book::secondsPerPixel, 0.0);
    order.camera.position.x = 7;
    post();
    EXPECT_EQ(finished()->mean.pixels[0], 7.0f);
    EXPECT_LT(thread->status().lastStopSeconds, 5);
}

TEST_F(CoarsePictures, WhileTheCameraMovesPicturesAreSmallAndNoneIsLost)
{
    start();
    order.size = {640, 360};
    order.params.sppLimit = 2;
    book.set(&Book::secondsPerPixel, 4e-7);  // a full sample takes 92 ms
    order.moving = true;
    std::map<uint64_t, double> where;
    std::map<uint64_t, glm::uvec2> seen;
    for (int frame = 0; frame < 120; ++frame) {
        order.camera.position.x = frame;
        post();
        where[generation] = frame;
        std::this_thread::sleep_for(8ms);
        if (const auto p = newest()) {
            EXPECT_TRUE(p->preview);
            ASSERT_EQ(double(p->mean.pixels[0]), where.at(p->generation));
            seen[p->generation] = {p->mean.width, p->mean.height};
        }
    }
    EXPECT_GT(seen.size(), 3u) << "previews were stopped by the next step of the camera";
    const glm::uvec2 last = seen.rbegin()->second;
    EXPECT_LT(last.x, 640u);
    EXPECT_GE(last.x, 80u);
    EXPECT_NEAR(double(last.x) / last.y, 640.0 / 360, 0.05);
    EXPECT_GT(thread->status().movingSeconds, 0);
    EXPECT_NEAR(double(thread->status().movingScale), last.x / 640.0, 0.01);

    order.moving = false;
    post();
    uint64_t firstFull = 0;
    ASSERT_TRUE(until([&] {
        const auto p = newest();
        EXPECT_NE(p, nullptr);
        if (!p->preview && firstFull == 0) firstFull = p->samples;
        return p->finished;
    }));
    EXPECT_EQ(firstFull, 1u);
    EXPECT_EQ(newest()->mean.width, 640u);
    EXPECT_EQ(newest()->samples, 2u);
}

/// Nothing stops the first sample of such a picture; the next one gives way to the next view.
TEST_F(CoarsePictures, WhileTheCameraMovesTheFirstSampleIsWhole)
{
    start();
    order.moving = true;
    order.params.sppLimit = 2;
    std::vector<bool> whole;
    const auto look = [&] { whole.push_back(book.get(&Book::pace).whole); };
    book.then(&Book::atAdvance, look);
    book.then(&Book::atAdvance, look);
    post();
    ASSERT_TRUE(until([&] { return newest() && newest()->samples >= 2; }));
    EXPECT_EQ(whole, (std::vector{true, false}));

    order.paused = true;  // so that what comes next is a picture at rest
    post();
    ASSERT_TRUE(until([&] { return thread->status().stage == "idle"; }));
    whole.clear();
    book.then(&Book::atAdvance, look);
    order.moving = order.paused = false;
    post();
    ASSERT_TRUE(until([&] { return newest()->finished && !newest()->preview; }));
    EXPECT_EQ(whole, std::vector{false});
}

TEST_F(CoarsePictures, WhileTheCameraMovesAMethodMayHaveQuickerParameters)
{
    order.params.method =
        core::ManyLightsParams{.lights = 100000, .clusters = 1000, .receivers = 4};
    order.params.sppLimit = 1;
    order.moving = true;
    start();
    post();
    ASSERT_TRUE(until([&] { return newest() && newest()->generation == generation; }));
    const auto moving = book.get(&Book::params).as<core::ManyLightsParams>();
    const core::ManyLightsParams quick;
    EXPECT_EQ(moving.lights, quick.lights);
    EXPECT_EQ(moving.clusters, quick.clusters);
    EXPECT_EQ(moving.receivers, quick.receivers);
    EXPECT_EQ(newest()->params.method, order.params.method)
        << "what is shown is what was asked for";
    order.moving = false;
    post();
    finished();
    EXPECT_EQ(book.get(&Book::params), order.params.method);
}

/// A full picture of which only quicker ones are known is preceded by a small one, as one of which
/// nothing is.
TEST_F(CoarsePictures, QuickerParametersTellNothingOfPicturesAtRest)
{
    order.params.method = core::ManyLightsParams{.lights = 100000};
    order.params.sppLimit = 1;
    order.size = {256, 256};
    order.moving = true;
    start();
    post();
    ASSERT_TRUE(until([&] { return newest() && newest()->generation == generation; }));
    book.set(&Book::sizes, {});
    order.moving = false;
    order.camera.position.x = 2;
    post();
    finished();
    const std::vector<glm::uvec2> sizes = book.get(&Book::sizes);
    ASSERT_EQ(sizes.size(), 2u);
    EXPECT_EQ(sizes[0], glm::uvec2(64, 64));
    EXPECT_EQ(sizes[1], order.size);
}

TEST_F(CoarsePictures, ShadedMotionTracesNoPathsAndARestingPictureIsOneOfPaths)
{
    start();
    order.size = {64, 36};
    order.params.sppLimit = 1;
    order.moving = true;
    order.movingShows = app::Moving::shaded;
    for (int frame = 0; frame < 5; ++frame) {
        order.camera.position.x = frame;
        post();
        ASSERT_TRUE(until([&] { return newest() && newest()->generation >= generation; }));
        EXPECT_TRUE(newest()->preview);
    }
    EXPECT_EQ(book.get(&Book::advances), 0);
    order.moving = false;
    const auto picture = (post(), finished());
    EXPECT_FALSE(picture->preview || picture->shaded);
    EXPECT_GT(book.get(&Book::advances), 0);
    EXPECT_EQ(picture->samples, 1u);
}

TEST_F(CoarsePictures, LookIntoPanesUnlessFirstHitsThemselvesAreOnShow)
{
    start();
    order.size = {640, 360};
    order.moving = order.movingDetail = true;
    for (const app::Moving shows : {app::Moving::filled, app::Moving::shaded})
        for (const bool firstHits : {false, true}) {
            book.set(&Book::sights, {});
            order.movingShows = shows;
            order.wantAovs = firstHits;
            order.camera.position.x += 1;
            post();
            ASSERT_TRUE(until([&] { return newest() && newest()->generation >= generation; }));
            const std::vector<core::Sight> sights = book.get(&Book::sights);
            EXPECT_FALSE(sights.empty());
            for (const core::Sight sight : sights)
                EXPECT_EQ(sight, firstHits ? core::Sight::first : core::Sight::clear);
        }
}

TEST_F(CoarsePictures, ASlowPictureIsPrecededByACoarseOne)
{
    start();
    order.size = {640, 360};
    order.params.sppLimit = 1;
    book.set(&Book::secondsPerPixel, 1e-6);
    post();
    ASSERT_TRUE(until([&] { return newest() != nullptr; }));
    EXPECT_TRUE(newest()->preview);
    EXPECT_LE(newest()->mean.width, 320u);
    EXPECT_FALSE(newest()->finished);
    const auto picture = finished();
    EXPECT_FALSE(picture->preview);
    EXPECT_EQ(picture->mean.width, 640u);
}

/// A camera that has moved on while paths were traced: the surfaces are what it sees now.
struct MovingOn : RenderThread {
    MovingOn()
    {
        order.size = {640, 360};
        order.moving = order.movingDetail = true;
        order.movingShows = app::Moving::filled;
        order.params.sppLimit = 1;
    }

    /// The first picture of an order, if `change` is done to the order while its paths are traced;
    /// null if none came before those of the changed one were traced.
    std::shared_ptr<const app::Picture> changedMeanwhile(const std::function<void()>& change)
    {
        thread.reset();
        start();
        book.set(&Book::secondsPerPixel, 1e-7);
        before = order;
        std::shared_ptr<const app::Picture> first;
        std::atomic<uint64_t> changed = 0;
        std::atomic<bool> seen = false;
        book.then(&Book::atAdvance, [&] {
            change();
            changed = thread->request(order);
        });
        book.then(&Book::atAdvance, [&] {
            first = newest();
            seen = true;
        });
        thread->request(order);
        EXPECT_TRUE(until([&] { return seen.load(); }));
        generation = changed;
        EXPECT_TRUE(until([&] { return newest() && newest()->generation >= generation; }));
        return first;
    }

    app::RenderRequest before;
};

TEST_F(MovingOn, IsSeenInThePictureUnderWay)
{
    const auto picture = changedMeanwhile([&] { order.camera.position.x = 5; });
    ASSERT_NE(picture, nullptr);
    EXPECT_EQ(picture->generation, generation);
    EXPECT_EQ(picture->camera, order.camera);
    EXPECT_EQ(picture->mean.pixels[0], 5.0f);
    EXPECT_LT(picture->sampled.x, picture->mean.width);
}

/// Of slow light the surfaces come before it, for each step of the camera; the light goes on.
TEST_F(MovingOn, IsSeenBeforeThereIsNewLight)
{
    start();
    book.set(&Book::secondsPerPixel, 3e-5);  // light has far fewer pixels than surfaces
    post();
    ASSERT_TRUE(until([&] { return newest() && newest()->generation == generation; }));
    const int views = book.get(&Book::views);
    book.set(&Book::secondsPerPixel, 1e-2);  // light takes twenty seconds at least
    for (const double x : {2.0, 3.0, 4.0}) {
        order.camera.position.x = x;
        post();
        ASSERT_TRUE(until([&] { return newest()->generation == generation; })) << x;
        EXPECT_EQ(newest()->camera, order.camera);
        EXPECT_EQ(double(newest()->mean.pixels[0]), x);
        EXPECT_TRUE(newest()->preview);
        EXPECT_EQ(book.get(&Book::views), views + 1) << "one picture is under way";
    }
    book.set(&Book::secondsPerPixel, 0.0);
    order.moving = false;
    post();
    EXPECT_EQ(finished()->mean.pixels[0], 4.0f);
    EXPECT_FALSE(newest()->preview);
}

TEST_F(MovingOn, NotWhereSomethingElseDiffersToo)
{
    const std::vector<std::function<void()>> others{
        [&] { order.world = std::make_shared<core::World>(); },
        [&] { order.size.x = 600; },
        [&] { ++order.restarts; },
        [&] { order.wantAovs = true; },
        [&] { order.moving = false; },
    };
    size_t pictures = 0;
    for (const std::function<void()>& other : others) {
        order.moving = true;
        const auto picture = changedMeanwhile([&] {
            order.camera.position.x += 1;
            other();
        });
        if (!picture) continue;
        ++pictures;
        EXPECT_LT(picture->generation, generation);
        EXPECT_EQ(picture->camera, before.camera);
        EXPECT_EQ(double(picture->mean.pixels[0]), before.camera.position.x);
    }
    EXPECT_GE(pictures, 3u);
}

TEST_F(MovingOn, NorWherePathsAreWantedAsTheyCome)
{
    order.movingShows = app::Moving::path;
    const auto picture = changedMeanwhile([&] { order.camera.position.x = 5; });
    ASSERT_NE(picture, nullptr);
    EXPECT_LT(picture->generation, generation);
    EXPECT_EQ(picture->camera, before.camera);
    EXPECT_EQ(book.get(&Book::found), 0);
}

}  // namespace
