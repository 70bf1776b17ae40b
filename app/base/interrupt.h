// Ctrl-C as a stop token: what was rendered so far is kept.
#pragma once

#include <atomic>
#include <csignal>
#include <stop_token>
#include <thread>

namespace app {

/// While one exists, SIGINT, SIGTERM and SIGHUP (unless it is ignored, as after nohup) stop the
/// work in order. Construct it before other threads start: they inherit the blocked signals. A
/// signal that arrives while there is no result to keep, or a second one, ends the program at once
/// with exit code 130.
class Interrupt {
public:
    Interrupt();
    ~Interrupt();
    Interrupt(const Interrupt&) = delete;
    Interrupt& operator=(const Interrupt&) = delete;

    /// Stopped by a signal.
    std::stop_token token() const { return source_.get_token(); }
    bool requested() const { return source_.stop_requested(); }

    /// Whether there is now a result that a signal must not lose.
    void keepResult(bool keep) { keep_ = keep; }

private:
    void wait();

    std::stop_source source_;
    std::atomic<bool> keep_{false}, ending_{false};
    sigset_t signals_{}, previous_{};
    std::thread thread_;
};

}  // namespace app
