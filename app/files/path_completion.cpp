// Names for a box in which paths are typed. See path_completion.h.
#include "app/files/path_completion.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>

#include "app/files/folder_list.h"

namespace app {

namespace fs = std::filesystem;

namespace {

constexpr size_t kMostCompletions = 50;

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
    const bool hidden = !start.empty() && start.front() == '.';
    const std::vector<FolderEntry> entries =
        listFolder(folder.empty() ? fs::path(".") : fs::path(folder), extensions,
                   hidden ? HiddenNames::alone : HiddenNames::leftOut);
    for (const bool exactly : {true, false}) {
        std::vector<std::string> found;
        for (const FolderEntry& entry : entries)
            if (startsWith(entry.name, start, exactly))
                found.push_back(folder + entry.name + (entry.folder ? "/" : ""));
        if (found.size() > kMostCompletions) found.resize(kMostCompletions);
        if (!found.empty()) return found;
    }
    return {};
}

}  // namespace app
