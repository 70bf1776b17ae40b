// See reuse_estimator.h.
#include "core/methods/reuse_estimator.h"

#include "core/methods/reuse_settings.h"

namespace shared {

bool traceWay(const SceneView& scene, vec3 origin, vec3 direction, uint seed, Hit& hit)
{
    return static_cast<const core::TracedScene&>(scene).accel->closest(
        {origin, kInfinity, direction, seed}, hit);
}

bool wayIsOpen(const SceneView& scene, ShadowRay& shadow, uint seed, ReuseTally& tally)
{
    const auto& traced = static_cast<const core::TracedScene&>(scene);
    ++tally.shadowRays;
    return !traced.accel->occluded({shadow.origin, shadow.tMax, shadow.direction, seed}) ||
           core::comesThroughPanes(traced, shadow, seed, tally);
}

MovedPiece fetchMovedPiece(const SceneView& scene, uint i)
{
    return static_cast<const core::TracedScene&>(scene).moved[i];
}

/// Slots are triangles here, those of both poses.
Triangle fetchTriangleBefore(const SceneView& scene, uint slot)
{
    const core::World& before = *static_cast<const core::TracedScene&>(scene).worldBefore;
    const WorldTriangle& t = before.triangles[slot];
    const auto vertex = [&](uint index) { return vec4(before.positions[index], 0.0f); };
    return {vertex(t.v0), vertex(t.v1), vertex(t.v2)};
}

}  // namespace shared

namespace core {

using glm::uvec2;

bool comesThroughPanes(const TracedScene& scene, shared::ShadowRay& shadow, uint32_t seed,
                       shared::ReuseTally& tally)
{
    Ray ray{shadow.origin, shadow.tMax, shadow.direction, seed};
    if (shadow.passes == 0 || !scene.accel->meetsPane(ray)) return false;
    shared::Hit hit;
    for (;;) {
        ++tally.shadowRays;
        if (!scene.accel->closest(ray, hit)) return true;
        if (!shared::passPane(scene, hit, shadow)) return false;
        ray = {shadow.origin, shadow.tMax, shadow.direction, seed};
    }
}

void ReuseStore::reset(uvec2 newSize, const ReuseParams& params)
{
    const size_t count = size_t(newSize.x) * newSize.y;
    pixels.resize(count);
    maps.resize(count);
    const bool keeps = shared::keepsSamples(uint32_t(params.reuse));
    samples.resize(keeps ? count * recordsKept(params) : 0);
    lights.resize(keeps ? count * lightsKept(params) : 0);
    means.resize(shared::keepsMeans(uint32_t(params.reuse)) ? count : 0);
    remainders.resize(carriesRemainder(params) ? count : 0);
    size = newSize;
}

ReuseJob makeReuseJob(const Accel& accel, const ReuseStore& before, ReuseStore& now,
                      std::span<const shared::MovedPiece> moved, const shared::PathSettings& path,
                      const shared::ReuseSettings& settings, float perDeviation,
                      uint32_t firstSample)
{
    ReuseJob job{{sceneView(accel.world()), &accel, before.world.get(), moved},
                 before,
                 now,
                 path,
                 settings,
                 perDeviation,
                 firstSample};
    job.settings.flags |= static_cast<uint32_t>(moved.size()) << shared::kReuseMovedShift;
    return job;
}

std::span<const ReuseVariant> reuseVariants()
{
    using namespace shared;
    static constexpr ReuseVariant kVariants[] = {
        {kFeatureEmissiveTriangles | kFeatureManyEmitters | kFeatureKeepsSamples |
             kFeatureKeepsMeans,
         estimateFlatReuseTile},
        {0xffffffffu, estimateAnyReuseTile},
    };
    return kVariants;
}

}  // namespace core
