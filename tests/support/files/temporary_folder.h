// A folder of its own for a test, removed with all it holds.
#pragma once

#include <filesystem>
#include <string>

#include <unistd.h>

namespace tests {

class TemporaryFolder {
public:
    TemporaryFolder()
    {
        static int count = 0;
        path_ = std::filesystem::temp_directory_path() /
                ("rekindle-test-" + std::to_string(getpid()) + "-" + std::to_string(count++));
        std::filesystem::create_directories(path_);
    }
    ~TemporaryFolder()
    {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }
    std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

    /// Number of files in the folder: leftovers of interrupted writing show here.
    size_t count() const
    {
        return size_t(std::distance(std::filesystem::directory_iterator(path_),
                                    std::filesystem::directory_iterator()));
    }

private:
    std::filesystem::path path_;
};

}  // namespace tests
