// The render thread with pretended renderers, whose every step a test can plan and observe.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

#include <gtest/gtest.h>

#include "app/pictures/render_thread.h"
#include "core/methods/first_hits.h"
#include "tests/support/methods/fake_estimate.h"

namespace tests {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

/// What the pretended renderers of a test have done and will do. Shared with the render thread: all
/// under the lock.
struct Book {
    mutable std::mutex mutex;
    int made = 0, worlds = 0, preparations = 0, views = 0, advances = 0;
    int pictures = 0;                    // that were announced
    int found = 0;                       // first hits of a size of their own
    const core::World* world = nullptr;  // held by the newest renderer
    core::Pace pace;
    core::Start start = core::Start::anew;  // of the newest view
    core::AnyParams params;                 // of the newest view
    std::vector<glm::uvec2> sizes;          // of every view
    std::vector<core::Sight> sights;        // of all surfaces that were asked for
    double secondsPerPixel = 0;             // of a sample; 0: at once
    std::deque<std::function<void()>> atMake, atWorld,
        atAdvance;              // the next calls do these; empty ones do nothing
    bool endlessWorld = false;  // setWorld goes on until it is told to end
    bool endlessPrepare = false;
    bool looks = false;  // first hits can be had before a picture

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
    void then(std::deque<std::function<void()>> Book::*plan, std::function<void()> what)
    {
        const std::lock_guard lock(mutex);
        (this->*plan).push_back(std::move(what));
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

/// Every pixel is the camera's x, and shines by itself; every sample has a variance of 1.
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
    void prepare(const core::AnyParams&, const core::Progress& progress) override
    {
        book_.count(&Book::preparations);
        while (book_.get(&Book::endlessPrepare)) {
            progress("preparing", 0.25);
            std::this_thread::sleep_for(1ms);
        }
    }
    std::optional<core::Aovs> look(const core::View& view) override
    {
        if (!book_.get(&Book::looks)) return std::nullopt;
        const glm::uvec2 s = view.size;
        return core::Aovs{core::Image(s.x, s.y, 1), core::Image(s.x, s.y, 3),
                          core::Image(s.x, s.y, 3), core::Image(s.x, s.y, 3),
                          core::Image(s.x, s.y, 3)};
    }
    void setView(const core::View& view, core::Start start) override
    {
        book_.count(&Book::views);
        const std::lock_guard lock(book_.mutex);
        book_.sizes.push_back(view.size);
        book_.params = view.params;
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
        core::Estimate e = flatEstimate(size_, value_, samples_ > 1 ? 1 / (n - 1) : 0, samples_);
        if (samples_ == 0) {  // of the first sample the upper part has been done
            for (size_t i = 0; i < e.weight.pixels.size(); ++i) {
                const bool known = double(i) < done_ * double(e.weight.pixels.size());
                e.weight.pixels[i] = known ? 1.0f : 0.0f;
                if (!known) std::fill_n(&e.mean.pixels[3 * i], 3, 0.0f);
            }
        }
        return e;
    }
    core::Aovs aovs() override { return core::emptyAovs(size_.x, size_.y); }
    core::Aovs surfaces(const core::Camera& camera, glm::uvec2 size, core::Sight sight) override
    {
        {
            const std::lock_guard lock(book_.mutex);
            book_.sights.push_back(sight);
        }
        if (size != size_) book_.count(&Book::found);
        core::Aovs aovs = core::emptyAovs(size.x, size.y);
        std::ranges::fill(aovs.emission.pixels, static_cast<float>(camera.position.x));
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
            [this](const app::RenderParams&, bool) { return std::make_unique<Pretender>(book); },
            [this] {
                const std::lock_guard lock(book.mutex);
                ++book.pictures;
            });
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

}  // namespace tests
