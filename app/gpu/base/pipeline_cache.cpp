// Files: a header with the key and a checksum, then the driver's bytes. Drivers check little of
// what they are given.
#include "app/gpu/base/pipeline_cache.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <system_error>

#include "core/base/check.h"
#include "core/base/output_file.h"

namespace gpu {

namespace {

constexpr uint64_t kMaxBytes = uint64_t(64) << 20;

struct Header {
    std::array<char, 8> magic{'R', 'K', 'N', 'D', 'P', 'C', '0', '1'};
    CacheKey key;
    uint64_t bytes = 0, checksum = 0;
};
static_assert(sizeof(Header) == 64);

std::filesystem::path fileOf(const std::filesystem::path& folder, const CacheKey& key)
{
    char name[32];
    std::snprintf(name, sizeof(name), "%016llx.pipeline",
                  static_cast<unsigned long long>(hashBytes(std::as_bytes(std::span(&key, 1)))));
    return folder / name;
}

std::filesystem::path folderIn(const char* variable)
{
    const char* value = std::getenv(variable);
    return value != nullptr && value[0] == '/' ? std::filesystem::path(value)
                                               : std::filesystem::path();
}

}  // namespace

std::filesystem::path userCacheFolder()
{
    if (const std::filesystem::path cache = folderIn("XDG_CACHE_HOME"); !cache.empty())
        return cache / "rekindle";
    if (const std::filesystem::path home = folderIn("HOME"); !home.empty())
        return home / ".cache" / "rekindle";
    return {};
}

uint64_t hashBytes(std::span<const std::byte> bytes, uint64_t seed)
{
    for (const std::byte b : bytes) seed = (seed ^ static_cast<uint64_t>(b)) * 0x100000001b3u;
    return seed;
}

std::vector<std::byte> readCache(const std::filesystem::path& folder, const CacheKey& key)
{
    std::error_code error;
    const std::filesystem::path file = fileOf(folder, key);
    if (folder.empty() || !std::filesystem::is_regular_file(file, error)) return {};
    std::ifstream in(file, std::ios::binary);
    Header header;
    if (!in.read(reinterpret_cast<char*>(&header), sizeof(header))) return {};
    if (header.magic != Header().magic || !(header.key == key) || header.bytes > kMaxBytes)
        return {};
    std::vector<std::byte> data(header.bytes);
    if (!in.read(reinterpret_cast<char*>(data.data()), static_cast<std::streamsize>(data.size())))
        return {};
    if (in.peek() != std::ifstream::traits_type::eof() || hashBytes(data) != header.checksum)
        return {};
    return data;
}

void writeCache(const std::filesystem::path& folder, const CacheKey& key,
                std::span<const std::byte> data)
{
    if (folder.empty() || data.empty() || data.size() > kMaxBytes) return;
    Header header;
    header.key = key;
    header.bytes = data.size();
    header.checksum = hashBytes(data);
    std::vector<std::byte> all(sizeof(header) + data.size());
    std::memcpy(all.data(), &header, sizeof(header));
    std::memcpy(all.data() + sizeof(header), data.data(), data.size());
    std::error_code ignored;
    std::filesystem::create_directories(folder, ignored);
    try {
        core::writeFile(fileOf(folder, key), all);
    } catch (const core::Error&) {
        // Without a cache the next start compiles again.
    }
}

}  // namespace gpu
