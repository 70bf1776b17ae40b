// The core thread: one background thread that does one job at a time. A job is given what it needs
// as immutable snapshots, reports its progress, and hands out results through mailboxes; the thread
// that started it never waits.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

namespace core {

/// The newest value of one producer with the generation that it belongs to. Safe from any thread;
/// holds its lock for the swap of a pointer only.
template <class T> class Mailbox {
public:
    /// Values of generations older than the newest published one are dropped.
    void publish(uint64_t generation, std::shared_ptr<const T> value)
    {
        const std::lock_guard lock(mutex_);
        if (generation < generation_) return;
        generation_ = generation;
        value_.swap(value);  // the old value dies after the lock
    }

    /// The value, when it is of `generation`; otherwise none. It stays in the box.
    std::shared_ptr<const T> get(uint64_t generation) const
    {
        const std::lock_guard lock(mutex_);
        return generation == generation_ ? value_ : nullptr;
    }

    /// The newest value of all, and its generation.
    std::shared_ptr<const T> newest(uint64_t* generation = nullptr) const
    {
        const std::lock_guard lock(mutex_);
        if (generation != nullptr) *generation = generation_;
        return value_;
    }

private:
    mutable std::mutex mutex_;
    uint64_t generation_ = 0;
    std::shared_ptr<const T> value_;
};

enum class JobState { idle, waiting, running, done, failed, cancelled };

struct JobStatus {
    uint64_t generation = 0;  // of the job that this is about; 0: there has been none
    JobState state = JobState::idle;
    std::string name, stage;
    double fraction = 0;  // of the stage, in [0,1], or kUnknownShare
    double seconds = 0;   // since it began to run; of all its run once it has ended
    std::string error;    // message of a failed job

    bool active() const { return state == JobState::waiting || state == JobState::running; }
};

/// What a job can query and report. Lives as long as the job runs.
class JobContext {
public:
    virtual ~JobContext() = default;
    virtual uint64_t generation() const = 0;
    virtual std::stop_token stop() const = 0;
    bool stopped() const { return stop().stop_requested(); }

    /// Cheap enough to be called for every row of an image; `stage` is copied.
    virtual void progress(const char* stage, double fraction) = 0;
};

class Worker {
public:
    using Job = std::function<void(JobContext&)>;

    /// `niceness` is added to the thread's own (Linux; threads that it makes inherit it): 0 to 19.
    explicit Worker(std::string name, int niceness = 0);

    /// Asks the job to stop and waits for the thread's end.
    ~Worker();
    Worker(const Worker&) = delete;
    Worker& operator=(const Worker&) = delete;

    /// Runs `job` as soon as the thread is free. What runs is asked to stop, what waits is dropped.
    /// Returns the job's generation (1, 2, ...). Never blocks.
    uint64_t start(std::string name, Job job);

    /// Asks the job to stop and drops what waits; the status says "cancelled" from now on.
    void cancel();

    JobStatus status() const;

    /// Waits until nothing runs or waits. For tests and for the end of commands; never for a
    /// window's loop.
    void wait();

private:
    struct Running;
    struct Waiting {
        uint64_t generation = 0;
        std::string name;
        Job job;
    };
    void loop(std::stop_token stop);
    void cancelAll();
    void run(std::unique_lock<std::mutex>& lock, std::unique_ptr<Waiting> next);

    mutable std::mutex mutex_;
    std::condition_variable_any changed_;
    std::shared_ptr<Running> running_;
    std::unique_ptr<Waiting> waiting_;
    // Never began; freed by the thread, as a job may hold much
    std::vector<std::unique_ptr<Waiting>> dropped_;
    bool freeing_ = false;
    JobStatus last_;
    uint64_t generation_ = 0;
    int niceness_;
    std::string name_;
    std::jthread thread_;  // last: ends before what it uses
};

}  // namespace core
