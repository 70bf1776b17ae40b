// The core thread: order, cancelling, replacing, failures, shutdown, and that no result of an old
// job is ever taken for one of a new one.
#include <atomic>
#include <chrono>
#include <new>
#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "core/base/check.h"
#include "core/base/progress.h"
#include "core/base/worker.h"

namespace {

using core::JobContext;
using core::JobState;
using core::JobStatus;
using core::Worker;
using namespace std::chrono_literals;

double secondsOf(const std::function<void()>& body)
{
    const auto start = std::chrono::steady_clock::now();
    body();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// A gate that is opened once.
class Gate {
public:
    void open()
    {
        open_ = true;
        open_.notify_all();
    }
    void pass() const { open_.wait(false); }

private:
    std::atomic<bool> open_ = false;
};

void runUntilStopped(JobContext& job)
{
    while (!job.stopped()) std::this_thread::sleep_for(1ms);
}

TEST(Worker, RunsAJobAndSaysSo)
{
    Worker worker("test");
    EXPECT_EQ(worker.status().state, JobState::idle);
    EXPECT_EQ(worker.status().generation, 0u);
    EXPECT_FALSE(worker.status().active());
    Gate told, goOn;
    std::thread::id thread;
    const uint64_t generation = worker.start("count", [&](JobContext& job) {
        EXPECT_EQ(job.generation(), 1u);
        thread = std::this_thread::get_id();
        job.progress("first", core::kUnknownShare);
        EXPECT_EQ(worker.status().fraction, core::kUnknownShare);
        job.progress("second", 1.5);
        told.open();
        goOn.pass();
    });
    EXPECT_EQ(generation, 1u);
    told.pass();
    const JobStatus status = worker.status();
    EXPECT_EQ(status.state, JobState::running);
    EXPECT_TRUE(status.active());
    EXPECT_EQ(status.name, "count");
    EXPECT_EQ(status.stage, "second");
    EXPECT_EQ(status.fraction, 1);
    goOn.open();
    worker.wait();
    EXPECT_EQ(worker.status().state, JobState::done);
    EXPECT_EQ(worker.status().generation, 1u);
    EXPECT_EQ(worker.status().name, "count");
    EXPECT_GE(worker.status().seconds, status.seconds);
    EXPECT_NE(thread, std::this_thread::get_id());
}

TEST(Worker, JobsRunOneAfterTheOtherOnOneThread)
{
    Worker worker("test");
    std::set<std::thread::id> threads;
    std::vector<int> order;  // no lock: ThreadSanitizer would see two at once
    for (int i = 0; i < 20; ++i) {
        worker.start("step", [&, i](JobContext&) {
            order.push_back(i);
            threads.insert(std::this_thread::get_id());
        });
        worker.wait();
    }
    EXPECT_EQ(threads.size(), 1u);
    ASSERT_EQ(order.size(), 20u);
    for (int i = 0; i < 20; ++i) EXPECT_EQ(order[size_t(i)], i);
}

TEST(Worker, TheNewestReplacesWhatRunsAndWhatWaits)
{
    Worker worker("test");
    Gate begun, goOn;
    std::atomic<bool> firstStopped = false, secondRan = false, thirdRan = false;
    worker.start("first", [&](JobContext& job) {
        begun.open();
        goOn.pass();
        firstStopped = job.stopped();
    });
    begun.pass();
    worker.start("second", [&](JobContext&) { secondRan = true; });
    EXPECT_EQ(worker.status().state, JobState::waiting);
    EXPECT_EQ(worker.status().name, "second");
    const uint64_t last = worker.start("third", [&](JobContext&) { thirdRan = true; });
    EXPECT_EQ(worker.status().generation, last);
    goOn.open();
    worker.wait();
    EXPECT_TRUE(firstStopped);
    EXPECT_FALSE(secondRan);
    EXPECT_TRUE(thirdRan);
    EXPECT_EQ(worker.status().generation, last);
    EXPECT_EQ(worker.status().state, JobState::done);
}

TEST(Worker, CancelShowsAtOnceAlthoughTheJobGoesOn)
{
    Worker worker("test");
    Gate begun, goOn;
    worker.start("long", [&](JobContext& job) {
        job.progress("stage", 0.5);
        begun.open();
        goOn.pass();
        throw core::Error("cancelled", core::ExitCode::interrupted);
    });
    begun.pass();
    worker.cancel();
    EXPECT_EQ(worker.status().state, JobState::cancelled);
    EXPECT_FALSE(worker.status().active());
    EXPECT_EQ(worker.status().stage, "stage");
    std::atomic<bool> ran = false;
    worker.start("waiting", [&](JobContext&) { ran = true; });
    worker.cancel();
    EXPECT_EQ(worker.status().state, JobState::cancelled);
    EXPECT_EQ(worker.status().generation, 2u);
    goOn.open();
    worker.wait();
    EXPECT_FALSE(ran);
    EXPECT_EQ(worker.status().state, JobState::cancelled) << "how it ended is of no interest";
    EXPECT_EQ(worker.status().generation, 2u);
    worker.cancel();  // of nothing
    EXPECT_EQ(worker.status().state, JobState::cancelled);
}

TEST(Worker, FailuresAreToldAndTheNextJobRuns)
{
    Worker worker("test");
    const auto failure = [&](const Worker::Job& job) {
        worker.start("fails", job);
        worker.wait();
        EXPECT_EQ(worker.status().state, JobState::failed);
        return worker.status().error;
    };
    EXPECT_EQ(failure([](JobContext&) { throw core::Error("box.gltf: /nodes: no"); }),
              "box.gltf: /nodes: no");
    EXPECT_EQ(failure([](JobContext&) { throw std::bad_alloc(); }), "out of memory");
    EXPECT_EQ(failure([](JobContext&) { throw std::out_of_range("beyond"); }), "beyond");
    EXPECT_FALSE(failure([](JobContext&) { throw 7; }).empty());
    std::atomic<bool> ran = false;
    worker.start("works", [&](JobContext&) { ran = true; });
    worker.wait();
    EXPECT_TRUE(ran);
    EXPECT_EQ(worker.status().state, JobState::done);
    EXPECT_TRUE(worker.status().error.empty());
}

TEST(Worker, EndsSoonWhileAJobRuns)
{
    std::atomic<bool> ended = false;
    const double seconds = secondsOf([&] {
        Gate begun;
        Worker worker("test");
        worker.start("endless", [&](JobContext& job) {
            begun.open();
            runUntilStopped(job);
            ended = true;
        });
        begun.pass();
        worker.start("never", [](JobContext& job) { runUntilStopped(job); });
    });
    EXPECT_TRUE(ended);
    EXPECT_LT(seconds, 1);
}

TEST(Worker, WhatAJobHeldIsFreedByTheThread)
{
    struct Held {
        explicit Held(std::atomic<int>* count) : freed(count) {}
        std::atomic<int>* freed;
        std::thread::id starter = std::this_thread::get_id();
        ~Held()
        {
            EXPECT_NE(std::this_thread::get_id(), starter);
            ++*freed;
        }
    };
    std::atomic<int> freed = 0;
    Worker worker("test");
    Gate begun;
    worker.start("holds", [held = std::make_shared<Held>(&freed), &begun](JobContext& job) {
        begun.open();
        runUntilStopped(job);
    });
    begun.pass();
    worker.start("replaced", [held = std::make_shared<Held>(&freed)](JobContext&) {});
    worker.start("cancelled", [held = std::make_shared<Held>(&freed)](JobContext&) {});
    worker.cancel();
    worker.wait();
    EXPECT_EQ(freed, 3);
}

TEST(Worker, GivesWay)
{
    const auto niceness = [] {
        return getpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)));
    };
    const int own = niceness();
    int seen = -100;
    Worker worker("test", 3);
    worker.start("look", [&](JobContext&) { seen = niceness(); });
    worker.wait();
    EXPECT_EQ(seen, std::min(own + 3, 19));
    EXPECT_EQ(niceness(), own);
}

