// What a folder holds, for lists to choose from and for completion.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace app {

struct FolderEntry {
    std::string name;
    bool folder = false;
    uint64_t bytes = 0;  // of a file
};

enum class HiddenNames { leftOut, alone };

/// Files that end in one of `extensions` (lower case, with their dot; empty: all), then folders,
/// each sorted by name whatever its case. Names that begin with a dot are left out, or alone there.
/// Links count as what they lead to; what is neither file nor folder, and what cannot be read, is
/// not listed. At most the first 20,000 entries of the folder are looked at: a person waits.
std::vector<FolderEntry> listFolder(const std::filesystem::path& folder,
                                    const std::vector<std::string>& extensions,
                                    HiddenNames hidden = HiddenNames::leftOut);

}  // namespace app
