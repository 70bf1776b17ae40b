// See bench_rays.h.
#include "app/bench/throughput/bench_rays.h"

#include <algorithm>
#include <cmath>

#include "shared/camera.h"
#include "shared/rng.h"
#include "shared/warp.h"

namespace app {

namespace {

using gpu::DeviceHit;
using gpu::DeviceRay;

/// Four numbers in [0,1) for ray i.
glm::vec4 randomOf(uint32_t i, uint32_t purpose)
{
    const glm::uvec4 bits = shared::pcg4d(glm::uvec4(i, purpose, 0x9e3779b9u, 1));
    return {shared::unitFloat(bits.x), shared::unitFloat(bits.y), shared::unitFloat(bits.z),
            shared::unitFloat(bits.w)};
}

uint32_t everyOtherBit(uint32_t x)
{
    return (x & 1u) | ((x >> 1u) & 2u) | ((x >> 2u) & 4u);
}

// Below what devices must take in one dispatch, and plenty for a rate.
constexpr uint64_t kMostRays = uint64_t(1) << 21;

std::vector<DeviceRay> primaryRays(const core::Camera& camera, uint32_t width, uint32_t height)
{
    const shared::CameraData data = core::cameraData(camera, width, height);
    const uint64_t tiles = uint64_t((width + 7) / 8) * ((height + 7) / 8);
    const uint64_t stride = (64 * tiles + kMostRays - 1) / kMostRays;
    std::vector<DeviceRay> rays;
    uint64_t tile = 0;
    for (uint32_t y = 0; y < height; y += 8) {
        for (uint32_t x = 0; x < width; x += 8) {
            if (tile++ % stride != 0) continue;
            for (uint32_t m = 0; m < 64; ++m) {
                const glm::uvec2 pixel(x + everyOtherBit(m), y + everyOtherBit(m >> 1u));
                if (pixel.x >= width || pixel.y >= height) continue;
                const glm::vec4 u = randomOf(pixel.y * width + pixel.x, 0);
                DeviceRay ray;
                shared::cameraRay(data, glm::vec2(pixel) + glm::vec2(u.x, u.y),
                                  glm::vec2(width, height), glm::vec2(u.z, u.w), ray.origin,
                                  ray.direction);
                rays.push_back(ray);
            }
        }
    }
    return rays;
}

/// A point on a triangle, uniform in its area.
glm::vec3 pointOn(const core::World& world, uint32_t triangle, float u, float v)
{
    const core::WorldTriangle& t = world.triangles[triangle];
    const float s = std::sqrt(u);
    return world.positions[t.v0] * (1 - s) + world.positions[t.v1] * (s * (1 - v)) +
           world.positions[t.v2] * (s * v);
}

}  // namespace

BenchRays makeBenchRays(const core::World& world, const core::EmbreeRays& embree,
                        const core::Camera& camera, uint32_t width, uint32_t height)
{
    BenchRays rays;
    rays.primary = primaryRays(camera, width, height);
    std::vector<DeviceHit> hits(rays.primary.size());
    embree.closest1(rays.primary, hits);
    std::vector<uint32_t> emitting;
    for (uint32_t i = 0; i < world.triangleEmitter.size(); ++i) {
        if (world.triangleEmitter[i] != shared::kNone) emitting.push_back(i);
    }
    for (uint32_t i = 0; i < hits.size(); ++i) {
        if (hits[i].triangle == shared::kNone) continue;
        const core::WorldTriangle& t = world.triangles[hits[i].triangle];
        const DeviceRay& from = rays.primary[i];
        const glm::vec3 a = world.positions[t.v0];
        glm::vec3 n =
            glm::normalize(glm::cross(world.positions[t.v1] - a, world.positions[t.v2] - a));
        if (glm::dot(n, from.direction) > 0) n = -n;
        const glm::vec3 at = from.origin + hits[i].t * from.direction;
        // By the place, not by the scene: a ground of kilometres lifts no ray off a table.
        const glm::vec3 p = at + 1e-5f * (hits[i].t + glm::length(at)) * n;
        const glm::mat3 frame = shared::makeFrame(n);
        const glm::vec4 u = randomOf(i, 1), v = randomOf(i, 2);
        const auto cosine = [&](glm::vec2 w) {
            return shared::toWorld(frame, shared::sampleCosineHemisphere(w));
        };
        rays.bounce.push_back({p, 0, cosine({u.x, u.y}), shared::kInfinity});
        if (emitting.empty()) {
            rays.shadow.push_back({p, 0, cosine({u.z, u.w}), shared::kInfinity});
            continue;
        }
        const size_t pick = static_cast<size_t>(v.x * static_cast<float>(emitting.size()));
        const glm::vec3 d =
            pointOn(world, emitting[std::min(pick, emitting.size() - 1)], v.y, v.z) - p;
        if (glm::dot(d, n) > 0) rays.shadow.push_back({p, 0, d, 0.9999f});
    }
    return rays;
}

}  // namespace app
