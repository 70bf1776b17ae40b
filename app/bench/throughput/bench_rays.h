// Rays to measure with. Embree's own functions over them are the reference for the GPU's traversal.
#pragma once

#include <vector>

#include "app/gpu/rays.h"
#include "core/scene/camera.h"
#include "core/scene/world.h"
#include "core/trace/embree_rays.h"

namespace app {

/// Sets of rays through one view: primary in Morton order within 8x8 tiles, of which views of more
/// than two million pixels give some, evenly spread; from where they hit, a
/// cosine-distributed bounce each; and a shadow ray each to a point of the emitting triangles, of
/// equal chance by triangle (none where that lies behind the surface: where a view sees nothing but
/// a flat lamp, there are none at all), or, in scenes without any, along the cosine distribution to
/// infinity (as to an environment).
struct BenchRays {
    std::vector<gpu::DeviceRay> primary, bounce, shadow;
};

/// Makes the sets; `embree` finds where the primary rays hit. `width`, `height` in pixels.
BenchRays makeBenchRays(const core::World& world, const core::EmbreeRays& embree,
                        const core::Camera& camera, uint32_t width, uint32_t height);

}  // namespace app
