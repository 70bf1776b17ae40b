// One tile of the CPU path tracer, compiled several times for different features (path_*.cpp): what
// a scene cannot show is not in the code that renders it, as with the GPU's specialised kernels.
#pragma once

#include <span>

#include "core/methods/tiled_film.h"
#include "core/trace/accel.h"
#include "shared/scene.h"

namespace core {

struct PathJob {
    const Accel* accel = nullptr;
    shared::SceneView scene{};
    shared::PathSettings settings{};
    shared::CameraData camera{};
    uint32_t firstSample = 0, sampleCount = 0;
};

/// Adds samples to the pixels of `tile` in order of their index.
using PathKernel = TileTally (*)(const PathJob& job, const Tile& tile, Film& film);

struct PathVariant {
    const char* name;
    uint32_t features;
    PathKernel kernel;
};

/// From the least able to the one that knows everything.
std::span<const PathVariant> pathVariants();

/// The least able of some variants that knows all `features`.
template <class Variant>
const Variant& leastAble(std::span<const Variant> variants, uint32_t features)
{
    for (const Variant& v : variants)
        if ((features & ~v.features) == 0) return v;
    return variants.back();
}

TileTally renderFlatTile(const PathJob& job, const Tile& tile, Film& film);
TileTally renderFlatTreeTile(const PathJob& job, const Tile& tile, Film& film);
TileTally renderAnyTile(const PathJob& job, const Tile& tile, Film& film);
TileTally renderAnyTreeTile(const PathJob& job, const Tile& tile, Film& film);

}  // namespace core
