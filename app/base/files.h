// Text files that appear under their name only when complete, and names of numbered files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace app {

/// Writes `text` beside `file` and renames it. Throws core::Error naming the file.
void writeText(const std::filesystem::path& file, const std::string& text);

/// The whole file, at most `maxBytes`. Throws core::Error.
std::string readText(const std::filesystem::path& file, uint64_t maxBytes = 64 << 20);

/// Throws core::Error unless a file of that name could be created now.
void requireWritableText(const std::filesystem::path& file);

/// True when the name holds exactly one place for a number: %d, %4d or %04d.
bool isNumbered(const std::filesystem::path& file);

/// The name with its number filled in. `file` isNumbered.
std::filesystem::path numbered(const std::filesystem::path& file, uint32_t number);

}  // namespace app
