// From a saved picture back to the view that made it: every EXR (and PNG) carries scene, camera, size and parameters.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "app/args.h"
#include "core/image.h"

namespace app {

struct Replay {
    std::filesystem::path scene;   // as it was named; looked for there, then beside the picture
    std::string sceneHash;         // to be compared after loading
    std::string cameraJson;        // file space
    glm::uvec2 size{0};
    Method method = Method::path;
    core::PathParams params;
    uint64_t samples = 0;
    double at = 0;  // seconds of the scene's animation
};

/// Throws core::Error naming what is missing or malformed.
Replay readReplay(const std::filesystem::path& picture);

}  // namespace app
