// The pointers through which the shared text reads a World in C++.
#pragma once

#include "core/scene/world.h"
#include "shared/scene.h"

namespace core {

/// Valid as long as `world` lives.
inline shared::SceneView sceneView(const World& world)
{
    const auto orNull = [](const auto& v) { return v.empty() ? nullptr : v.data(); };
    static_assert(sizeof(Texel) == 4 * sizeof(uint16_t));
    return {world.positions.data(),
            orNull(world.attributes),
            orNull(world.extra),
            world.triangles.data(),
            orNull(world.triangleEmitter),
            world.materials.data(),
            world.textureReferences.data(),
            world.texels.empty() ? nullptr : &world.texels.front().r,
            world.emitters.data(),
            world.emitterCdf.data(),
            world.emitterTree.data(),
            world.environment.data(),
            world.environmentCdf.data(),
            nullptr,
            orNull(world.instanceTable)};
}

/// Asks memory for the triangle in a slot, which is shaded soon,
inline void prefetchTriangle(const shared::SceneView& scene, uint32_t slot)
{
    if (slot >= shared::kFirstInstancedSlot) return;
    __builtin_prefetch(scene.triangles + slot);
    if (scene.triangleEmitter != nullptr) __builtin_prefetch(scene.triangleEmitter + slot);
}

/// and for its vertices, when its indices are there.
inline void prefetchVertices(const shared::SceneView& scene, uint32_t slot)
{
    if (slot >= shared::kFirstInstancedSlot) return;
    const shared::WorldTriangle& t = scene.triangles[slot];
    for (const uint32_t v : {t.v0, t.v1, t.v2}) {
        __builtin_prefetch(scene.positions + v);
        if (scene.attributes != nullptr) __builtin_prefetch(scene.attributes + v);
    }
}

}  // namespace core
