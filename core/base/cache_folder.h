// Files of what is dear to make, kept for later runs under what it was made from. A file that is
// not to the byte what was written counts as absent; nothing here ever fails: who finds nothing
// makes it anew. Several processes may use a folder at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace core {

class CacheFolder {
public:
    /// Without a folder (an empty path) nothing is kept and nothing found. `kind` is the last part
    /// of the files' names; all of one kind take at most `maxBytes`.
    CacheFolder(std::filesystem::path folder, std::string kind, uint64_t maxBytes);

    /// Whether there is a folder to look in.
    explicit operator bool() const { return !folder_.empty(); }

    /// What was written under the key; empty when there is nothing, or nothing that can be trusted,
    /// which is then removed. What is read counts as used now.
    std::vector<std::byte> read(std::span<const std::byte> key) const;

    /// Keeps `data` under the key in a file that appears only when it is complete; those that have
    /// not been used for longest make room. Nothing is kept that has no room at all, nor where
    /// files cannot be written.
    void write(std::span<const std::byte> key, std::span<const std::byte> data) const;

    /// Forgets what was written under the key.
    void remove(std::span<const std::byte> key) const;

private:
    std::filesystem::path fileOf(std::span<const std::byte> key) const;
    void makeRoom(uint64_t bytes, const std::filesystem::path& replaced) const;

    std::filesystem::path folder_;
    std::string kind_;
    uint64_t maxBytes_;
};

}  // namespace core
