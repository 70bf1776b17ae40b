// See lost_light.h. With max(d, b)^2 in place of d^2 a light at distance d < b keeps d^2 / b^2 of
// what it brings; a path that finds it counts with the rest.
#include "core/many_lights/lost_light.h"

#include <algorithm>
#include <array>

#include "core/trace/scene_view.h"
#include "shared/path.h"

namespace core::many_lights {

namespace {

using glm::vec3;

constexpr size_t kWave = 256;

struct Walk {
    shared::PathState path;
    shared::SampleStream stream;
    uint32_t index;
    bool first;  // its next surface is the one that may be too near for a virtual light
};

struct Wave {
    std::array<Walk, kWave> walks;
    std::array<Ray, kWave> rays;
    std::array<shared::Hit, kWave> hits;
    std::array<vec3, kWave> contributions;  // of shadow rays
    std::array<uint32_t, kWave> owners;
    std::array<uint8_t, kWave> blocked;
    size_t going = 0, shadows = 0;
};

shared::Vertex vertexOf(const shared::SceneView& scene, const Receiver& r)
{
    shared::Vertex v;
    v.surface = shared::makeSurfacePoint(scene, {0, r.barycentrics, r.slot}, r.direction);
    const shared::Shading shading = shared::evaluateMaterial(scene, v.surface, r.direction);
    v.bsdf = shared::makeBsdf(shading.inputs);
    v.wo = shared::toLocal(v.surface.frame, -r.direction);
    v.lobes = shared::lobesAt(v.bsdf, v.wo);
    return v;
}

/// The ray that leaves a receiver; false where none does. Lobes without density are not the
/// receiver's (see traceReceivers).
bool leave(const ReceiverJob& job, const shared::SceneView& scene, const Receiver& r, Walk& walk)
{
    const shared::Vertex v = vertexOf(scene, r);
    walk.stream = receiverStream(job, r.place);
    // The numbers at the receiver have been used for the choice among its lobes.
    walk.stream.seed ^= shared::kPurposeLostLight * 0x9e3779b9u;
    const shared::VertexNumbers n = shared::drawVertexNumbers(walk.stream, r.events);
    shared::BsdfSample next;
    if (!shared::sampleLobes(v.bsdf, v.lobes, v.wo, n.lobe.x, n.bsdf, next)) return false;
    if ((next.flags & shared::kLobeDelta) != 0) return false;
    const vec3 wi = shared::toWorld(v.surface.frame, next.wi);
    float side;
    if (!shared::sideOf(v.surface, wi, next.wi.z, side)) return false;
    walk.path = shared::pathAlong(shared::originOnSide(v.surface, side), wi);
    walk.path.beta = next.weight;
    walk.path.depth = r.events + 1;
    walk.path.medium = shared::mediumBeyond(r.medium, v, side);
    walk.first = true;
    return true;
}

/// Whether a surface shows its colour, but lights nothing: to the path tracer a walk would be the
/// eye, for it has no density where it leaves the receiver.
bool isUnlit(const shared::SceneView& scene, shared::SurfacePoint surface, const vec3& direction)
{
    const shared::Shading shading = shared::evaluateMaterial(scene, surface, direction);
    return (shading.inputs.flags & shared::kMaterialUnlit) != 0;
}

/// One surface of a walk: adds what it emits, sets the connection to an emitter, draws the way on.
/// Of the first surface all but its mirror image has the weight `near`.
bool meetSurface(const ReceiverJob& job, const shared::SceneView& scene, const shared::Hit& hit,
                 float near, Walk& walk, shared::ShadowRay& shadow, vec3& found)
{
    shared::Vertex v;
    vec3 emitted(0);
    const bool goes = shared::prepareVertex(scene, job.settings, hit, walk.path, v, emitted);
    shadow = shared::noShadowRay(walk.path.origin);
    if (!goes && emitted != vec3(0) && isUnlit(scene, v.surface, walk.path.direction)) return false;
    found += near * emitted;
    if (!goes) return false;
    const shared::VertexNumbers n = shared::drawVertexNumbers(walk.stream, walk.path.depth);
    shadow = shared::connect(scene, job.settings, n, walk.path, v);
    shadow.contribution *= near;
    shared::BsdfSample next;
    if (!shared::sampleLobes(v.bsdf, v.lobes, v.wo, n.lobe.x, n.bsdf, next)) return false;
    if ((next.flags & shared::kLobeDelta) == 0) next.weight *= near;
    return shared::maxComponent(next.weight) > 0 &&
           shared::follow(job.settings, n, v, next, walk.path);
}

void advanceWave(const ReceiverJob& job, const shared::SceneView& scene, float clampDistance,
                 Wave& wave, std::span<vec3> out)
{
    size_t kept = 0;
    wave.shadows = 0;
    for (size_t i = 0; i < wave.going; ++i) {
        Walk& walk = wave.walks[i];
        const shared::Hit& hit = wave.hits[i];
        const bool missed = hit.slot == shared::kNone;
        if (missed) {
            if (!walk.first) out[walk.index] += shared::shadeMiss(scene, job.settings, walk.path);
            continue;
        }
        const float t = hit.t / std::max(clampDistance, 1e-30f);
        const float near = walk.first ? std::max(0.0f, 1 - t * t) : 1.0f;
        shared::ShadowRay shadow;
        const bool goes = meetSurface(job, scene, hit, near, walk, shadow, out[walk.index]);
        walk.first = false;
        if (shadow.contribution != vec3(0)) {
            wave.rays[wave.shadows] = {shadow.origin, shadow.tMax, shadow.direction,
                                       shared::alphaSeed(walk.stream, walk.path.depth, 1)};
            wave.contributions[wave.shadows] = shadow.contribution;
            wave.owners[wave.shadows++] = walk.index;
        }
        if (goes) wave.walks[kept++] = walk;
    }
    wave.going = kept;
    job.accel->occluded({wave.rays.data(), wave.shadows}, wave.blocked.data());
    for (size_t s = 0; s < wave.shadows; ++s)
        if (wave.blocked[s] == 0) out[wave.owners[s]] += wave.contributions[s];
}

}  // namespace

bool losesLight(const World& world, float clampDistance)
{
    return clampDistance > 0 || (world.features & shared::kFeatureDelta) != 0;
}

uint64_t addLostLight(const ReceiverJob& job, float clampDistance,
                      std::span<const Receiver> receivers, std::span<const uint32_t> chosen,
                      std::span<vec3> out)
{
    const World& world = job.accel->world();
    const shared::SceneView scene = sceneView(world);
    const bool deltas = (world.features & shared::kFeatureDelta) != 0;
    static thread_local Wave wave;
    uint64_t rays = 0;
    for (size_t first = 0; first < chosen.size(); first += kWave) {
        const size_t end = std::min(first + kWave, chosen.size());
        wave.going = 0;
        for (size_t i = first; i < end; ++i) {
            Walk& walk = wave.walks[wave.going];
            walk.index = static_cast<uint32_t>(i);
            if (leave(job, scene, receivers[chosen[i]], walk)) ++wave.going;
        }
        // Without mirrors nothing beyond the clamp distance is of interest.
        float tMax = deltas ? shared::kInfinity : clampDistance;
        for (; wave.going > 0; tMax = shared::kInfinity) {
            for (size_t i = 0; i < wave.going; ++i) {
                const Walk& walk = wave.walks[i];
                wave.rays[i] = {walk.path.origin, tMax, walk.path.direction,
                                shared::alphaSeed(walk.stream, walk.path.depth, 0)};
            }
            job.accel->closest({wave.rays.data(), wave.going}, wave.hits.data());
            rays += wave.going;
            advanceWave(job, scene, clampDistance, wave, out);
            rays += wave.shadows;
        }
    }
    return rays;
}

}  // namespace core::many_lights
