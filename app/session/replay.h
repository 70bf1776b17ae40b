// From a saved picture back to the view that made it: every EXR and PNG of this program carries
// scene, camera, size and parameters.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "app/args/args.h"
#include "core/image/image.h"

namespace app {

struct Replay {
    std::filesystem::path scene;  // where it was found: as it was named, or beside the picture
    std::string sceneHash;        // to be compared after loading
    std::string environment;      // as core::LoadOptions has it; empty: not said
    std::string cameraJson;       // file space; checked to be JSON
    glm::uvec2 size{0};
    DeviceKind device = DeviceKind::vulkan;  // the same kind; which one is not said
    core::AnyParams params;  // of the picture's method; what an older version had no parameter for
                             // is at its default
    uint64_t samples = 0;
    double at = 0;                    // seconds of the scene's animation
    std::optional<double> laidOutAt;  // where another pose than that decided: see core::World
    // Whether the picture began with what the views before had left: it comes out with the same
    // light then, but not with the same bits
    bool follows = false;
};

/// Reads the metadata of a picture (.exr or .png). Throws core::Error naming what is missing or
/// malformed, or where the scene was looked for.
Replay readReplay(const std::filesystem::path& picture);

/// The same from metadata; `picture` is for messages and for the scene's place.
Replay replayOf(const core::Metadata& metadata, const std::filesystem::path& picture);

}  // namespace app
