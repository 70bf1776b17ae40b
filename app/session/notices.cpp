// Messages of the window. See notices.h.
#include "app/session/notices.h"

#include <chrono>
#include <cstdio>

#include "core/base/text.h"

namespace app {

static constexpr size_t kKept = 500;

static const std::chrono::steady_clock::time_point kProgramStart = std::chrono::steady_clock::now();

static void print(Severity severity, const std::string& text)
{
    const char* lead = severity == Severity::error     ? "error: "
                       : severity == Severity::warning ? "warning: "
                                                       : "";
    // One call, so that messages of several threads do not mix.
    const std::string whole = lead + text + '\n';
    std::fputs(whole.c_str(), stderr);
}

std::string wholePath(const std::filesystem::path& file)
{
    std::error_code error;
    const std::filesystem::path whole = std::filesystem::absolute(file, error);
    return (error ? file : whole.lexically_normal()).string();
}

void Notices::tell(Severity severity, const std::string& message,
                   const std::filesystem::path& written)
{
    const std::string file = written.empty() ? "" : wholePath(written);
    const std::string text = core::printableLines(message);
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - kProgramStart).count();
    {
        const std::lock_guard lock(mutex_);
        ++count_;
        if (!list_.empty() && list_.back().severity == severity && list_.back().text == text &&
            list_.back().file == file) {
            list_.back().number = count_;
            list_.back().seconds = seconds;
            ++list_.back().times;
            return;
        }
        if (list_.size() == kKept) list_.erase(list_.begin());
        list_.push_back({count_, severity, text, file, seconds, 1});
    }
    // Outside the lock: whoever reads stderr may be slow.
    if (!quiet) print(severity, text);
}

std::vector<Notice> Notices::list() const
{
    const std::lock_guard lock(mutex_);
    return list_;
}

uint64_t Notices::count() const
{
    const std::lock_guard lock(mutex_);
    return count_;
}

void Notices::clear()
{
    const std::lock_guard lock(mutex_);
    list_.clear();
}

}  // namespace app
