// See embree_rays.h.
#include "core/trace/embree_rays.h"

#include <algorithm>
#include <array>
#include <string>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/trace/embree.h"

namespace core {

namespace {

constexpr size_t kBlock = 1024;  // rays that a thread takes at a time; a multiple of 16

RTCRayHit toEmbree(const RaySegment& r)
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

    Packet(std::span<const RaySegment> from)
    {
        for (size_t i = 0; i < 16; ++i) {
            valid[i] = i < from.size() ? -1 : 0;
            const RaySegment& r = from[std::min(i, from.size() - 1)];
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

}  // namespace

struct EmbreeRays::Impl {
    std::shared_ptr<const World> world;
    RTCDevice device = rtcNewDevice(nullptr);
    RTCScene scene = rtcNewScene(device);

    explicit Impl(std::shared_ptr<const World> w) : world(std::move(w))
    {
        // Vertices of prototypes are in spaces of their own.
        CHECK(world->prototypes.empty());
        rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                   world->positions.data(), 0, sizeof(glm::vec3),
                                   world->positions.size() - 1);  // the last is padding
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                   world->triangles.data(), 0, sizeof(WorldTriangle),
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

EmbreeRays::EmbreeRays(std::shared_ptr<const World> world)
    : impl_(std::make_unique<Impl>(std::move(world)))
{}

EmbreeRays::~EmbreeRays() = default;

void EmbreeRays::closest1(std::span<const RaySegment> rays, std::span<SegmentHit> hits) const
{
    parallelFor(rays.size(), kBlock, [&](size_t begin, size_t end) {
        EmbreeQuery query;
        for (size_t i = begin; i < end; ++i) {
            RTCRayHit h = toEmbree(rays[i]);
            query.closest(impl_->scene, h);
            hits[i] = {h.ray.tfar, {h.hit.u, h.hit.v}, h.hit.primID};
        }
    });
}

void EmbreeRays::any1(std::span<const RaySegment> rays, std::span<SegmentHit> hits) const
{
    parallelFor(rays.size(), kBlock, [&](size_t begin, size_t end) {
        EmbreeQuery query;
        for (size_t i = begin; i < end; ++i) {
            RTCRayHit h = toEmbree(rays[i]);
            query.any(impl_->scene, h.ray);
            hits[i] = {0, glm::vec2(0), h.ray.tfar < 0 ? 1u : 0u};
        }
    });
}

void EmbreeRays::closest16(std::span<const RaySegment> rays, std::span<SegmentHit> hits) const
{
    parallelFor(rays.size(), kBlock, [&](size_t begin, size_t end) {
        EmbreeQuery query;
        for (size_t i = begin; i < end; i += 16) {
            const size_t count = std::min<size_t>(16, end - i);
            Packet p(rays.subspan(i, count));
            query.closest(p.valid.data(), impl_->scene, p.rays);
            for (size_t k = 0; k < count; ++k) {
                hits[i + k] = {
                    p.rays.ray.tfar[k], {p.rays.hit.u[k], p.rays.hit.v[k]}, p.rays.hit.primID[k]};
            }
        }
    });
}

void EmbreeRays::any16(std::span<const RaySegment> rays, std::span<SegmentHit> hits) const
{
    parallelFor(rays.size(), kBlock, [&](size_t begin, size_t end) {
        EmbreeQuery query;
        for (size_t i = begin; i < end; i += 16) {
            const size_t count = std::min<size_t>(16, end - i);
            Packet p(rays.subspan(i, count));
            query.any(p.valid.data(), impl_->scene, p.rays.ray);
            for (size_t k = 0; k < count; ++k) {
                hits[i + k] = {0, glm::vec2(0), p.rays.ray.tfar[k] < 0 ? 1u : 0u};
            }
        }
    });
}

EmbreeVersion embreeVersion()
{
    EmbreeVersion version{RTC_VERSION_STRING, ""};
    RTCDevice device = rtcNewDevice("threads=1");  // without one Embree does not tell
    if (!device) return version;
    const ssize_t number = rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION);
    version.running = std::to_string(number / 10000) + '.' + std::to_string(number / 100 % 100) +
                      '.' + std::to_string(number % 100);
    rtcReleaseDevice(device);
    return version;
}

}  // namespace core
