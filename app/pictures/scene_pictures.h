// Small pictures of scenes as they were last seen, by which a person finds them again among those
// that were open before.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "app/pictures/view_params.h"
#include "core/base/cache_folder.h"
#include "core/image/image.h"

namespace app {

/// RGB rows from the top in sRGB, kWidth x kHeight; or nothing.
struct SmallPicture {
    static constexpr uint32_t kWidth = 64, kHeight = 36;
    std::vector<uint8_t> bytes;

    explicit operator bool() const { return !bytes.empty(); }
};

/// The middle of a picture of radiance (not empty, three channels), as large a part of it as has
/// the proportions of a small picture, with the view's exposure and tone curve.
SmallPicture smallPicture(const core::Image& radiance, const ViewParams& view);

class ScenePictures {
public:
    /// Without a folder (an empty path) none are kept.
    explicit ScenePictures(const std::filesystem::path& cacheFolder);

    /// In place of the one before of that scene; never fails.
    void keep(const std::filesystem::path& scene, const SmallPicture& picture) const;
    SmallPicture find(const std::filesystem::path& scene) const;

private:
    core::CacheFolder folder_;
};

}  // namespace app
