// Names for a box in which paths are typed. See path_completion.h.
#include "app/files/path_completion.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>

#include "app/args/args.h"

namespace app {

namespace fs = std::filesystem;

namespace {

constexpr size_t kMost = 50;
constexpr size_t kMostEntries = 20000;  // entries read of a folder: typing must not stall

bool sameLetter(char a, char b)
{
    return std::tolower(static_cast<unsigned char>(a)) ==
           std::tolower(static_cast<unsigned char>(b));
}

bool startsWith(const std::string& name, const std::string& start, bool exactly)
{
    if (name.size() < start.size()) return false;
    return exactly ? name.compare(0, start.size(), start) == 0
                   : std::equal(start.begin(), start.end(), name.begin(), sameLetter);
}

struct Names {
    std::vector<std::string> folders, files;
};

/// The names in `folder` that are of interest.
Names namesIn(const fs::path& folder, bool hidden, const std::vector<std::string>& extensions)
{
    Names names;
    std::error_code error;
    size_t seen = 0;
    for (fs::directory_iterator it(folder, error), end; !error && it != end && seen < kMostEntries;
         it.increment(error), ++seen) {
        const std::string name = it->path().filename().string();
        if ((name.front() == '.') != hidden) continue;
        std::error_code unknown;  // a dangling link is not a file
        const fs::file_status status = it->status(unknown);
        if (fs::is_directory(status))
            names.folders.push_back(name);
        else if (fs::is_regular_file(status) &&
                 (extensions.empty() ||
                  std::any_of(extensions.begin(), extensions.end(),
                              [&name](const std::string& e) { return hasExtension(name, e); })))
            names.files.push_back(name);
    }
    std::sort(names.folders.begin(), names.folders.end());
    std::sort(names.files.begin(), names.files.end());
    return names;
}

}  // namespace

std::string expandHome(const std::string& typed)
{
    const char* home = std::getenv("HOME");
    const bool leads = typed == "~" || typed.rfind("~/", 0) == 0;
    return leads && home != nullptr && *home != '\0' ? home + typed.substr(1) : typed;
}

std::vector<std::string> completePath(const std::string& typed,
                                      const std::vector<std::string>& extensions)
{
    const std::string whole = typed == "~" ? expandHome("~/") : expandHome(typed);
    const size_t slash = whole.rfind('/');
    const std::string folder = slash == std::string::npos ? "" : whole.substr(0, slash + 1);
    const std::string start = whole.substr(folder.size());
    const Names names = namesIn(folder.empty() ? fs::path(".") : fs::path(folder),
                                !start.empty() && start.front() == '.', extensions);
    for (const bool exactly : {true, false}) {
        std::vector<std::string> found;
        for (const std::string& name : names.folders)
            if (startsWith(name, start, exactly)) found.push_back(folder + name + '/');
        for (const std::string& name : names.files)
            if (startsWith(name, start, exactly)) found.push_back(folder + name);
        if (found.size() > kMost) found.resize(kMost);
        if (!found.empty()) return found;
    }
    return {};
}

}  // namespace app
