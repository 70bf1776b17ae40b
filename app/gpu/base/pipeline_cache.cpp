// Drivers check little of what they are given: core/base/cache_folder.h does.
#include "app/gpu/base/pipeline_cache.h"

#include "core/base/cache_folder.h"

namespace gpu {

static core::CacheFolder folderOfKernels(const std::filesystem::path& folder)
{
    constexpr uint64_t kMaxBytes = uint64_t(256) << 20;
    return {folder, "pipeline", kMaxBytes};
}

static std::span<const std::byte> bytesOf(const CacheKey& key)
{
    return std::as_bytes(std::span(&key, 1));
}

std::vector<std::byte> readCache(const std::filesystem::path& folder, const CacheKey& key)
{
    return folderOfKernels(folder).read(bytesOf(key));
}

void writeCache(const std::filesystem::path& folder, const CacheKey& key,
                std::span<const std::byte> data)
{
    folderOfKernels(folder).write(bytesOf(key), data);
}

}  // namespace gpu
