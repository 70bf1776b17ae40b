// Hierarchies of earlier runs, in files. What is found there has been checked; what is not found is
// built.
#pragma once

#include <filesystem>
#include <optional>

#include "core/base/cache_folder.h"
#include "core/trace/bvh_file.h"

namespace core {

class BvhCache {
public:
    static constexpr uint64_t kMostBytes = uint64_t(1) << 30;  // of all its files
    static constexpr double kWorthSeconds = 0.3;

    /// In `folder`; an empty path: nothing is kept and nothing found. Only what has taken
    /// `worthSeconds` to build is kept.
    explicit BvhCache(const std::filesystem::path& folder, double worthSeconds = kWorthSeconds,
                      uint64_t mostBytes = kMostBytes)
        : files_(folder, "hierarchy", mostBytes), worthSeconds_(worthSeconds), mostBytes_(mostBytes)
    {}

    /// The hierarchy of these triangles, if it is there and sound; a file that is not is removed.
    std::optional<Bvh> find(std::span<const glm::vec3> positions,
                            std::span<const WorldTriangle> triangles, const BvhOptions& options);

    /// Keeps what was built in so many seconds after find() had found nothing.
    void keep(const Bvh& bvh, double seconds);

    /// Whether the last find() has found something.
    bool found() const { return found_; }

private:
    CacheFolder files_;
    double worthSeconds_;
    uint64_t mostBytes_;
    BvhKey key_;  // of the last find()
    bool found_ = false;
};

}  // namespace core
