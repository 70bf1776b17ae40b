#include "app/base/new_folder.h"

#include <algorithm>
#include <string>
#include <system_error>

#include "core/base/check.h"
#include "core/base/output_file.h"

namespace app {

namespace fs = std::filesystem;

/// Why `folder` cannot be used; follows its name and a colon.
static std::string reason(const fs::path& folder)
{
    std::error_code error;
    for (fs::path path = folder; !path.empty(); path = path.parent_path()) {
        if (fs::exists(path, error) && !fs::is_directory(path, error))
            return (path == folder ? "" : path.string() + " ") + "is a file — name a folder";
        if (path == path.parent_path()) break;
    }
    return "this folder cannot be made — name one in a place that can be written";
}

/// Refuses a folder that holds results of another measurement, where both write pages, pictures or
/// references under the same names.
static void requireNoOther(const fs::path& folder, const fs::path& result)
{
    const std::vector<fs::path> results{"flythrough.json", "guiding.json", "lab.json",
                                        "manylights.json"};
    if (std::ranges::find(results, result) == results.end()) return;
    std::error_code none;
    for (const fs::path& other : results)
        if (other != result && fs::exists(folder / other, none))
            throw core::Error(folder.string() + ": holds " + other.string() +
                              ", the results of another measurement, whose page or pictures would "
                              "be replaced — name another folder");
}

NewFolder::NewFolder(const fs::path& folder, const fs::path& result)
{
    std::error_code error;
    // lexically: "a/b/." and "a/b/" are a/b.
    const fs::path path = (folder / ".").lexically_normal().parent_path();
    requireNoOther(path, result);
    for (fs::path p = path; !p.empty() && !fs::exists(p, error); p = p.parent_path()) {
        made_.push_back(p);
        if (p == p.parent_path()) break;
    }
    if (!fs::exists(folder, error)) fs::create_directories(path, error);
    if (!fs::is_directory(path, error)) {
        removeFolders();
        throw core::Error(folder.string() + ": " + reason(path));
    }
    try {
        core::requireWritableFile(path / result);
    } catch (...) {
        removeFolders();
        throw;
    }
}

NewFolder::~NewFolder()
{
    if (!kept_) removeFolders();
}

/// Removes empty folders only.
void NewFolder::removeFolders()
{
    std::error_code ignored;
    for (const fs::path& path : made_) fs::remove(path, ignored);
}

}  // namespace app
