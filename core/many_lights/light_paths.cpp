// See light_paths.h. Paths go in waves of 256 so that their rays make packets; a wave depends on
// the numbers of its paths alone.
#include "core/many_lights/light_paths.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/denormals.h"
#include "core/base/parallel.h"
#include "core/many_lights/light_particle.h"
#include "core/trace/scene_view.h"
#include "shared/path.h"

namespace core::many_lights {

namespace {

using glm::vec2, glm::vec3;

constexpr size_t kWave = 256;

struct Scene {
    const Accel* accel;
    shared::SceneView view;
    shared::PathSettings settings;
    float perPath;  // share of one path in the mean over paths
};

/// Whether there can be sums of what it sends: not of what is infinite, or soon will be.
bool isNumber(const VirtualLight& light)
{
    return light.importance < 1e30f;
}

/// What one wave has found. Details of lights count from the wave's own first.
struct WaveLights {
    LightSet set;

    /// Whether it is kept.
    bool add(const VirtualLight& light)
    {
        if (!isNumber(light)) ++set.dropped;
        const bool kept = light.importance > 0 && isNumber(light);
        if (kept) set.lights.push_back(light);
        return kept;
    }

    /// One with a surface that scatters other than Lambert's.
    void add(VirtualLight light, const LightSurface& surface)
    {
        light.detail = static_cast<uint32_t>(set.surfaces.size());
        if (add(light)) set.surfaces.push_back(surface);
    }
};

float asImportance(const vec3& intensity)
{
    return shared::luminance(intensity);
}

/// The numbers of a path's start: which emitter and which side of it, where, and in which
/// direction.
struct StartNumbers {
    vec2 choice, point, direction;
};

StartNumbers drawStart(const shared::SampleStream& stream)
{
    return {shared::streamVec2(stream, shared::kDimensionPath),
            shared::streamVec2(stream, shared::kDimensionPath + 1),
            shared::streamVec2(stream, shared::kDimensionPath + 2)};
}

/// The surface of a light below a clear coat, which shines less to the sides: white, lit from right
/// above and under a smooth coat, a surface sends out just what is left of emission, for a coat
/// darkens by the lower of both cosines. Returns how much is left of what goes in direction `out`.
float coatLight(const Scene& scene, const shared::Emitter& e, const vec2& w, const vec3& out,
                const VirtualLight& light, LightSurface& surface)
{
    shared::SurfacePoint s = shared::emitterSurface(scene.view, e, w, -light.normal);
    const float coat = shared::evaluateMaterial(scene.view, s, -light.normal).inputs.clearcoat;
    surface.frame = s.frame;
    surface.normal = light.normal;
    surface.incident = vec3(0, 0, 1);
    surface.lobes = {0, 0, 0, 1};
    shared::BsdfInputs white{};
    white.baseColor = vec3(1);
    white.clearcoat = coat;
    surface.bsdf = shared::makeBsdf(white);
    surface.bsdf.parts |= shared::kLightEmits;
    surface.bsdf.diffuse = vec3(shared::kPi);
    surface.bsdf.coatAlpha = 0;
    return shared::emissionThroughCoat(coat, std::max(glm::dot(s.frame[2], out), 0.0f));
}

/// From a point of a triangle. `scale`: one over the probability of the emitter.
bool emitFromTriangle(const Scene& scene, const shared::Emitter& e, const StartNumbers& u,
                      float scale, WaveLights& out, Particle& p)
{
    const vec2 w = shared::sampleTriangle(u.point);
    const vec3 cross = glm::cross(e.b - e.a, e.c - e.a);
    const float twiceArea = glm::length(cross);
    if (!(twiceArea > 0)) return false;
    vec3 radiance = e.radiance * shared::surfaceAlpha(scene.view, e.slot, w);
    if ((e.kind & shared::kEmitterTextured) != 0)
        radiance *= shared::emitterTexture(scene.view, e.slot, w);
    const bool twoSided = (e.kind & shared::kEmitterTwoSided) != 0;
    VirtualLight light;
    light.position = e.a + w.x * (e.b - e.a) + w.y * (e.c - e.a);
    light.normal = cross / twiceArea;
    const vec3 intensity = radiance * (0.5f * twiceArea * scale);
    const vec3 side = twoSided && u.choice.y < 0.5f ? -light.normal : light.normal;
    const float sides = twoSided ? 2.0f : 1.0f;
    p.origin = shared::offsetRay(light.position, side, shared::leastOffset(e.a, e.b, e.c, 0.0f));
    p.direction =
        shared::toWorld(shared::makeFrame(side), shared::sampleCosineHemisphere(u.direction));
    p.flux = intensity * (shared::kPi * sides);
    light.intensity = intensity * scene.perPath;
    light.bothSides = twoSided ? 1 : 0;
    light.importance = asImportance(light.intensity);
    if ((e.kind & shared::kEmitterCoated) != 0) {
        // The light of one side stands for both: details know one.
        light.normal = side;
        light.intensity *= sides;
        light.importance *= sides;
        light.bothSides = 0;
        LightSurface surface;
        p.flux *= coatLight(scene, e, w, p.direction, light, surface);
        out.add(light, surface);
    } else {
        out.add(light);
    }
    return shared::maxComponent(p.flux) > 0;
}

/// From a point or a spot light, whose virtual light is not the path's.
bool emitFromPoint(const shared::Emitter& e, const StartNumbers& u, float scale, Particle& p)
{
    const bool spot = (e.kind & 0xffu) == shared::kEmitterSpot;
    p.origin = e.a;
    if (!spot) {
        p.direction = shared::sampleSphere(u.direction);
        p.flux = e.radiance * (4.0f * shared::kPi * scale);
        return true;
    }
    const float oneMinusCos = std::clamp(1.0f + e.offset / e.scale, 1e-7f, 2.0f);
    p.direction =
        shared::toWorld(shared::makeFrame(e.b), shared::sampleCone(u.direction, oneMinusCos));
    const float falloff = SpotFalloff{e.scale, e.offset}.at(glm::dot(p.direction, e.b));
    p.flux = e.radiance * (falloff * scale / shared::pdfCone(oneMinusCos));
    return falloff > 0;
}

/// From far away towards the disk that hides the scene; `irradiance` at normal incidence.
void emitFromAfar(const Scene& scene, const vec3& towards, const vec3& irradiance,
                  const StartNumbers& u, Particle& p)
{
    const float radius = scene.settings.sceneRadius;
    const vec2 disk = shared::sampleDisk(u.direction) * radius;
    p.origin = shared::toWorld(shared::makeFrame(towards), vec3(disk.x, disk.y, 1.01f * radius));
    p.direction = -towards;
    p.flux = irradiance * (shared::kPi * radius * radius);
}

/// Begins a path: false where nothing leaves.
bool emit(const Scene& scene, WaveLights& out, Particle& p)
{
    const StartNumbers u = drawStart(p.stream);
    float pmf = 1;
    const uint32_t emitter =
        shared::chooseEmitter(scene.view, scene.settings.emitterCount, u.choice.x, pmf);
    const shared::Emitter e = shared::fetchEmitter(scene.view, emitter);
    const uint32_t kind = e.kind & 0xffu;
    p.placed = kind == shared::kEmitterTriangle || kind == shared::kEmitterPoint ||
               kind == shared::kEmitterSpot;
    if (kind == shared::kEmitterTriangle) return emitFromTriangle(scene, e, u, 1 / pmf, out, p);
    if (kind == shared::kEmitterPoint || kind == shared::kEmitterSpot)
        return emitFromPoint(e, u, 1 / pmf, p);
    if (kind == shared::kEmitterDirectional) {
        emitFromAfar(scene, e.b, e.radiance / pmf, u, p);
        return true;
    }
    shared::EmitterSample s;
    if (!shared::sampleEmitter(scene.view, scene.settings, emitter, vec3(0), 0, u.point, s))
        return false;
    const vec3 irradiance = s.radiance / (pmf * s.pdf);
    VirtualLight light;
    light.kind = LightKind::directional;
    light.normal = -s.wi;
    light.intensity = irradiance * scene.perPath;
    light.importance = asImportance(light.intensity);
    out.add(light);
    emitFromAfar(scene, s.wi, irradiance, u, p);
    return true;
}

/// The media that paths begin in: along each, beyond all that bounds none, the first boundary
/// tells by the side that is met. Returns the rays traced.
uint64_t findMedia(const Scene& scene, std::span<Particle> particles)
{
    constexpr uint32_t kMostSurfaces = 64;
    const World& world = scene.accel->world();
    std::vector<Particle*> open;
    for (Particle& p : particles)
        if (p.placed) open.push_back(&p);
    std::vector<Ray> rays;
    for (const Particle* p : open) rays.push_back({p->origin, shared::kInfinity, p->direction, 0});
    std::vector<shared::Hit> hits(rays.size());
    uint64_t traced = 0;
    for (uint32_t step = 0; step < kMostSurfaces && !rays.empty(); ++step) {
        scene.accel->closest(rays, hits.data());
        traced += rays.size();
        size_t kept = 0;
        for (size_t i = 0; i < rays.size(); ++i) {
            if (hits[i].slot == shared::kNone) continue;
            const shared::SurfacePoint s =
                shared::makeSurfacePoint(scene.view, hits[i], rays[i].direction);
            if ((world.materials[s.material].flags & shared::kMaterialVolume) != 0) {
                if (s.backFace != 0) open[i]->medium = s.material;
                continue;
            }
            open[kept] = open[i];
            rays[kept++] = {shared::originOnSide(s, -1), shared::kInfinity, rays[i].direction, 0};
        }
        open.resize(kept);
        rays.resize(kept);
    }
    return traced;
}

/// Places the light of a surface that `p` has met.
void placeLight(const Scene& scene, const Particle& p, const Met& met, uint32_t bounces,
                WaveLights& out)
{
    // A Lambertian surface sends the same to all sides but to who is between both horizons, where
    // no more than a square of the angle between them goes.
    constexpr float kWide = 0.15f;
    const shared::Vertex& v = met.v;
    if (shared::isDelta(v.bsdf)) return;
    VirtualLight light;
    light.position = v.surface.position;
    light.normal = met.surface.normal;
    light.bounces = bounces;
    if (shared::isLambert(v.bsdf) && met.angle < kWide) {
        const vec3 arriving = p.flux * (met.correction * scene.perPath);
        light.intensity = arriving * v.bsdf.diffuse * shared::kInvPi;
        light.importance = asImportance(light.intensity);
        out.add(light);
        return;
    }
    const float held = shared::heldCosine(met.surface.incident);
    light.intensity = p.flux * (held / met.arriving * scene.perPath);
    light.bothSides = (v.bsdf.parts & shared::kBsdfTransmission) != 0 ? 1 : 0;
    light.importance =
        asImportance(light.intensity * shared::albedoBsdf(v.bsdf, v.wo) * shared::kInvPi);
    out.add(light, met.surface);
}

/// One surface of one path: places a light and goes on, if it does.
bool meetSurface(const Scene& scene, const shared::Hit& hit, uint32_t bounces, Particle& p,
                 WaveLights& out)
{
    Met met;
    if (!meet(scene.view, hit, p, met)) return false;
    placeLight(scene, p, met, bounces, out);
    // Its next light would be of bounces + 1, and the receiver scatters once more.
    if (bounces + 2 > scene.settings.maxDepth) return false;
    return scatterFlux(met, shared::drawVertexNumbers(p.stream, bounces), p);
}

WaveLights traceWave(const Scene& scene, uint32_t frame, uint32_t first, uint32_t end)
{
    WaveLights out;
    std::array<Particle, kWave> particles;
    std::array<Ray, kWave> rays;
    std::array<shared::Hit, kWave> hits;
    size_t going = 0;
    for (uint32_t path = first; path < end; ++path) {
        Particle& p = particles[going];
        p.stream =
            shared::makeStream(scene.settings.samplerKind, scene.settings.seed,
                               {frame & 0xffffu, frame >> 16}, path, shared::kPurposeLightTracing);
        if (emit(scene, out, p) && scene.settings.maxDepth > 1) ++going;
    }
    if ((scene.accel->world().features & shared::kFeatureVolume) != 0)
        out.set.rays += findMedia(scene, {particles.data(), going});
    for (uint32_t bounces = 1; going > 0; ++bounces) {
        for (size_t i = 0; i < going; ++i)
            rays[i] = {particles[i].origin, shared::kInfinity, particles[i].direction,
                       shared::alphaSeed(particles[i].stream, bounces, 0)};
        scene.accel->closest({rays.data(), going}, hits.data());
        out.set.rays += going;
        size_t kept = 0;
        for (size_t i = 0; i < going; ++i) {
            if (hits[i].slot == shared::kNone) continue;
            if (meetSurface(scene, hits[i], bounces, particles[i], out))
                particles[kept++] = particles[i];
        }
        going = kept;
    }
    return out;
}

bool isPunctual(const shared::Emitter& e)
{
    const uint32_t kind = e.kind & 0xffu;
    return kind >= shared::kEmitterPoint && kind <= shared::kEmitterDirectional;
}

/// Point, spot and directional lights as they are: nothing about them is random.
void addPunctualLights(const Scene& scene, LightSet& set)
{
    for (uint32_t i = 0; i < scene.settings.emitterCount; ++i) {
        const shared::Emitter e = shared::fetchEmitter(scene.view, i);
        if (!isPunctual(e)) continue;
        const uint32_t kind = e.kind & 0xffu;
        VirtualLight light;
        light.kind =
            kind == shared::kEmitterDirectional ? LightKind::directional : LightKind::point;
        light.position = e.a;
        light.normal = kind == shared::kEmitterDirectional ? -e.b : e.b;
        light.intensity = e.radiance;
        light.importance = asImportance(e.radiance);
        if (!isNumber(light)) ++set.dropped;
        if (!(light.importance > 0 && isNumber(light))) continue;
        if (kind == shared::kEmitterSpot) {
            light.detail = static_cast<uint32_t>(set.spots.size());
            set.spots.push_back({e.scale, e.offset});
        }
        set.lights.push_back(light);
    }
}

void append(LightSet& all, LightSet&& part)
{
    const auto firstSurface = static_cast<uint32_t>(all.surfaces.size());
    for (VirtualLight& light : part.lights) {
        if (light.kind == LightKind::surface && light.detail != shared::kNone)
            light.detail += firstSurface;
        all.lights.push_back(light);
    }
    all.surfaces.insert(all.surfaces.end(), part.surfaces.begin(), part.surfaces.end());
    all.rays += part.rays;
    all.dropped += part.dropped;
}

}  // namespace

std::optional<LightSet> traceVirtualLights(const Accel& accel, const shared::PathSettings& settings,
                                           uint32_t frame, uint32_t paths,
                                           const std::stop_token& stop)
{
    const Scene scene{&accel, sceneView(accel.world()), settings,
                      1.0f / static_cast<float>(std::max(paths, 1u))};
    LightSet all;
    if (settings.maxDepth == 0 || settings.emitterCount == 0) return all;
    addPunctualLights(scene, all);
    all.paths = paths;
    std::vector<WaveLights> waves((paths + kWave - 1) / kWave);
    const bool whole = parallelFor(
        waves.size(), 1,
        [&](size_t begin, size_t end) {
            const FlushDenormals flush;
            for (size_t w = begin; w < end; ++w)
                waves[w] =
                    traceWave(scene, frame, static_cast<uint32_t>(w * kWave),
                              static_cast<uint32_t>(std::min<size_t>((w + 1) * kWave, paths)));
        },
        stop);
    if (!whole) return std::nullopt;
    size_t lights = all.lights.size(), surfaces = 0;
    for (const WaveLights& wave : waves) {
        lights += wave.set.lights.size();
        surfaces += wave.set.surfaces.size();
    }
    all.lights.reserve(lights);
    all.surfaces.reserve(surfaces);
    for (WaveLights& wave : waves) append(all, std::move(wave.set));
    return all;
}

bool pathsPlaceLights(const World& world, uint32_t maxDepth)
{
    return maxDepth > 1 || (maxDepth == 1 && !std::ranges::all_of(world.emitters, isPunctual));
}

uint32_t pathsForLights(const LightSet& pilot, uint32_t wanted)
{
    if (pilot.paths == 0) return 0;
    constexpr double kMostPathsPerLight = 64;
    const double most = kMostPathsPerLight * wanted;
    if (pilot.lights.empty()) return static_cast<uint32_t>(most);
    const double perPath = double(pilot.lights.size()) / double(pilot.paths);
    return static_cast<uint32_t>(std::clamp(wanted / perPath, 1.0, most));
}

}  // namespace core::many_lights
