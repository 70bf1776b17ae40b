// Files that the program writes: whole or not at all. A regular file appears under its name only
// when it is complete; links are followed; devices, pipes and open descriptors (/dev/stdout) are
// written to as they are.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

namespace core {

/// Throws core::Error naming the file; then nothing of it is left.
void writeFile(const std::filesystem::path& file, std::span<const std::byte> bytes);
void writeFile(const std::filesystem::path& file, std::string_view text);

/// Throws core::Error unless writeFile would succeed now, as far as can be told without writing.
void requireWritableFile(const std::filesystem::path& file);

/// Whether both names lead to one regular file, which the second write would replace.
bool sameFile(const std::filesystem::path& a, const std::filesystem::path& b);

}  // namespace core
