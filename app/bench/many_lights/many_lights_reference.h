// The picture of all virtual lights and all shadow rays, kept in a file until something that it
// depends on changes.
#pragma once

#include "app/bench/many_lights/many_lights_scene.h"

namespace app::many_lights {

struct LightsReference {
    std::vector<glm::vec3> values;  // of the subset's pixels
    double seconds = 0;             // that it took when it was made
    bool kept = false;              // read from the file
};

/// Reads it from `file` or makes and writes it. `at`: seconds of the scene's animation. Nothing
/// when a stop came first. Throws core::Error.
std::optional<LightsReference> lightsReference(LitScene& scene, const Subset& subset, double at,
                                               const std::filesystem::path& file);

}  // namespace app::many_lights
