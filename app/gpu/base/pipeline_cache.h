// What drivers keep of compiled kernels, in files: one per kernel, device and driver. A file that
// is not to the byte what was written, or of another device or driver, counts as absent; nothing
// here ever fails.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace gpu {

/// What a compiled kernel is good for.
struct CacheKey {
    std::array<uint8_t, 16> cacheUuid{};  // VkPhysicalDeviceProperties::pipelineCacheUUID
    uint32_t vendor = 0, device = 0, driverVersion = 0;
    uint32_t reserved = 0;
    uint64_t kernel = 0;  // hash of the SPIR-V and of what it is specialised on

    friend bool operator==(const CacheKey&, const CacheKey&) = default;
};
static_assert(sizeof(CacheKey) == 40);

/// What was written under the key; empty when there is nothing, or nothing that can be trusted.
std::vector<std::byte> readCache(const std::filesystem::path& folder, const CacheKey& key);

/// Keeps `data` under the key; the file appears only when it is complete, so that processes may do
/// this at once.
void writeCache(const std::filesystem::path& folder, const CacheKey& key,
                std::span<const std::byte> data);

}  // namespace gpu
