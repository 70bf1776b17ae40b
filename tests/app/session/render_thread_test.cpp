// The render thread with pretended renderers, so that every rule can be observed: what restarts,
// what is stopped, what is published, limits, failures, ends. Then with the real ones: the picture
// is that of a direct render, bit by bit.
#include <atomic>
#include <chrono>
#include <cmath>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <new>
#include <random>

#include <gtest/gtest.h>

#include "app/session/error_point.h"
#include "app/session/render_thread.h"
#include "core/base/check.h"
#include "core/gltf/gltf.h"
#include "core/methods/method.h"
#include "tests/support/fake_estimate.h"

namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

/// What the pretended renderers of a test have done and will do. Shared with the render thread: all
/// under the lock.
struct Book {
    mutable std::mutex mutex;
    int made = 0, worlds = 0, views = 0, advances = 0;
    const core::World* world = nullptr;  // held by the newest renderer
    core::Pace pace;
    core::Start start = core::Start::anew;  // of the newest view
    std::vector<glm::uvec2> sizes;          // of every view
    double secondsPerPixel = 0;             // of a sample; 0: at once
    std::deque<std::function<void()>> atMake, atWorld,
        atAdvance;              // the next calls do these; empty ones do nothing
    bool endlessWorld = false;  // setWorld goes on until it is told to end

    void count(int Book::*what, std::deque<std::function<void()>> Book::*plan = nullptr)
    {
        std::function<void()> next;
        {
            const std::lock_guard lock(mutex);
            ++(this->*what);
            if (plan != nullptr && !(this->*plan).empty()) {
                next = std::move((this->*plan).front());
                (this->*plan).pop_front();
            }
        }
        if (next) next();
    }
    template <class T> T get(T Book::*what) const
    {
        const std::lock_guard lock(mutex);
        return this->*what;
    }
    template <class T> void set(T Book::*what, T value)
    {
        const std::lock_guard lock(mutex);
        this->*what = std::move(value);
    }
};

/// Every pixel is the camera's x; every sample has a variance of 1.
class Pretender : public core::Renderer {
public:
    explicit Pretender(Book& book) : book_(book) { book_.count(&Book::made, &Book::atMake); }
    void setWorld(std::shared_ptr<const core::World> world, const core::Progress& progress) override
    {
        book_.set<const core::World*>(&Book::world, nullptr);
        book_.count(&Book::worlds, &Book::atWorld);
        while (book_.get(&Book::endlessWorld)) {
            progress("building", 0.5);
            std::this_thread::sleep_for(1ms);
        }
        book_.set<const core::World*>(&Book::world, world.get());
        world_ = std::move(world);
    }
    void setView(const core::View& view, core::Start start) override
    {
        book_.count(&Book::views);
        const std::lock_guard lock(book_.mutex);
        book_.sizes.push_back(view.size);
        book_.start = start;
        size_ = view.size;
        samples_ = 0;
        done_ = 0;
        ++version_;
        value_ = static_cast<float>(view.camera.position.x);
    }
    void setPace(const core::Pace& pace) override { book_.set(&Book::pace, pace); }
    void advance(const core::Budget& budget, std::stop_token stop) override
    {
        book_.count(&Book::advances, &Book::atAdvance);
        const auto start = Clock::now();
        const uint64_t wanted = samples_ + std::max(budget.samples, done_ > 0 ? 1u : 0u);
        while (samples_ < wanted && !stop.stop_requested()) {
            const double each = book_.get(&Book::secondsPerPixel) * size_.x * size_.y;
            if (each > 0) {
                std::this_thread::sleep_for(200us);
                done_ += 2e-4 / each;
            }
            ++version_;
            if (each == 0 || done_ >= 1) {
                ++samples_;
                done_ = 0;
            }
            if (std::chrono::duration<double>(Clock::now() - start).count() >= budget.seconds)
                break;
        }
    }
    core::RenderProgress progress() const override { return {version_, samples_, done_}; }
    core::Estimate read(core::Reading) override
    {
        const float n = static_cast<float>(samples_);
        core::Estimate e =
            tests::flatEstimate(size_, value_, samples_ > 1 ? 1 / (n - 1) : 0, samples_);
        if (samples_ == 0) {  // of the first sample the upper part has been done
            for (size_t i = 0; i < e.weight.pixels.size(); ++i) {
                const bool known = double(i) < done_ * double(e.weight.pixels.size());
                e.weight.pixels[i] = known ? 1.0f : 0.0f;
                if (!known) std::fill_n(&e.mean.pixels[3 * i], 3, 0.0f);
            }
        }
        return e;
    }
    core::Aovs aovs() override
    {
        core::Aovs aovs;
        aovs.depth = core::Image(size_.x, size_.y, 1);
        return aovs;
    }
    core::RenderStats stats() const override { return {}; }

private:
    Book& book_;
    std::shared_ptr<const core::World> world_;
    glm::uvec2 size_{0};
    uint64_t samples_ = 0, version_ = 0;
    double done_ = 0;  // of the next sample
    float value_ = 0;
};

