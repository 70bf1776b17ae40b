// Reading of text files, and names of numbered files. What writes is core/base/output_file.h.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace app {

/// The whole file, at most `maxBytes`. Throws core::Error.
std::string readText(const std::filesystem::path& file, uint64_t maxBytes = 64 << 20);

/// True when the name holds exactly one place for a number: %d, %4d or %04d.
bool isNumbered(const std::filesystem::path& file);

/// The name with its number filled in. `file` isNumbered.
std::filesystem::path numbered(const std::filesystem::path& file, uint32_t number);

/// The number that makes `name` of the file's own name; nothing where none does. `file` isNumbered.
std::optional<uint32_t> numberIn(const std::filesystem::path& file, const std::string& name);

}  // namespace app
