// A file: a header with sizes and a checksum, the whole key (its hash is the name), the data.
#include "core/base/cache_folder.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <optional>
#include <system_error>
#include <utility>

#include "core/base/check.h"
#include "core/base/content_hash.h"
#include "core/base/output_file.h"

namespace core {

namespace fs = std::filesystem;

namespace {

using Bytes = std::span<const std::byte>;

struct Header {
    std::array<char, 8> magic{'R', 'K', 'N', 'D', 'C', 'A', '0', '1'};
    uint64_t keyBytes = 0, dataBytes = 0;
    uint64_t checksum = 0;  // of key and data
};
static_assert(sizeof(Header) == 32);

uint64_t hashOf(Bytes key, Bytes data = {})
{
    ContentHash hash;
    hash.add(key);
    hash.add(data);
    return hash.value();
}

/// The data of a file if it is whole and that of the key.
std::optional<std::vector<std::byte>> readFile(const fs::path& file, Bytes key, uint64_t maxBytes)
{
    std::error_code error;
    const uint64_t size = fs::file_size(file, error);
    std::ifstream in(file, std::ios::binary);
    Header header;
    if (error || !in.read(reinterpret_cast<char*>(&header), sizeof(header))) return {};
    const uint64_t before = sizeof(header) + key.size();
    if (header.magic != Header().magic || header.keyBytes != key.size() ||
        header.dataBytes > maxBytes || size != before + header.dataBytes)
        return {};
    const auto take = [&](std::vector<std::byte>& bytes) {
        return in
            .read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()))
            .good();
    };
    std::vector<std::byte> foundKey(key.size()), data(header.dataBytes);
    if (!take(foundKey) || !std::ranges::equal(foundKey, key) || !take(data)) return {};
    if (hashOf(key, data) != header.checksum) return {};
    return data;
}

/// What takes room in a folder of the cache.
struct Kept {
    fs::path file;
    uint64_t bytes = 0;
    fs::file_time_type used;
};

/// Whether a process that writes a file of this kind has left it unfinished.
bool isUnfinished(const std::string& name, const std::string& kind)
{
    return name.starts_with('.') && name.ends_with(".tmp") &&
           name.find('.' + kind + '.') != std::string::npos;
}

/// The files of a kind. Those that are unfinished are removed once nobody can be writing them.
std::vector<Kept> filesOf(const fs::path& folder, const std::string& kind)
{
    constexpr std::chrono::hours kAbandoned(1);
    std::vector<Kept> files;
    std::error_code error;
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
        std::error_code gone;
        const std::string name = it->path().filename().string();
        const Kept kept{it->path(), it->file_size(gone), it->last_write_time(gone)};
        if (gone || !it->is_regular_file(gone)) continue;
        if (name.ends_with('.' + kind))
            files.push_back(kept);
        else if (isUnfinished(name, kind) &&
                 fs::file_time_type::clock::now() - kept.used > kAbandoned)
            fs::remove(kept.file, gone);
    }
    return files;
}

}  // namespace

CacheFolder::CacheFolder(fs::path folder, std::string kind, uint64_t maxBytes)
    : folder_(std::move(folder)), kind_(std::move(kind)), maxBytes_(maxBytes)
{}

fs::path CacheFolder::fileOf(Bytes key) const
{
    std::array<char, 20> name{};
    std::snprintf(name.data(), name.size(), "%016llx.",
                  static_cast<unsigned long long>(hashOf(key)));
    return folder_ / (name.data() + kind_);
}

std::vector<std::byte> CacheFolder::read(Bytes key) const
{
    if (folder_.empty()) return {};
    std::error_code error;
    const fs::path file = fileOf(key);
    if (!fs::is_regular_file(file, error)) return {};
    std::optional<std::vector<std::byte>> data = readFile(file, key, maxBytes_);
    if (!data) {
        fs::remove(file, error);
        return {};
    }
    fs::last_write_time(file, fs::file_time_type::clock::now(), error);
    return *std::move(data);
}

void CacheFolder::remove(Bytes key) const
{
    std::error_code error;
    if (!folder_.empty() && fs::is_regular_file(fileOf(key), error)) fs::remove(fileOf(key), error);
}

/// Removes the files that have not been used for longest until there is room for `bytes` in the
/// place of `replaced`.
void CacheFolder::makeRoom(uint64_t bytes, const fs::path& replaced) const
{
    std::vector<Kept> files = filesOf(folder_, kind_);
    std::erase_if(files, [&](const Kept& kept) { return kept.file == replaced; });
    std::ranges::sort(files, {}, &Kept::used);
    uint64_t all = bytes;
    for (const Kept& kept : files) all += kept.bytes;
    std::error_code error;
    for (const Kept& kept : files) {
        if (all <= maxBytes_) return;
        fs::remove(kept.file, error);
        all -= kept.bytes;
    }
}

void CacheFolder::write(Bytes key, Bytes data) const
{
    Header header;
    header.keyBytes = key.size();
    header.dataBytes = data.size();
    const uint64_t bytes = sizeof(header) + key.size() + data.size();
    if (folder_.empty() || data.empty() || bytes > maxBytes_) return;
    header.checksum = hashOf(key, data);
    std::vector<std::byte> all(bytes);
    std::memcpy(all.data(), &header, sizeof(header));
    std::ranges::copy(key, all.begin() + sizeof(header));
    std::ranges::copy(data, all.end() - static_cast<std::ptrdiff_t>(data.size()));
    std::error_code ignored;
    fs::create_directories(folder_, ignored);
    const fs::path file = fileOf(key);
    makeRoom(bytes, file);
    try {
        writeFile(file, all);
    } catch (const Error&) {
        // Without a cache the next run makes it anew.
    }
}

}  // namespace core
