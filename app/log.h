// What the program tells a person while it works: lines on stderr, progress at most once a second.
#pragma once

#include <chrono>
#include <mutex>
#include <string>

#include "core/renderer.h"

namespace app {

/// Lines on stderr; stdout belongs to results. Safe to call from several threads.
class Log {
public:
    /// `quiet` leaves out everything but warnings.
    explicit Log(bool quiet) : quiet_(quiet) {}

    /// A line of news.
    void line(const std::string& text);

    /// Something that the person should know even when quiet.
    void warning(const std::string& text);

    /// How far `stage` is, in [0,1]. Says nothing in a stage's first half second, nor twice within
    /// a second.
    void progress(const char* stage, double fraction);

    /// Progress in words of its own, at most once a second.
    void progressText(const std::string& text);

    /// `progress` as renderers and loaders take it.
    core::Progress callback();

private:
    using Clock = std::chrono::steady_clock;

    bool mayPrint(Clock::time_point now) const;

    const bool quiet_;
    std::mutex mutex_;
    std::string stage_;
    Clock::time_point stageStart_{}, lastProgress_{};
};

}  // namespace app