TEST(Mailbox, OldGenerationsAreDropped)
{
    core::Mailbox<int> box;
    uint64_t generation = 99;
    EXPECT_EQ(box.newest(&generation), nullptr);
    EXPECT_EQ(generation, 0u);
    box.publish(2, std::make_shared<int>(20));
    box.publish(1, std::make_shared<int>(10));
    EXPECT_EQ(box.get(1), nullptr);
    EXPECT_EQ(*box.get(2), 20);
    box.publish(2, std::make_shared<int>(21));
    EXPECT_EQ(*box.get(2), 21);
    EXPECT_EQ(box.get(3), nullptr);
    EXPECT_EQ(*box.newest(&generation), 21);
    EXPECT_EQ(generation, 2u);
}

/// A value that knows what job made it.
struct JobResult {
    uint64_t generation = 0;
    int part = 0;
};

TEST(Worker, NoStaleResultInTenThousandRandomSteps)
{
    core::Mailbox<JobResult> box;
    Worker worker("test");
    std::mt19937 random(7);
    uint64_t newest = 0, taken = 0, lastPart = 0, cancelled = 0;
    for (int step = 0; step < 10000; ++step) {
        const auto dice = static_cast<uint32_t>(random() % 10);
        if (dice < 4) {
            const int parts = static_cast<int>(random() % 4);
            const auto work = static_cast<uint32_t>(random() % 200);
            newest = worker.start("job", [&box, parts, work](JobContext& job) {
                for (int part = 1; part <= parts && !job.stopped(); ++part) {
                    for (uint32_t i = 0; i < work && !job.stopped(); ++i)
                        job.progress("stage", i / 200.0);
                    box.publish(job.generation(),
                                std::make_shared<JobResult>(JobResult{job.generation(), part}));
                }
                if (work % 50 == 0) throw core::Error("no");
            });
            lastPart = 0;
            ASSERT_EQ(worker.status().generation, newest);
        } else if (dice < 6) {
            worker.cancel();
            ++cancelled;
            ASSERT_FALSE(worker.status().active());
        } else if (dice == 6) {
            std::this_thread::sleep_for(20us);
        } else {
            const auto result = box.get(newest);
            if (!result) continue;
            ++taken;
            ASSERT_EQ(result->generation, newest);
            ASSERT_GE(uint64_t(result->part), lastPart);  // never backwards
            lastPart = uint64_t(result->part);
        }
        const JobStatus status = worker.status();
        ASSERT_EQ(status.generation, newest);
    }
    EXPECT_GT(taken, 100u);
    EXPECT_GT(cancelled, 1000u);
    const uint64_t last = worker.start("last", [&](JobContext& job) {
        box.publish(job.generation(), std::make_shared<JobResult>(JobResult{job.generation(), 1}));
    });
    worker.wait();
    ASSERT_NE(box.get(last), nullptr);
}

}  // namespace
