// What the window tells: messages that stay in a list and can be copied. Safe from any thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <string>
#include <vector>

namespace app {

enum class Severity { news, warning, error };

struct Notice {
    uint64_t number = 0;  // 1, 2, ...; of the last time that it was told
    Severity severity = Severity::news;
    std::string text;    // may have several lines
    std::string file;    // that the text is about, with its whole path, or empty
    double seconds = 0;  // since the program began; of the last time
    uint64_t times = 1;  // told in a row
};

/// With its folder, seen from the root: where a file went is told without knowing where the program
/// was started.
std::string wholePath(const std::filesystem::path& file);

class Notices {
public:
    /// Adds a message; also a line on stderr, unless quiet. One that equals the last is counted
    /// there and gets a new number, but is not repeated.
    /// `file`: that has been written, for whoever wants to copy its path.
    void tell(Severity severity, const std::string& text, const std::filesystem::path& file = {});

    /// The last 500, oldest first, numbers increasing.
    std::vector<Notice> list() const;

    /// How many times anything was told; the number of the newest. Stays when the list is cleared.
    uint64_t count() const;
    void clear();

    /// To be set before other threads tell anything.
    bool quiet = false;

private:
    mutable std::mutex mutex_;
    std::vector<Notice> list_;
    uint64_t count_ = 0;
};

}  // namespace app
