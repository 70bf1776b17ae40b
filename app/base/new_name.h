// Names of files that nobody has typed: those of which there is none yet.
#pragma once

#include <filesystem>
#include <string>

namespace app {

/// "rekindle-2026-11-21-173005.png" in the current folder for the ending ".png"; never one that is
/// there, nor the same one twice.
std::filesystem::path newName(const std::string& ending);

/// The pattern of numbered files in a folder that is not there yet: `pattern`, or with "-2", "-3"
/// behind its folder's name.
std::filesystem::path newPattern(const std::filesystem::path& pattern);

}  // namespace app
