// Lines on stderr. See log.h.
#include "app/log.h"

#include <algorithm>
#include <cstdio>

namespace app {

static constexpr std::chrono::milliseconds kSilentStart{500};
static constexpr std::chrono::seconds kBetweenLines{1};

static void print(const std::string& text)
{
    // One call per line, so that lines of several threads or processes do not mix.
    const std::string whole = text + '\n';
    std::fputs(whole.c_str(), stderr);
}

void Log::line(const std::string& text)
{
    if (quiet_) return;
    const std::lock_guard lock(mutex_);
    print(text);
}

void Log::warning(const std::string& text)
{
    const std::lock_guard lock(mutex_);
    print("warning: " + text);
}

bool Log::mayPrint(Clock::time_point now) const
{
    return !quiet_ && now - lastProgress_ >= kBetweenLines;
}

void Log::progress(const char* stage, double fraction)
{
    const std::lock_guard lock(mutex_);
    const Clock::time_point now = Clock::now();
    if (stage_ != stage) {
        stage_ = stage;
        stageStart_ = now;
    }
    if (now - stageStart_ < kSilentStart || !mayPrint(now)) return;
    lastProgress_ = now;
    char percent[16];
    std::snprintf(percent, sizeof percent, "%.0f %%", 100 * std::clamp(fraction, 0.0, 1.0));
    print(stage_ + ": " + percent);
}

void Log::progressText(const std::string& text)
{
    const std::lock_guard lock(mutex_);
    const Clock::time_point now = Clock::now();
    if (!mayPrint(now)) return;
    lastProgress_ = now;
    print(text);
}

core::Progress Log::callback()
{
    return [this](const char* stage, double fraction) { progress(stage, fraction); };
}

}  // namespace app
