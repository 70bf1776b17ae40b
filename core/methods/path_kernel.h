// One tile of the CPU path tracer, compiled several times for different features (path_*.cpp): what
// a scene cannot show is not in the code that renders it, as with the GPU's specialised kernels.
#pragma once

#include <span>

#include "core/base/parallel.h"
#include "core/image/film.h"
#include "core/trace/accel.h"
#include "shared/scene.h"

namespace core {

/// Side of the squares of pixels whose paths are traced together. Which rays share a packet follows
/// from it, so it is part of what an image is.
inline constexpr uint32_t kPathTile = 16;

struct PathJob {
    const Accel* accel = nullptr;
    shared::SceneView scene{};
    shared::PathSettings settings{};
    shared::CameraData camera{};
    uint32_t firstSample = 0, sampleCount = 0;
};

/// What a tile found besides its pixels.
struct PathTally {
    FilmCounters counters;
    uint64_t rays = 0;
};

/// Adds samples to the pixels of `tile` in order of their index.
using PathKernel = PathTally (*)(const PathJob& job, const Tile& tile, Film& film);

struct PathVariant {
    const char* name;
    uint32_t features;
    PathKernel kernel;
};

/// From the least able to the one that knows everything.
std::span<const PathVariant> pathVariants();

PathTally renderFlatTile(const PathJob& job, const Tile& tile, Film& film);
PathTally renderAnyTile(const PathJob& job, const Tile& tile, Film& film);

}  // namespace core
