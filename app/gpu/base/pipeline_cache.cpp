// Files: a header with the key and a checksum, then the driver's bytes. Drivers check little of
// what they are given.
#include "app/gpu/base/pipeline_cache.h"

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <system_error>

#include <unistd.h>

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
    static std::atomic<uint32_t> counter{0};
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    const std::filesystem::path file = fileOf(folder, key);
    std::filesystem::path unfinished = file;
    char ending[48];
    std::snprintf(ending, sizeof(ending), ".%ld.%u.tmp", static_cast<long>(getpid()), counter++);
    unfinished += ending;
    bool complete = false;
    {
        Header header;
        header.key = key;
        header.bytes = data.size();
        header.checksum = hashBytes(data);
        std::ofstream out(unfinished, std::ios::binary);
        out.write(reinterpret_cast<const char*>(&header), sizeof(header));
        out.write(reinterpret_cast<const char*>(data.data()),
                  static_cast<std::streamsize>(data.size()));
        out.close();
        complete = out.good();
    }
    if (complete) std::filesystem::rename(unfinished, file, error);
    if (!complete || error) std::filesystem::remove(unfinished, error);
}

}  // namespace gpu
