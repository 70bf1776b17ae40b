// Ctrl-C as a stop token: what was rendered so far is kept.
#pragma once

#include <atomic>
#include <csignal>
#include <stop_token>
#include <thread>

namespace app {

/// While one exists, SIGINT and SIGTERM stop the work politely. Make it before other threads are
/// made: they inherit the blocked signals. A signal that comes while nothing worth keeping exists,
/// or a second one, ends the program at once with exit code 130.
class Interrupt {
public:
    Interrupt();
    ~Interrupt();
    Interrupt(const Interrupt&) = delete;
    Interrupt& operator=(const Interrupt&) = delete;

    /// Stops when a signal has come.
    std::stop_token token() const { return source_.get_token(); }
    bool requested() const { return source_.stop_requested(); }

    /// From here on there is a result that a signal must not lose (true), or no longer (false).
    void keepResult(bool keep) { keep_ = keep; }

private:
    void wait();

    std::stop_source source_;
    std::atomic<bool> keep_{false}, ending_{false};
    sigset_t signals_{}, previous_{};
    std::thread thread_;
};

}  // namespace app
