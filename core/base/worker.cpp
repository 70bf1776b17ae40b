// One thread, one job at a time, the newest wins. The lock is held for moments only: jobs run, and
// what they held is freed, outside of it and never on the thread that starts or cancels.
#include "core/base/worker.h"

#include <algorithm>
#include <exception>
#include <new>
#include <utility>
#include <vector>

#include <pthread.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "core/base/progress.h"
#include "core/base/time.h"

namespace core {

namespace {

/// Names this thread and lowers its priority; a system that refuses is not an error.
void configureThread(const std::string& name, int niceness)
{
    pthread_setname_np(pthread_self(), name.substr(0, 15).c_str());
    if (niceness == 0) return;
    const auto thread = static_cast<id_t>(syscall(SYS_gettid));  // Linux counts niceness per thread
    const int own = getpriority(PRIO_PROCESS, thread);
    setpriority(PRIO_PROCESS, thread, std::min(own + niceness, 19));
}

/// What a job says by the exception that it ends with.
std::string failureText(const std::exception_ptr& failure)
{
    try {
        std::rethrow_exception(failure);
    } catch (const std::bad_alloc&) {
        return "out of memory";
    } catch (const std::exception& e) {
        return e.what();
    } catch (...) {
        return "an unknown failure";
    }
}

}  // namespace

/// The job that runs. `abandoned` (cancelled or replaced): its end is not reported.
struct Worker::Running final : JobContext {
    uint64_t number = 0;
    std::string name;
    std::stop_source source;
    Clock::time_point start = Clock::now();
    bool abandoned = false;  // under the worker's lock

    mutable std::mutex mutex;  // of what follows
    std::string stage;
    double fraction = 0;

    uint64_t generation() const override { return number; }
    std::stop_token stop() const override { return source.get_token(); }
    void progress(const char* newStage, double newFraction) override
    {
        const std::lock_guard lock(mutex);
        if (stage != newStage) stage = newStage;
        fraction = newFraction == kUnknownShare ? kUnknownShare : std::clamp(newFraction, 0.0, 1.0);
    }
    JobStatus status(JobState state) const
    {
        const std::lock_guard lock(mutex);
        return {number, state, name, stage, fraction, secondsSince(start), {}};
    }
};

Worker::Worker(std::string name, int niceness)
    : niceness_(std::clamp(niceness, 0, 19)), name_(std::move(name)),
      thread_([this](std::stop_token stop) { loop(std::move(stop)); })
{}

Worker::~Worker()
{
    cancel();
    thread_.request_stop();
    thread_.join();
}

uint64_t Worker::start(std::string name, Job job)
{
    auto next = std::make_unique<Waiting>();
    next->name = std::move(name);
    next->job = std::move(job);
    std::shared_ptr<Running> old;
    uint64_t generation = 0;
    {
        const std::lock_guard lock(mutex_);
        next->generation = generation = ++generation_;
        old = running_;
        if (old) old->abandoned = true;
        if (waiting_) dropped_.push_back(std::move(waiting_));
        waiting_ = std::move(next);
        changed_.notify_all();
    }
    // Outside the lock: this may run callbacks that the job has registered with its token.
    if (old) old->source.request_stop();
    return generation;
}

void Worker::cancel()
{
    std::shared_ptr<Running> old;
    {
        const std::lock_guard lock(mutex_);
        old = running_;
        cancelAll();
    }
    if (old) old->source.request_stop();
}

void Worker::cancelAll()
{
    if (waiting_) {
        last_ = {waiting_->generation, JobState::cancelled, waiting_->name, {}, 0, 0, {}};
        dropped_.push_back(std::move(waiting_));
    } else if (running_ && !running_->abandoned) {
        last_ = running_->status(JobState::cancelled);
    }
    if (running_) running_->abandoned = true;
    changed_.notify_all();
}

JobStatus Worker::status() const
{
    const std::lock_guard lock(mutex_);
    if (waiting_) return {waiting_->generation, JobState::waiting, waiting_->name, {}, 0, 0, {}};
    if (running_ && !running_->abandoned) return running_->status(JobState::running);
    return last_;
}

void Worker::wait()
{
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !running_ && !waiting_ && dropped_.empty() && !freeing_; });
}

void Worker::loop(std::stop_token stop)
{
    configureThread(name_, niceness_);
    std::unique_lock lock(mutex_);
    for (;;) {
        changed_.wait(lock, stop, [this] { return waiting_ || !dropped_.empty(); });
        if (!dropped_.empty()) {
            std::vector<std::unique_ptr<Waiting>> dead;
            dead.swap(dropped_);
            freeing_ = true;
            lock.unlock();
            dead.clear();
            lock.lock();
            freeing_ = false;
            changed_.notify_all();
            continue;
        }
        if (stop.stop_requested()) return;
        run(lock, std::move(waiting_));
    }
}

void Worker::run(std::unique_lock<std::mutex>& lock, std::unique_ptr<Waiting> next)
{
    const auto running = std::make_shared<Running>();
    running->number = next->generation;
    running->name = next->name;
    running_ = running;
    lock.unlock();
    std::exception_ptr failure;
    try {
        next->job(*running);
    } catch (...) {
        failure = std::current_exception();
    }
    const bool failed = failure != nullptr;
    const std::string error = failed ? failureText(failure) : std::string();
    failure = nullptr;
    next.reset();  // what the job held is freed before its end is reported
    lock.lock();
    if (!running->abandoned) {
        last_ = running->status(failed ? JobState::failed : JobState::done);
        last_.error = error;
    }
    running_.reset();
    changed_.notify_all();
}

}  // namespace core
