// See new_name.h.
#include "app/base/new_name.h"

#include <ctime>
#include <set>
#include <utility>

namespace app {

namespace fs = std::filesystem;

fs::path newName(const std::string& ending)
{
    // Files may be written seconds later, so that none is there yet by the name that was given
    // last.
    static std::string second;  // of the names below
    static std::set<fs::path> given;
    const std::time_t now = std::time(nullptr);
    std::tm local{};
    localtime_r(&now, &local);
    char name[64];
    std::strftime(name, sizeof name, "rekindle-%Y-%m-%d-%H%M%S", &local);
    if (std::exchange(second, name) != name) given.clear();
    fs::path file = second + ending;
    std::error_code unknown;
    for (int again = 2; given.contains(file) || fs::exists(file, unknown); ++again)
        file = second + '-' + std::to_string(again) + ending;
    given.insert(file);
    return file;
}

fs::path newPattern(const fs::path& pattern)
{
    const fs::path folder = pattern.parent_path();
    fs::path free = folder;
    std::error_code unknown;
    for (int again = 2; fs::exists(free, unknown); ++again) {
        free = folder;
        free += '-' + std::to_string(again);
    }
    return free / pattern.filename();
}

}  // namespace app
