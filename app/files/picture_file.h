// An estimate as a picture file: EXR with layers, or PNG.
#pragma once

#include <filesystem>

#include "app/args/args.h"
#include "core/image/film.h"
#include "core/methods/renderer.h"
#include "core/scene/world.h"

namespace app {

/// Writes the mean of an estimate (at least one sample) with what `options` say about layers,
/// exposure and tone. `aovs` may be absent: then there are none in the file; `maps` are layers of
/// the method's own. The file appears only when complete. Throws core::Error.
void writePicture(const std::filesystem::path& file, const core::Estimate& estimate,
                  core::Aovs* aovs, std::vector<core::Layer> maps, const RenderOptions& options,
                  const core::Metadata& metadata);

/// Distances of the world, whose unit is not the file's, in metres as the file has them.
core::Image inMetres(core::Image depth, const core::World& world);

/// Throws core::Error (command line) when a picture of that size cannot be held in this machine's
/// memory.
void requireMemoryFor(glm::uvec2 size);

}  // namespace app
