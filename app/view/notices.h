// What the window tells: messages that stay in a list and can be copied. Safe from any thread.
#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

namespace app {

enum class Severity { news, warning, error };

struct Notice {
    uint64_t number = 0;  // 1, 2, ...
    Severity severity = Severity::news;
    std::string text;    // may have several lines
    double seconds = 0;  // since the program began
};

class Notices {
public:
    /// Also a line on stderr, unless quiet. Equal messages in a row are counted, not repeated.
    void tell(Severity severity, const std::string& text);
    std::vector<Notice> list() const;  // the last 500
    uint64_t count() const;
    void clear();
    bool quiet = false;

private:
    mutable std::mutex mutex_;
    std::vector<Notice> list_;
    uint64_t count_ = 0;
};

}  // namespace app
