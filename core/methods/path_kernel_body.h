// The loop of the path tracers around the shared estimator (shaders/shared/path.h). One sample of
// each pixel of a tile makes a wave of paths that go on together: rays are traced in packets of 16,
// shading is one path at a time, but for the choice of emitters in their tree. What is not plain at
// a vertex is a parameter. Included once by path_*.cpp and guided_*.cpp, after REKINDLE_FEATURES is
// defined.
#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "core/base/per_thread.h"
#include "core/methods/path_kernel.h"
#include "core/trace/scene_view.h"
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
    static constexpr bool kAllPlain = true;
    /// Path `i` of a wave begins.
    void begin(glm::uvec2, uint32_t, size_t) {}
    /// Whether shared::shadeSurface is all that happens at the vertices of path `i`.
    static constexpr bool isPlain(size_t) { return true; }
    /// In its place where that is not so.
    static bool shade(const shared::VertexNumbers&, const shared::Hit&, size_t, shared::PathState&,
                      shared::ShadowRay&, glm::vec3&)
    {
        return false;
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
    // Plain vertices one after the other, then those that are not: what shades them would otherwise
    // take turns in the processor's caches.
    if constexpr (!Vertices::kAllPlain)
        std::stable_partition(wave.active.begin(), wave.active.begin() + i,
                              [&](uint32_t path) { return vertices.isPlain(path); });
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

/// Asks memory for what the hits after `k` need: those of a wave lie anywhere in a scene, and
/// shading would wait for each.
void prefetchHits(const PathJob& job, const Wave& wave, size_t k)
{
    constexpr size_t kAhead = 8;
    if (k + 2 * kAhead < wave.activeCount)
        prefetchTriangle(job.scene, wave.hits[k + 2 * kAhead].slot);
    if (k + kAhead < wave.activeCount) prefetchVertices(job.scene, wave.hits[k + kAhead].slot);
}

/// The random numbers of the `k`-th active path.
shared::VertexNumbers numbersOf(const Wave& wave, size_t k)
{
    return {{wave.bsdf.x[k], wave.bsdf.y[k]},
            {wave.lobe.x[k], wave.lobe.y[k]},
            {wave.light.x[k], wave.light.y[k]},
            FEATURE(shared::kFeatureManyEmitters) ? wave.choice.x[k] : 0.0f};
}

/// Queues the connection of path `i`, if anything can come of it.
void queueConnection(const PathJob& job, const shared::ShadowRay& shadow, uint32_t i, Wave& wave)
{
    if (shadow.contribution == glm::vec3(0)) return;
    const size_t s = wave.shadowCount++;
    setRay(wave, s, shadow.origin, shadow.direction, shadow.tMax, i, 1);
    wave.contributions[s] = shadow.contribution;
    wave.shadowOwner[s] = i;
    if (shared::passesPanes(job.settings)) wave.shadows[s] = shadow;
}

/// Whether the `k`-th active path has hit nothing; adds what it brings home then.
bool hasMissed(const PathJob& job, Wave& wave, size_t k)
{
    if (wave.hits[k].slot != shared::kNone) return false;
    const uint32_t i = wave.active[k];
    wave.radiance[i] += shared::shadeMiss(job.scene, job.settings, wave.paths[i]);
    return true;
}

/// Shades every active path one after the other; returns how many go on, the first active ones.
template <class Vertices> size_t shadeEach(const PathJob& job, Wave& wave, Vertices& vertices)
{
    size_t going = 0;
    for (size_t k = 0; k < wave.activeCount; ++k) {
        prefetchHits(job, wave, k);
        const uint32_t i = wave.active[k];
        shared::PathState& path = wave.paths[i];
        if (hasMissed(job, wave, k)) continue;
        shared::ShadowRay shadow;
        const shared::VertexNumbers numbers = numbersOf(wave, k);
        const bool goes =
            vertices.isPlain(i)
                ? shared::shadeSurface(job.scene, job.settings, numbers, wave.hits[k], path, shadow,
                                       wave.radiance[i])
                : vertices.shade(numbers, wave.hits[k], i, path, shadow, wave.radiance[i]);
        queueConnection(job, shadow, i, wave);
        if (goes) wave.active[going++] = i;
    }
    return going;
}

/// Vertices whose emitters are chosen together.
struct VertexBlock {
    static constexpr size_t kSize = 8;
    std::array<shared::Vertex, kSize> vertices;
    std::array<shared::VertexNumbers, kSize> numbers;
    std::array<shared::EmitterChoice, kSize> choices;
    std::array<uint32_t, kSize> paths;
    size_t count;
};

/// Shades the active paths from `first` up to their choice of emitters; those that are not plain
/// wholly, and keeps those of them that go on.
template <class Vertices>
void prepareBlock(const PathJob& job, size_t first, Wave& wave, Vertices& vertices, size_t& going,
                  VertexBlock& block)
{
    block.count = 0;
    const size_t end = std::min(first + VertexBlock::kSize, wave.activeCount);
    for (size_t k = first; k < end; ++k) {
        prefetchHits(job, wave, k);
        const uint32_t i = wave.active[k];
        shared::PathState& path = wave.paths[i];
        if (hasMissed(job, wave, k)) continue;
        if (!vertices.isPlain(i)) {
            shared::ShadowRay shadow;
            const bool goes =
                vertices.shade(numbersOf(wave, k), wave.hits[k], i, path, shadow, wave.radiance[i]);
            queueConnection(job, shadow, i, wave);
            if (goes) wave.active[going++] = i;
            continue;
        }
        const size_t b = block.count;
        block.numbers[b] = numbersOf(wave, k);
        block.paths[b] = i;
        if (shared::prepareVertex(job.scene, job.settings, wave.hits[k], path, block.vertices[b],
                                  wave.radiance[i]))
            ++block.count;
    }
}

/// Takes all choices of the block down the tree, one step of each in turn: a step is short, and
/// each waits for memory and for the one before it.
void chooseTogether(const PathJob& job, VertexBlock& block)
{
    std::array<glm::vec3, VertexBlock::kSize> normals;
    std::array<bool, VertexBlock::kSize> oneSided;
    std::array<uint8_t, VertexBlock::kSize> open;
    size_t openCount = 0;
    for (size_t b = 0; b < block.count; ++b) {
        const shared::Vertex& vertex = block.vertices[b];
        block.choices[b] =
            shared::beginConnection(job.scene, job.settings, block.numbers[b], vertex);
        oneSided[b] = shared::unpackReceiver(shared::receiverOf(job.settings, vertex), normals[b]);
        if (block.choices[b].word != shared::kNone) open[openCount++] = uint8_t(b);
    }
    while (openCount > 0) {
        size_t left = 0;
        for (size_t n = 0; n < openCount; ++n) {
            const uint8_t b = open[n];
            shared::stepInTree(job.scene, block.vertices[b].surface.position, oneSided[b],
                               normals[b], block.choices[b]);
            if (block.choices[b].word != shared::kNone) open[left++] = b;
        }
        openCount = left;
    }
}

/// shadeEach by blocks: where emitters are chosen in their tree.
template <class Vertices> size_t shadeBlocks(const PathJob& job, Wave& wave, Vertices& vertices)
{
    VertexBlock& block = perThread<VertexBlock>();
    size_t going = 0;
    for (size_t first = 0; first < wave.activeCount; first += VertexBlock::kSize) {
        prepareBlock(job, first, wave, vertices, going, block);
        chooseTogether(job, block);
        for (size_t b = 0; b < block.count; ++b) {
            const uint32_t i = block.paths[b];
            shared::ShadowRay shadow;
            const bool goes =
                shared::leaveVertex(job.scene, job.settings, block.choices[b], block.numbers[b],
                                    block.vertices[b], wave.paths[i], shadow);
            queueConnection(job, shadow, i, wave);
            if (goes) wave.active[going++] = i;
        }
    }
    return going;
}

/// Shades every active path; keeps those that go on and queues connections to emitters.
template <class Vertices> void shadeWave(const PathJob& job, Wave& wave, Vertices& vertices)
{
    drawNumbers(wave);
    wave.shadowCount = 0;
    // Known when this is compiled: with both in one program compilers leave vertices in memory.
    if constexpr (FEATURE(shared::kFeatureEmitterTree))
        wave.activeCount = shadeBlocks(job, wave, vertices);
    else
        wave.activeCount = shadeEach(job, wave, vertices);
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
