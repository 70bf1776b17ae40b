// The loop of the path tracers around the shared estimator (shaders/shared/path.h). One sample of
// each pixel of a tile makes a wave of paths that go on together: rays are traced in packets of 16,
// shading is one path at a time. What a vertex does is a parameter, PlainVertices by default.
// Included once by each path_*.cpp and guided_*.cpp, after REKINDLE_FEATURES is defined.
#include <array>
#include <cmath>
#include <span>

#include "core/base/per_thread.h"
#include "core/methods/path_kernel.h"
#include "shared/path.h"

namespace core {

namespace {

constexpr size_t kWave = size_t(kFilmTile) * kFilmTile;

/// A pattern of the sampler at many paths.
struct Pattern {
    std::array<float, kWave> x, y;
};

/// The paths of one wave; `active` lists those that go on, in order.
struct Wave {
    std::array<shared::PathState, kWave> paths;
    shared::SampleStream stream;  // of every path, but for its pixel
    std::array<uint32_t, kWave> pixels;
    std::array<uint32_t, kWave> drawPixels;  // of the active paths, one after the other
    Pattern bsdf, lobe, light, choice;
    std::array<glm::vec3, kWave> radiance;
    std::array<uint32_t, kWave> active;
    std::array<Ray, kWave> rays;
    std::array<shared::Hit, kWave> hits;
    std::array<glm::vec3, kWave> contributions;  // of the shadow rays
    std::array<uint32_t, kWave> shadowOwner;
    std::array<shared::ShadowRay, kWave> shadows;  // where there are panes
    std::array<uint8_t, kWave> blocked;
    size_t activeCount, shadowCount;
    uint32_t depth;  // of all active paths
};

/// Draws one pattern for `count` pixels: a loop that compilers turn into vectors, which is why it
/// is apart.
[[gnu::flatten]] void drawPattern(uint32_t kind, shared::SampleStream stream, uint32_t dimension,
                                  const uint32_t* pixels, size_t count, Pattern& pattern)
{
    stream.kind = kind;
    for (size_t k = 0; k < count; ++k) {
        stream.pixel = pixels[k];
        const glm::vec2 u = shared::streamVec2(stream, dimension);
        pattern.x[k] = u.x;
        pattern.y[k] = u.y;
    }
}

/// Draws one pattern for the active paths.
void drawForActive(Wave& wave, uint32_t dimension, Pattern& pattern)
{
    // Two calls with a constant kind: the choice stays out of the loop.
    const uint32_t* pixels = wave.drawPixels.data();
    if (wave.stream.kind == shared::kSamplerSobol) {
        drawPattern(shared::kSamplerSobol, wave.stream, dimension, pixels, wave.activeCount,
                    pattern);
    } else {
        drawPattern(shared::kSamplerIndependent, wave.stream, dimension, pixels, wave.activeCount,
                    pattern);
    }
}

/// What drawVertexNumbers gives, for all active paths; they are at the same depth.
void drawNumbers(Wave& wave)
{
    for (size_t k = 0; k < wave.activeCount; ++k) wave.drawPixels[k] = wave.pixels[wave.active[k]];
    const uint32_t dimension = shared::kDimensionPath + wave.depth * shared::kDimensionsPerVertex;
    drawForActive(wave, dimension + shared::kDimensionBsdf, wave.bsdf);
    drawForActive(wave, dimension + shared::kDimensionLobe, wave.lobe);
    drawForActive(wave, dimension + shared::kDimensionLight, wave.light);
    if (FEATURE(shared::kFeatureManyEmitters)) {
        drawForActive(wave, dimension + shared::kDimensionLightChoice, wave.choice);
    }
}

shared::SampleStream streamOf(const Wave& wave, size_t i)
{
    shared::SampleStream stream = wave.stream;
    stream.pixel = wave.pixels[i];
    return stream;
}

/// What a method does at the vertices of paths: this one what the shared text says.
struct PlainVertices {
    /// Path `i` of a wave begins.
    void begin(glm::uvec2, uint32_t, size_t) {}
    /// shared::shadeSurface, of path `i`.
    bool shade(const PathJob& job, const shared::VertexNumbers& numbers, const shared::Hit& hit,
               size_t, shared::PathState& path, shared::ShadowRay& shadow, glm::vec3& L)
    {
        return shared::shadeSurface(job.scene, job.settings, numbers, hit, path, shadow, L);
    }
    /// The connections of this depth are in `radiance`.
    void connected(std::span<const glm::vec3>) {}
    /// All paths of the wave have ended.
    void end(std::span<const glm::vec3>) {}
};

template <class Vertices>
void beginWave(const PathJob& job, const Tile& tile, uint32_t sample, Wave& wave,
               Vertices& vertices)
{
    size_t i = 0;
    for (uint32_t y = tile.y0; y < tile.y1; ++y) {
        for (uint32_t x = tile.x0; x < tile.x1; ++x, ++i) {
            const glm::uvec2 pixel(x, y);
            wave.stream = shared::makeStream(job.settings.samplerKind, job.settings.seed, pixel,
                                             sample, shared::kPurposePath);
            wave.pixels[i] = wave.stream.pixel;
            wave.paths[i] = shared::beginPath(job.camera, job.settings, pixel, wave.stream);
            wave.radiance[i] = glm::vec3(0);
            wave.active[i] = static_cast<uint32_t>(i);
            vertices.begin(pixel, sample, i);
        }
    }
    wave.activeCount = i;
    wave.depth = 0;
}

/// Sets one ray of the wave, from path `i`; `shadow` 1 for the connection to an emitter.
void setRay(Wave& wave, size_t slot, const glm::vec3& origin, const glm::vec3& direction,
            float tMax, size_t i, uint32_t shadow)
{
    Ray& ray = wave.rays[slot];
    ray.origin = origin;
    ray.direction = direction;
    ray.tMax = tMax;
    ray.seed = FEATURE(shared::kFeatureAlpha)
                   ? shared::alphaSeed(streamOf(wave, i), wave.depth, shadow)
                   : 0u;
}

void traceWave(const PathJob& job, Wave& wave)
{
    for (size_t k = 0; k < wave.activeCount; ++k) {
        const uint32_t i = wave.active[k];
        setRay(wave, k, wave.paths[i].origin, wave.paths[i].direction, shared::kInfinity, i, 0);
    }
    job.accel->closest({wave.rays.data(), wave.activeCount}, wave.hits.data(), wave.depth == 0);
}

/// Shades every active path; keeps those that go on and queues connections to emitters.
template <class Vertices> void shadeWave(const PathJob& job, Wave& wave, Vertices& vertices)
{
    drawNumbers(wave);
    size_t going = 0;
    wave.shadowCount = 0;
    for (size_t k = 0; k < wave.activeCount; ++k) {
        const uint32_t i = wave.active[k];
        shared::PathState& path = wave.paths[i];
        if (wave.hits[k].slot == shared::kNone) {
            wave.radiance[i] += shared::shadeMiss(job.scene, job.settings, path);
            continue;
        }
        const shared::VertexNumbers numbers{{wave.bsdf.x[k], wave.bsdf.y[k]},
                                            {wave.lobe.x[k], wave.lobe.y[k]},
                                            {wave.light.x[k], wave.light.y[k]},
                                            FEATURE(shared::kFeatureManyEmitters) ? wave.choice.x[k]
                                                                                  : 0.0f};
        shared::ShadowRay shadow;
        const bool goes =
            vertices.shade(job, numbers, wave.hits[k], i, path, shadow, wave.radiance[i]);
        if (shadow.contribution != glm::vec3(0)) {
            const size_t s = wave.shadowCount++;
            setRay(wave, s, shadow.origin, shadow.direction, shadow.tMax, i, 1);
            wave.contributions[s] = shadow.contribution;
            wave.shadowOwner[s] = i;
            if (shared::passesPanes(job.settings)) wave.shadows[s] = shadow;
        }
        if (goes) wave.active[going++] = i;
    }
    wave.activeCount = going;
    ++wave.depth;
}

/// Takes connections that met something on to the nearest surface, and from behind it if that is a
/// pane. Returns how many rays were traced.
uint64_t connectThroughPanes(const PathJob& job, Wave& wave)
{
    uint64_t rays = 0;
    while (wave.shadowCount > 0) {
        rays += wave.shadowCount;
        job.accel->closest({wave.rays.data(), wave.shadowCount}, wave.hits.data());
        size_t kept = 0;
        for (size_t s = 0; s < wave.shadowCount; ++s) {
            shared::ShadowRay shadow = wave.shadows[s];
            const uint32_t owner = wave.shadowOwner[s];
            if (wave.hits[s].slot == shared::kNone) {
                wave.radiance[owner] += shadow.contribution;
                continue;
            }
            if (!shared::passPane(job.scene, wave.hits[s], shadow)) continue;
            const uint32_t seed = wave.rays[s].seed;
            wave.rays[kept] = {shadow.origin, shadow.tMax, shadow.direction, seed};
            wave.shadows[kept] = shadow;
            wave.shadowOwner[kept++] = owner;
        }
        wave.shadowCount = kept;
    }
    return rays;
}

/// Returns how many rays were traced.
uint64_t connectWave(const PathJob& job, Wave& wave)
{
    job.accel->occluded({wave.rays.data(), wave.shadowCount}, wave.blocked.data());
    const size_t count = wave.shadowCount;
    size_t kept = 0;
    for (size_t s = 0; s < count; ++s) {
        if (wave.blocked[s] == 0) {
            wave.radiance[wave.shadowOwner[s]] += wave.contributions[s];
        } else if (shared::passesPanes(job.settings) && job.accel->meetsPane(wave.rays[s])) {
            wave.rays[kept] = wave.rays[s];
            wave.shadows[kept] = wave.shadows[s];
            wave.shadowOwner[kept++] = wave.shadowOwner[s];
        }
    }
    wave.shadowCount = kept;
    return count + connectThroughPanes(job, wave);
}

void addToFilm(const Wave& wave, const Tile& tile, Film& film, FilmCounters& counters)
{
    size_t i = 0;
    for (uint32_t y = tile.y0; y < tile.y1; ++y) {
        for (uint32_t x = tile.x0; x < tile.x1; ++x, ++i) {
            film.add(size_t(y) * film.width + x, wave.radiance[i], counters);
        }
    }
}

template <class Vertices = PlainVertices>
TileTally renderTile(const PathJob& job, const Tile& tile, Film& film, Vertices vertices = {})
{
    TileTally tally;
    Wave& wave = perThread<Wave>();
    for (uint32_t sample = 0; sample < job.sampleCount; ++sample) {
        beginWave(job, tile, job.firstSample + sample, wave, vertices);
        while (wave.activeCount > 0) {
            tally.rays += wave.activeCount;
            traceWave(job, wave);
            shadeWave(job, wave, vertices);
            tally.rays += connectWave(job, wave);
            vertices.connected(wave.radiance);
        }
        vertices.end(wave.radiance);
        addToFilm(wave, tile, film, tally.counters);
        tally.paths += uint64_t(tile.x1 - tile.x0) * (tile.y1 - tile.y0);
    }
    return tally;
}

}  // namespace

}  // namespace core
