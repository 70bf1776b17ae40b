// The scenes of assets/.
#pragma once

#include <memory>
#include <string>

#include "core/gltf/gltf.h"
#include "core/scene/world.h"

namespace tests {

/// The world of assets/`name`.gltf.
inline std::shared_ptr<const core::World> asset(const std::string& name)
{
    return core::makeWorld(
        core::loadGltf(std::string(REKINDLE_SOURCE_DIR "/assets/") + name + ".gltf"));
}

}  // namespace tests
