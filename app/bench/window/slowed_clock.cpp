// See slowed_clock.h. /proc/self/task/ID/schedstat holds nanoseconds on a core and nanoseconds of
// waiting for one.
#include "app/bench/window/slowed_clock.h"

#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/base/time.h"

namespace app {

namespace {

constexpr double kLookSeconds = 0.05;   // between two looks
constexpr double kMemorySeconds = 0.5;  // after which a look counts for a third
constexpr double kLeastShare = 0.02;

}  // namespace

double SlowedClock::tick()
{
    const double seconds = core::secondsSince(last_);
    last_ = Clock::now();
    if (core::secondsSince(looked_) >= kLookSeconds) look();
    return share_ * seconds;
}

void SlowedClock::look()
{
    const double keep = std::exp(-core::secondsSince(looked_) / kMemorySeconds);
    looked_ = Clock::now();
    recent_.run *= keep;
    recent_.wait *= keep;
    std::map<long, Times> threads;
    std::error_code error;
    for (const auto& task : std::filesystem::directory_iterator("/proc/self/task", error)) {
        std::ifstream file(task.path() / "schedstat");
        Times now;
        // A thread that has ended in the meantime has nothing to tell.
        if (!(file >> now.run >> now.wait)) continue;
        const long id = std::strtol(task.path().filename().c_str(), nullptr, 10);
        threads[id] = now;
        const auto before = threads_.find(id);
        if (before == threads_.end()) continue;
        recent_.run += now.run - before->second.run;
        recent_.wait += now.wait - before->second.wait;
    }
    threads_ = std::move(threads);
    const double wanted = recent_.run + recent_.wait;
    share_ = wanted > 0 ? std::max(recent_.run / wanted, kLeastShare) : 1;
}

}  // namespace app
