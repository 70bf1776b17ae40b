// See lost_light.h. With max(d, b)^2 in place of d^2 a light at distance d < b keeps d^2 / b^2 of
// what it brings; a path that finds it counts with the rest. Where a virtual light shines through a
// pane its ray is blocked, and what the receiver gets straight through panes is found as the path
// tracer finds it: by a connection, which counts if it has passed a pane at least, and by the path,
// weighted against each other. The former alone finds lights without extent.
#include "core/many_lights/lost_light.h"

#include <algorithm>
#include <array>

#include "core/base/per_thread.h"
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
    float pdf;   // of its direction at the receiver
};

struct Wave {
    std::array<Walk, kWave> walks;
    std::array<Ray, kWave> rays;
    std::array<shared::Hit, kWave> hits;
    std::array<shared::ShadowRay, kWave> shadows;  // those of `rays` once walks have been moved on
    std::array<uint32_t, kWave> owners;
    std::array<uint8_t, kWave> blocked;
    size_t going = 0, shadowCount = 0;

    /// Queues a connection from the walk's vertex.
    void add(const shared::ShadowRay& shadow, const Walk& walk, uint32_t depth)
    {
        if (shadow.contribution == vec3(0)) return;
        const uint32_t seed = shared::alphaSeed(walk.stream, depth, 1);
        add(shadow, walk.index, seed);
    }
    void add(const shared::ShadowRay& shadow, uint32_t owner, uint32_t seed)
    {
        rays[shadowCount] = {shadow.origin, shadow.tMax, shadow.direction, seed};
        shadows[shadowCount] = shadow;
        owners[shadowCount++] = owner;
    }
};

shared::Vertex vertexOf(const ReceiverJob& job, const shared::SceneView& scene, const Receiver& r)
{
    shared::Vertex v;
    v.surface = shared::makeSurfacePoint(scene, {0, r.barycentrics, r.slot}, r.direction);
    const shared::Shading shading = shared::evaluateMaterial(scene, v.surface, r.direction);
    v.bsdf = shared::makeBsdf(shading.inputs);
    v.wo = shared::toLocal(v.surface.frame, -r.direction);
    v.lobes = shared::lobesAt(v.bsdf, v.wo);
    v.skyRegion = 0;
    if (shared::drawsSkyByPlace(job.settings))
        v.skyRegion = shared::findSkyRegion(scene, v.surface.position, v.surface.frame[2]);
    return v;
}

/// The connection of a receiver to an emitter, of which nothing counts but what passes panes.
void connectReceiver(const ReceiverJob& job, const shared::SceneView& scene, const Receiver& r,
                     const shared::Vertex& v, const shared::VertexNumbers& numbers,
                     const Walk& walk, Wave& wave)
{
    shared::PathState path = shared::pathAlong(r.position, r.direction);
    path.depth = r.events;
    path.medium = r.medium;
    if (path.depth >= job.settings.maxDepth) return;
    wave.add(shared::connect(scene, job.settings, numbers, path, v), walk, r.events);
}

