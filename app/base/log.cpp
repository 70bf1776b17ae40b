// Lines and a bar on stderr. See log.h.
#include "app/base/log.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <unistd.h>

#include "core/base/text.h"

namespace app {

namespace {

constexpr std::chrono::milliseconds kSilentStart{500};
constexpr std::chrono::milliseconds kBetweenLines{1000}, kBetweenBars{100};

/// One call per text, so that those of several threads or processes do not mix.
void write(const std::string& text)
{
    std::fputs(text.c_str(), stderr);
}

std::string wholePercent(double fraction)
{
    char text[16];
    std::snprintf(text, sizeof text, "%.0f %%", 100 * fraction);
    return text;
}

std::string bar(double fraction)
{
    constexpr int kWidth = 30;
    const int filled = static_cast<int>(fraction * kWidth + 0.5);
    std::string text;
    for (int i = 0; i < kWidth; ++i) text += i < filled ? "█" : "░";
    return text;
}

}  // namespace

bool Log::onTerminal()
{
    const char* kind = std::getenv("TERM");
    return isatty(STDERR_FILENO) && kind && std::strcmp(kind, "dumb") != 0;
}

Log::~Log()
{
    clearBar();
}

void Log::clearBar()
{
    if (barShown_) write("\r\033[K");
    barShown_ = false;
}

void Log::print(const std::string& text)
{
    clearBar();
    write(core::printableLines(text) + '\n');
}

/// On a terminal this replaces the text shown before, without a new line.
void Log::show(const std::string& progress)
{
    if (!terminal_) return print(progress);
    write("\r" + progress + "\033[K");
    std::fflush(stderr);
    barShown_ = true;
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

bool Log::mayShow(Clock::time_point now) const
{
    return !quiet_ && now - lastProgress_ >= (terminal_ ? kBetweenBars : kBetweenLines);
}

void Log::progress(const char* stage, double fraction)
{
    const std::lock_guard lock(mutex_);
    const Clock::time_point now = Clock::now();
    if (stage_ != stage) {
        stage_ = stage;
        stageStart_ = now;
    }
    if (now - stageStart_ < kSilentStart || !mayShow(now)) return;
    lastProgress_ = now;
    if (fraction == core::kUnknownShare) return show(stage_ + " ...");
    fraction = std::clamp(fraction, 0.0, 1.0);
    show(terminal_ ? bar(fraction) + ' ' + wholePercent(fraction) + "  " + stage_
                   : stage_ + ": " + wholePercent(fraction));
}

void Log::progressText(const std::string& text)
{
    const std::lock_guard lock(mutex_);
    const Clock::time_point now = Clock::now();
    if (!mayShow(now)) return;
    lastProgress_ = now;
    show(text);
}

core::Progress Log::callback()
{
    return [this](const char* stage, double fraction) { progress(stage, fraction); };
}

}  // namespace app
