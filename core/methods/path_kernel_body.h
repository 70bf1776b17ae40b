// The loop of the path tracer around the shared estimator (shaders/shared/path.h). One sample of
// each pixel of a tile makes a wave of paths that go on together: rays are traced in packets of 16,
// shading is one path at a time. Included once by each path_*.cpp, after REKINDLE_FEATURES is
// defined.
#include <array>
#include <cmath>

#include "core/methods/path_kernel.h"
#include "shared/path.h"

namespace core {

namespace {

constexpr size_t kWave = size_t(kPathTile) * kPathTile;

/// The paths of one wave; `active` lists those that go on, in order.
struct Wave {
    std::array<shared::PathState, kWave> paths;
    std::array<shared::SampleStream, kWave> streams;
    std::array<glm::vec3, kWave> radiance;
    std::array<uint32_t, kWave> active;
    std::array<Ray, kWave> rays;
    std::array<shared::Hit, kWave> hits;
    std::array<glm::vec3, kWave> contributions;  // of the shadow rays
    std::array<uint32_t, kWave> shadowOwner;
    std::array<uint8_t, kWave> blocked;
    size_t count = 0, activeCount = 0, shadowCount = 0;
};

void beginWave(const PathJob& job, const Tile& tile, uint32_t sample, Wave& wave)
{
    size_t i = 0;
    for (uint32_t y = tile.y0; y < tile.y1; ++y) {
        for (uint32_t x = tile.x0; x < tile.x1; ++x, ++i) {
            const glm::uvec2 pixel(x, y);
            wave.streams[i] =
                shared::makeStream(job.settings.samplerKind, job.settings.seed, pixel, sample);
            wave.paths[i] = shared::beginPath(job.camera, job.settings, pixel, wave.streams[i]);
            wave.radiance[i] = glm::vec3(0);
            wave.active[i] = static_cast<uint32_t>(i);
        }
    }
    wave.count = wave.activeCount = i;
}

Ray makeRay(const glm::vec3& origin, const glm::vec3& direction, float tMax,
            const shared::SampleStream& stream, uint32_t depth, uint32_t shadow)
{
    return {origin, tMax, direction,
            FEATURE(shared::kFeatureAlpha) ? shared::alphaSeed(stream, depth, shadow) : 0u};
}

void traceWave(const PathJob& job, Wave& wave)
{
    for (size_t k = 0; k < wave.activeCount; ++k) {
        const uint32_t i = wave.active[k];
        const shared::PathState& path = wave.paths[i];
        wave.rays[k] =
            makeRay(path.origin, path.direction, shared::kInfinity, wave.streams[i], path.depth, 0);
    }
    job.accel->closest({wave.rays.data(), wave.activeCount}, wave.hits.data());
}

/// Shades every active path; keeps those that go on and queues connections to emitters.
void shadeWave(const PathJob& job, Wave& wave)
{
    size_t going = 0;
    wave.shadowCount = 0;
    for (size_t k = 0; k < wave.activeCount; ++k) {
        const uint32_t i = wave.active[k];
        shared::PathState& path = wave.paths[i];
        if (wave.hits[k].slot == shared::kNone) {
            wave.radiance[i] += shared::shadeMiss(job.scene, job.settings, path);
            continue;
        }
        shared::ShadowRay shadow;
        const uint32_t depth = path.depth;
        const bool goes = shared::shadeSurface(job.scene, job.settings, wave.streams[i],
                                               wave.hits[k], path, shadow, wave.radiance[i]);
        if (shared::maxComponent(shadow.contribution) > 0.0f) {
            const size_t s = wave.shadowCount++;
            wave.rays[s] =
                makeRay(shadow.origin, shadow.direction, shadow.tMax, wave.streams[i], depth, 1);
            wave.contributions[s] = shadow.contribution;
            wave.shadowOwner[s] = i;
        }
        if (goes) wave.active[going++] = i;
    }
    wave.activeCount = going;
}

void connectWave(const PathJob& job, Wave& wave)
{
    job.accel->occluded({wave.rays.data(), wave.shadowCount}, wave.blocked.data());
    for (size_t s = 0; s < wave.shadowCount; ++s) {
        if (wave.blocked[s] == 0) wave.radiance[wave.shadowOwner[s]] += wave.contributions[s];
    }
}

/// A sample that is not a colour is counted and left out.
bool isColour(const glm::vec3& L, FilmCounters& counters)
{
    if (std::isnan(L.x) || std::isnan(L.y) || std::isnan(L.z)) {
        ++counters.nan;
        return false;
    }
    if (std::isinf(L.x) || std::isinf(L.y) || std::isinf(L.z)) {
        ++counters.inf;
        return false;
    }
    if (L.x < 0 || L.y < 0 || L.z < 0) {
        ++counters.negative;
        return false;
    }
    return true;
}

void addToFilm(const Wave& wave, const Tile& tile, Film& film, FilmCounters& counters)
{
    size_t i = 0;
    for (uint32_t y = tile.y0; y < tile.y1; ++y) {
        for (uint32_t x = tile.x0; x < tile.x1; ++x, ++i) {
            if (!isColour(wave.radiance[i], counters)) continue;
            const glm::dvec3 L(wave.radiance[i]);
            const size_t pixel = size_t(y) * film.width + x;
            film.sum[pixel] += L;
            film.sumOfSquares[pixel] += L * L;
        }
    }
}

PathTally renderTile(const PathJob& job, const Tile& tile, Film& film)
{
    PathTally tally;
    Wave wave;
    for (uint32_t sample = 0; sample < job.sampleCount; ++sample) {
        beginWave(job, tile, job.firstSample + sample, wave);
        while (wave.activeCount > 0) {
            tally.rays += wave.activeCount;
            traceWave(job, wave);
            shadeWave(job, wave);
            tally.rays += wave.shadowCount;
            connectWave(job, wave);
        }
        addToFilm(wave, tile, film, tally.counters);
    }
    return tally;
}

}  // namespace

}  // namespace core
