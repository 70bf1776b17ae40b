// Small images of the generated scenes, and a writer of Radiance .hdr environments.
#pragma once

#include <filesystem>
#include <functional>

#include <glm/glm.hpp>

namespace assets {

/// Writes folder/grid.png, checker.png, leaf.png (with alpha), bumps.png (a normal map) and
/// rough.png (glTF's metallic-roughness). Throws core::Error.
void writeTextures(const std::filesystem::path& folder);

/// Writes `radiance(u, v)` at texel centres as Radiance RGBE without compression (Ward, "Real
/// Pixels", 1991).
void writeEnvironment(const std::filesystem::path& file, uint32_t width, uint32_t height,
                      const std::function<glm::dvec3(double, double)>& radiance);

}  // namespace assets
