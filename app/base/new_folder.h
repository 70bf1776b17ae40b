// A folder for results, made before the work and gone again when there are none.
#pragma once

#include <filesystem>
#include <vector>

namespace app {

/// A folder that is created with its parents, and removed again unless it is kept.
class NewFolder {
public:
    /// `result`: a file that will be written into it. Throws core::Error when there can be no such
    /// folder or file, naming what is in the way; and where `result` is a measurement's, when the
    /// folder holds one of another kind.
    NewFolder(const std::filesystem::path& folder, const std::filesystem::path& result);
    ~NewFolder();
    NewFolder(const NewFolder&) = delete;
    NewFolder& operator=(const NewFolder&) = delete;

    void keep() { kept_ = true; }

private:
    void removeFolders();

    std::vector<std::filesystem::path> made_;  // the innermost first
    bool kept_ = false;
};

}  // namespace app