class RenderThread : public testing::Test {
protected:
    RenderThread()
    {
        order.world = std::make_shared<core::World>();
        order.size = {32, 16};
        order.camera.position.x = 1;
        order.params.device = app::DeviceKind::cpu;
        order.params.sppLimit = 4;
    }
    uint64_t post() { return generation = thread->request(order); }
    std::shared_ptr<const app::Picture> newest() const { return thread->newest(); }

    /// Waits for a picture of the last order that is finished.
    std::shared_ptr<const app::Picture> finished()
    {
        EXPECT_TRUE(until([&] {
            const auto p = newest();
            return p && p->generation == generation && p->finished;
        })) << thread->status().error;
        return newest();
    }
    bool until(const std::function<bool()>& condition) const
    {
        for (const auto end = Clock::now() + 20s; Clock::now() < end;
             std::this_thread::sleep_for(500us)) {
            if (condition()) return true;
        }
        return false;
    }
    void start()
    {
        thread = std::make_unique<app::RenderThread>(
            [this](const app::RenderParams&, bool) { return std::make_unique<Pretender>(book); });
    }
    /// What has been done since the last call: renderers made, worlds and views set.
    std::array<int, 3> work()
    {
        const std::lock_guard lock(book.mutex);
        const std::array<int, 3> now{book.made, book.worlds, book.views};
        const std::array<int, 3> since{now[0] - before_[0], now[1] - before_[1],
                                       now[2] - before_[2]};
        before_ = now;
        return since;
    }

    Book book;
    app::RenderRequest order;
    uint64_t generation = 0;
    std::unique_ptr<app::RenderThread> thread;  // ends before the book

private:
    std::array<int, 3> before_{};
};

using Work = std::array<int, 3>;

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
    const int advances = book.get(&Book::advances);
    std::this_thread::sleep_for(30ms);
    EXPECT_EQ(book.get(&Book::advances), advances);
    EXPECT_EQ(newest(), picture);
}

TEST_F(RenderThread, WithoutASceneNothingHappens)
{
    start();
    order.world = nullptr;
    post();
    std::this_thread::sleep_for(20ms);
    EXPECT_EQ(work(), (Work{0, 0, 0}));
    EXPECT_EQ(newest(), nullptr);
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

TEST_F(RenderThread, PartsOfASlowSampleAreNews)
{
    order.params.sppLimit = 1;
    order.size = {256, 256};  // so large that a small picture comes first
    start();
    book.set(&Book::secondsPerPixel, 2.5 / (256 * 256));
    post();
    ASSERT_TRUE(
        until([&] { return newest() && newest()->samples == 0 && newest()->fraction > 0; }));
    const auto part = newest();
    EXPECT_TRUE(part->preview);
    EXPECT_EQ(part->mean.width, 256u);
    // What has not been rendered yet shows the small picture.
    for (const float value : part->mean.pixels) ASSERT_EQ(value, 1.0f);
    ASSERT_TRUE(until([&] { return newest()->fraction > part->fraction; }));
    EXPECT_EQ(newest()->samples, 0u);
    EXPECT_EQ(finished()->samples, 1u);
    EXPECT_EQ(newest()->fraction, 0);
    EXPECT_FALSE(newest()->preview);
    EXPECT_EQ(book.get(&Book::views), 2);  // the small one and the full one
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

TEST_F(RenderThread, WhileTheCameraMovesPicturesAreSmallAndNoneIsLost)
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
    EXPECT_GT(thread->status().previewSeconds, 0);
    EXPECT_NEAR(double(thread->status().previewScale), last.x / 640.0, 0.01);

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

TEST_F(RenderThread, ASlowPictureIsPrecededByACoarseOne)
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

// --- failures

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

TEST_F(RenderThread, EndsSoonWhateverItDoes)
{
    for (const bool building : {true, false}) {
        start();
        book.set(&Book::endlessWorld, building);
        book.set(&Book::secondsPerPixel, 1.0);
        const int worlds = book.get(&Book::worlds), advances = book.get(&Book::advances);
        post();
        ASSERT_TRUE(until([&] {
            return building ? book.get(&Book::worlds) > worlds
                            : book.get(&Book::advances) > advances;
        }));
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
        switch (random() % 12) {
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

// --- the real ones

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

    const auto renderer = app::makeViewRenderer(order.params, false);
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
