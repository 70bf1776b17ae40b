// Messages to the user while the program works: lines on stderr. Progress is a bar that stays in
// its place on a terminal, and a line at most once a second elsewhere.
#pragma once

#include <chrono>
#include <mutex>
#include <string>

#include "core/base/progress.h"

namespace app {

/// Lines on stderr; stdout belongs to results. Safe to call from several threads.
class Log {
public:
    /// `quiet` leaves out everything but warnings. `terminal`: stderr can rewrite its last line.
    explicit Log(bool quiet, bool terminal = onTerminal()) : quiet_(quiet), terminal_(terminal) {}
    ~Log();
    Log(const Log&) = delete;
    Log& operator=(const Log&) = delete;

    /// Whether stderr is a terminal that understands the usual escapes.
    static bool onTerminal();

    /// One line of information.
    void line(const std::string& text);

    /// A warning, printed even when quiet.
    void warning(const std::string& text);

    /// Progress of `stage`, in [0,1]. Prints nothing during a stage's first half second, and no
    /// more often than a person can read.
    void progress(const char* stage, double fraction);

    /// Progress as a text.
    void progressText(const std::string& text);

    /// `progress` as the callback of renderers and loaders.
    core::Progress callback();

private:
    using Clock = std::chrono::steady_clock;

    bool mayShow(Clock::time_point now) const;
    void print(const std::string& text);
    void show(const std::string& progress);
    void clearBar();

    const bool quiet_, terminal_;
    bool barShown_ = false;
    std::mutex mutex_;
    std::string stage_;
    Clock::time_point stageStart_{}, lastProgress_{};
};

}  // namespace app
