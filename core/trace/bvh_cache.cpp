// See bvh_cache.h.
#include "core/trace/bvh_cache.h"

#include <new>

namespace core {

static std::span<const std::byte> bytesOf(const BvhKey& key)
{
    return std::as_bytes(std::span(&key, 1));
}

std::optional<Bvh> BvhCache::find(std::span<const glm::vec3> positions,
                                  std::span<const WorldTriangle> triangles,
                                  const BvhOptions& options)
{
    found_ = false;
    if (!files_) return std::nullopt;
    key_ = bvhKey(positions, triangles, options);
    const std::vector<std::byte> bytes = files_.read(bytesOf(key_));
    if (bytes.empty()) return std::nullopt;
    std::optional<Bvh> bvh = bvhFromBytes(bytes, positions, triangles, options);
    found_ = bvh.has_value();
    if (!found_) files_.remove(bytesOf(key_));
    return bvh;
}

void BvhCache::keep(const Bvh& bvh, double seconds)
{
    if (!files_ || seconds < worthSeconds_ || bvhByteCount(bvh) > mostBytes_) return;
    try {
        files_.write(bytesOf(key_), bvhBytes(bvh));
    } catch (const std::bad_alloc&) {
        // Without a cache the next run makes it anew.
    }
}

}  // namespace core
