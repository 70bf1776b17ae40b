// A clock for what must happen in real time on a machine that has other work to do, too: it passes
// as fast as this process gets to run.
#pragma once

#include <chrono>
#include <map>

namespace app {

/// Of the time in which its threads wanted to run, a process gets a share; a second of this clock
/// is as long as it takes to have what an undisturbed second has. The share is that of about the
/// last half second, from Linux' statistics of scheduling; 1 where there are none.
class SlowedClock {
public:
    using Clock = std::chrono::steady_clock;

    SlowedClock() { look(); }

    /// Seconds of this clock since the last call.
    double tick();

    double share() const { return share_; }

private:
    struct Times {
        double run = 0, wait = 0;
    };

    void look();

    Clock::time_point last_ = Clock::now(), looked_ = last_;
    std::map<long, Times> threads_;  // as they were when they were looked at
    Times recent_;
    double share_ = 1;
};

}  // namespace app
