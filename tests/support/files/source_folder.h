// Where the project's own files lie.
#pragma once

#include <filesystem>

namespace tests {

inline const std::filesystem::path kSource = REKINDLE_SOURCE_DIR;
inline const std::filesystem::path kAssets = kSource / "assets";

}  // namespace tests