/// The ray that leaves a receiver; false where none does. Lobes without density are not the
/// receiver's (see traceReceivers).
bool leave(const ReceiverJob& job, const shared::SceneView& scene, const Receiver& r, Walk& walk,
           Wave& wave)
{
    const shared::Vertex v = vertexOf(job, scene, r);
    walk.stream = receiverStream(job, r.place);
    // The numbers at the receiver have been used for the choice among its lobes.
    walk.stream.seed ^= shared::kPurposeLostLight * 0x9e3779b9u;
    const shared::VertexNumbers n = shared::drawVertexNumbers(walk.stream, r.events);
    const bool panes = shared::passesPanes(job.settings);
    if (panes) connectReceiver(job, scene, r, v, n, walk, wave);
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
    if (!panes) return true;
    walk.pdf = next.pdf;
    walk.path.departure =
        shared::departFrom(walk.path.departure, shared::receiverOf(job.settings, v));
    walk.path.skyRegion = v.skyRegion;
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

/// Takes connections that met something on to the nearest surface, and from behind it if that is a
/// pane. Those of receivers count behind a pane only: what is in sight of them has virtual lights.
/// Returns the rays traced.
uint64_t connectThroughPanes(const ReceiverJob& job, const shared::SceneView& scene,
                             bool ofReceivers, Wave& wave, std::span<vec3> out)
{
    uint64_t rays = 0;
    for (bool passed = !ofReceivers; wave.shadowCount > 0; passed = true) {
        const size_t count = wave.shadowCount;
        rays += count;
        job.accel->closest({wave.rays.data(), count}, wave.hits.data());
        wave.shadowCount = 0;
        for (size_t s = 0; s < count; ++s) {
            shared::ShadowRay shadow = wave.shadows[s];
            const uint32_t owner = wave.owners[s], seed = wave.rays[s].seed;
            if (wave.hits[s].slot != shared::kNone) {
                if (shared::passPane(scene, wave.hits[s], shadow)) wave.add(shadow, owner, seed);
            } else if (passed) {
                out[owner] += shadow.contribution;
            }
        }
    }
    return rays;
}

/// Answers the connections that are queued; returns the rays traced.
uint64_t connectWave(const ReceiverJob& job, const shared::SceneView& scene, bool ofReceivers,
                     Wave& wave, std::span<vec3> out)
{
    const size_t count = wave.shadowCount;
    if (!ofReceivers) job.accel->occluded({wave.rays.data(), count}, wave.blocked.data());
    wave.shadowCount = 0;
    for (size_t s = 0; s < count; ++s) {
        if (!ofReceivers && wave.blocked[s] == 0)
            out[wave.owners[s]] += wave.shadows[s].contribution;
        else if (shared::passesPanes(job.settings) && job.accel->meetsPane(wave.rays[s]))
            wave.add(wave.shadows[s], wave.owners[s], wave.rays[s].seed);
    }
    return (ofReceivers ? 0 : count) + connectThroughPanes(job, scene, ofReceivers, wave, out);
}

/// Moves the walks on from their hits; returns the rays traced to emitters.
uint64_t advanceWave(const ReceiverJob& job, const shared::SceneView& scene, float clampDistance,
                     Wave& wave, std::span<vec3> out)
{
    size_t kept = 0;
    wave.shadowCount = 0;
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
        // Straight through its first pane: what follows is also found from the receiver.
        if (goes && walk.first && walk.path.passed > 0) walk.path.pdf = walk.pdf;
        walk.first = false;
        wave.add(shadow, walk, walk.path.depth);
        if (goes) wave.walks[kept++] = walk;
    }
    wave.going = kept;
    return connectWave(job, scene, false, wave, out);
}

}  // namespace

bool losesLight(const World& world, float clampDistance)
{
    return clampDistance > 0 || (world.features & shared::kFeatureDelta) != 0;
}

uint64_t addLostLight(const ReceiverJob& frame, float clampDistance,
                      std::span<const Receiver> receivers, std::span<const uint32_t> chosen,
                      std::span<vec3> out)
{
    const World& world = frame.accel->world();
    const shared::SceneView scene = sceneView(world);
    const bool deltas = (world.features & shared::kFeatureDelta) != 0;
    ReceiverJob job = frame;
    job.settings.passesPanes = worldSettings(world).passesPanes;
    Wave& wave = perThread<Wave>();
    uint64_t rays = 0;
    for (size_t first = 0; first < chosen.size(); first += kWave) {
        const size_t end = std::min(first + kWave, chosen.size());
        wave.going = wave.shadowCount = 0;
        for (size_t i = first; i < end; ++i) {
            Walk& walk = wave.walks[wave.going];
            walk.index = static_cast<uint32_t>(i);
            if (leave(job, scene, receivers[chosen[i]], walk, wave)) ++wave.going;
        }
        rays += connectWave(job, scene, true, wave, out);
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
            rays += advanceWave(job, scene, clampDistance, wave, out);
        }
    }
    return rays;
}

}  // namespace core::many_lights
