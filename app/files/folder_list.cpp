// See folder_list.h.
#include "app/files/folder_list.h"

#include <algorithm>
#include <cctype>

#include "app/args/args.h"

namespace app {

namespace fs = std::filesystem;

namespace {

constexpr size_t kMostEntries = 20000;

bool before(const FolderEntry& a, const FolderEntry& b)
{
    if (a.folder != b.folder) return b.folder;
    const auto lower = [](char x, char y) {
        return std::tolower(static_cast<unsigned char>(x)) <
               std::tolower(static_cast<unsigned char>(y));
    };
    const auto less = [&](const std::string& x, const std::string& y) {
        return std::lexicographical_compare(x.begin(), x.end(), y.begin(), y.end(), lower);
    };
    if (less(a.name, b.name)) return true;
    return !less(b.name, a.name) && a.name < b.name;
}

}  // namespace

std::vector<FolderEntry> listFolder(const fs::path& folder,
                                    const std::vector<std::string>& extensions, HiddenNames hidden)
{
    std::vector<FolderEntry> entries;
    std::error_code error;
    size_t seen = 0;
    for (fs::directory_iterator it(folder, error), end; !error && it != end && seen < kMostEntries;
         it.increment(error), ++seen) {
        FolderEntry entry{it->path().filename().string()};
        if ((entry.name.front() == '.') != (hidden == HiddenNames::alone)) continue;
        std::error_code unknown;  // a dangling link is not a file
        const fs::file_status status = it->status(unknown);
        entry.folder = fs::is_directory(status);
        const bool wanted =
            extensions.empty() || std::ranges::any_of(extensions, [&](const std::string& e) {
                return hasExtension(entry.name, e);
            });
        if (!entry.folder && !(fs::is_regular_file(status) && wanted)) continue;
        if (!entry.folder) entry.bytes = it->file_size(unknown);
        if (unknown) entry.bytes = 0;
        entries.push_back(std::move(entry));
    }
    std::ranges::sort(entries, before);
    return entries;
}

}  // namespace app
