// See bench_rays.h.
#include "app/bench/bench_rays.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <embree3/rtcore.h>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "shared/camera.h"
#include "shared/rng.h"
#include "shared/warp.h"

namespace app {

namespace {

using gpu::DeviceHit;
using gpu::DeviceRay;

constexpr size_t kBlock = 1024;  // rays that a thread takes at a time; a multiple of 16

RTCRayHit toEmbree(const DeviceRay& r)
{
    RTCRayHit h{};
    h.ray = {
        r.origin.x, r.origin.y, r.origin.z, r.tMin, r.direction.x, r.direction.y, r.direction.z, 0,
        r.tMax,     ~0u,        0,          0};
    h.hit.geomID = h.hit.primID = h.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    return h;
}

/// Sixteen rays, the last one repeated and switched off where there are fewer.
struct Packet {
    alignas(64) std::array<int, 16> valid;
    RTCRayHit16 rays;

    Packet(std::span<const DeviceRay> from)
    {
        for (size_t i = 0; i < 16; ++i) {
            valid[i] = i < from.size() ? -1 : 0;
            const DeviceRay& r = from[std::min(i, from.size() - 1)];
            rays.ray.org_x[i] = r.origin.x;
            rays.ray.org_y[i] = r.origin.y;
            rays.ray.org_z[i] = r.origin.z;
            rays.ray.tnear[i] = r.tMin;
            rays.ray.dir_x[i] = r.direction.x;
            rays.ray.dir_y[i] = r.direction.y;
            rays.ray.dir_z[i] = r.direction.z;
            rays.ray.time[i] = 0;
            rays.ray.tfar[i] = r.tMax;
            rays.ray.mask[i] = ~0u;
            rays.ray.id[i] = rays.ray.flags[i] = 0;
            rays.hit.geomID[i] = rays.hit.primID[i] = rays.hit.instID[0][i] =
                RTC_INVALID_GEOMETRY_ID;
        }
    }
};

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

std::vector<DeviceRay> primaryRays(const core::Camera& camera, uint32_t width, uint32_t height)
{
    const shared::CameraData data = core::cameraData(camera, width, height);
    std::vector<DeviceRay> rays;
    for (uint32_t y = 0; y < height; y += 8) {
        for (uint32_t x = 0; x < width; x += 8) {
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

struct EmbreeRays::Impl {
    std::shared_ptr<const core::World> world;
    RTCDevice device = rtcNewDevice(nullptr);
    RTCScene scene = rtcNewScene(device);

    explicit Impl(std::shared_ptr<const core::World> w) : world(std::move(w))
    {
        rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                   world->positions.data(), 0, sizeof(glm::vec3),
                                   world->positions.size() - 1);  // the last is padding
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                   world->triangles.data(), 0, sizeof(core::WorldTriangle),
                                   world->triangles.size());
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene);
        CHECK(rtcGetDeviceError(device) == RTC_ERROR_NONE);
    }
    ~Impl()
    {
        rtcReleaseScene(scene);
        rtcReleaseDevice(device);
    }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;
};

EmbreeRays::EmbreeRays(std::shared_ptr<const core::World> world)
    : impl_(std::make_unique<Impl>(std::move(world)))
{}

EmbreeRays::~EmbreeRays() = default;

void EmbreeRays::closest1(std::span<const DeviceRay> rays, std::span<DeviceHit> hits) const
{
    core::parallelFor(rays.size(), kBlock, [&](size_t begin, size_t end) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        for (size_t i = begin; i < end; ++i) {
            RTCRayHit h = toEmbree(rays[i]);
            rtcIntersect1(impl_->scene, &context, &h);
            hits[i] = {h.ray.tfar, {h.hit.u, h.hit.v}, h.hit.primID};
        }
    });
}

void EmbreeRays::any1(std::span<const DeviceRay> rays, std::span<DeviceHit> hits) const
{
    core::parallelFor(rays.size(), kBlock, [&](size_t begin, size_t end) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        for (size_t i = begin; i < end; ++i) {
            RTCRayHit h = toEmbree(rays[i]);
            rtcOccluded1(impl_->scene, &context, &h.ray);
            hits[i] = {0, glm::vec2(0), h.ray.tfar < 0 ? 1u : 0u};
        }
    });
}

void EmbreeRays::closest16(std::span<const DeviceRay> rays, std::span<DeviceHit> hits) const
{
    core::parallelFor(rays.size(), kBlock, [&](size_t begin, size_t end) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        for (size_t i = begin; i < end; i += 16) {
            const size_t count = std::min<size_t>(16, end - i);
            Packet p(rays.subspan(i, count));
            rtcIntersect16(p.valid.data(), impl_->scene, &context, &p.rays);
            for (size_t k = 0; k < count; ++k) {
                hits[i + k] = {
                    p.rays.ray.tfar[k], {p.rays.hit.u[k], p.rays.hit.v[k]}, p.rays.hit.primID[k]};
            }
        }
    });
}

void EmbreeRays::any16(std::span<const DeviceRay> rays, std::span<DeviceHit> hits) const
{
    core::parallelFor(rays.size(), kBlock, [&](size_t begin, size_t end) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        for (size_t i = begin; i < end; i += 16) {
            const size_t count = std::min<size_t>(16, end - i);
            Packet p(rays.subspan(i, count));
            rtcOccluded16(p.valid.data(), impl_->scene, &context, &p.rays.ray);
            for (size_t k = 0; k < count; ++k) {
                hits[i + k] = {0, glm::vec2(0), p.rays.ray.tfar[k] < 0 ? 1u : 0u};
            }
        }
    });
}

BenchRays makeBenchRays(const core::World& world, const EmbreeRays& embree,
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
    const float step = 1e-5f * glm::length(world.boundsHigh - world.boundsLow);
    for (uint32_t i = 0; i < hits.size(); ++i) {
        if (hits[i].triangle == shared::kNone) continue;
        const core::WorldTriangle& t = world.triangles[hits[i].triangle];
        const DeviceRay& from = rays.primary[i];
        const glm::vec3 a = world.positions[t.v0];
        glm::vec3 n =
            glm::normalize(glm::cross(world.positions[t.v1] - a, world.positions[t.v2] - a));
        if (glm::dot(n, from.direction) > 0) n = -n;
        const glm::vec3 p = from.origin + hits[i].t * from.direction + step * n;
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
