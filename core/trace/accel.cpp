// Rays through the scenes of accel_scenes.h.
#include "core/trace/accel.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "core/base/check.h"
#include "core/base/time.h"
#include "core/trace/accel_scenes.h"
#include "core/trace/embree.h"

namespace core {

namespace {

/// Embree must not be given rays that are not finite (Debian's build asserts): they hit nothing.
bool isTraceable(const Ray& ray)
{
    const glm::vec3 size = glm::abs(ray.origin) + glm::abs(ray.direction);
    return size.x + size.y + size.z < 1e18f && ray.tMax > 0.0f;
}

}  // namespace

Accel::Accel(std::shared_ptr<const World> world,
             const std::function<void(const char*, double)>& progress, std::stop_token stop,
             AccelQuality quality)
    : scenes_(std::make_unique<AccelScenes>(std::move(world)))
{
    const Clock::time_point start = Clock::now();
    scenes_->build(progress, std::move(stop), quality);
    scenes_->buildSeconds = secondsSince(start);
}

void Accel::setPose(std::shared_ptr<const World> world,
                    const std::function<void(const char*, double)>& progress, std::stop_token stop)
{
    const Clock::time_point start = Clock::now();
    scenes_->setPose(std::move(world), progress, std::move(stop));
    scenes_->buildSeconds = secondsSince(start);
}

Accel::~Accel() = default;

bool Accel::closest(const Ray& ray, shared::Hit& hit) const
{
    if (!isTraceable(ray)) return false;
    EmbreeQuery query;
    RTCRayHit r;
    r.ray = {ray.origin.x,    ray.origin.y,    ray.origin.z,    0.0f,
             ray.direction.x, ray.direction.y, ray.direction.z, 0.0f,
             ray.tMax,        0xffffffffu,     ray.seed,        0};
    r.hit.geomID = r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    if (scenes_->still) query.closest(scenes_->still, r);
    if (scenes_->moving) query.closest(scenes_->moving, r);
    hit.slot = scenes_->slotOf(r.hit.geomID, r.hit.primID, r.hit.instID[0]);
    if (hit.slot == shared::kNone) return false;
    hit.t = r.ray.tfar;
    hit.barycentrics = {r.hit.u, r.hit.v};
    return true;
}

bool Accel::occluded(const Ray& ray) const
{
    if (!isTraceable(ray)) return false;
    EmbreeQuery query;
    RTCRay r{ray.origin.x,    ray.origin.y,    ray.origin.z,    0.0f,
             ray.direction.x, ray.direction.y, ray.direction.z, 0.0f,
             ray.tMax,        0xffffffffu,     ray.seed,        0};
    if (scenes_->still) query.any(scenes_->still, r);
    if (scenes_->moving && !(r.tfar < 0.0f)) query.any(scenes_->moving, r);
    return r.tfar < 0.0f;
}

bool Accel::meetsPane(const Ray& ray) const
{
    if (!scenes_->panes || !isTraceable(ray)) return false;
    EmbreeQuery query;
    RTCRay r{ray.origin.x,    ray.origin.y,    ray.origin.z,    0.0f,
             ray.direction.x, ray.direction.y, ray.direction.z, 0.0f,
             ray.tMax,        0xffffffffu,     ray.seed,        0};
    query.any(scenes_->panes, r);
    return r.tfar < 0.0f;
}

namespace {

constexpr size_t kPacket = 16;

/// Where processors lack vectors of sixteen, Embree takes packets apart and tells idle lanes by
/// their empty interval alone; whatever else is in them must be numbers.
void switchOff(RTCRay16& packet, int* valid, size_t lane)
{
    valid[lane] = 0;
    for (float* lanes :
         {packet.org_x, packet.org_y, packet.org_z, packet.dir_x, packet.dir_y, packet.dir_z})
        lanes[lane] = 0;
    packet.tfar[lane] = -std::numeric_limits<float>::infinity();
}

/// Fills lanes [0, count) of a packet; the others are switched off.
void fillPacket(std::span<const Ray> rays, int* valid, RTCRay16& packet)
{
    for (size_t i = 0; i < kPacket; ++i) {
        packet.tnear[i] = packet.time[i] = 0.0f;
        packet.mask[i] = 0xffffffffu;
        packet.flags[i] = packet.id[i] = 0;
        if (i >= rays.size() || !isTraceable(rays[i])) {
            switchOff(packet, valid, i);
            continue;
        }
        const Ray& ray = rays[i];
        valid[i] = -1;
        packet.org_x[i] = ray.origin.x;
        packet.org_y[i] = ray.origin.y;
        packet.org_z[i] = ray.origin.z;
        packet.dir_x[i] = ray.direction.x;
        packet.dir_y[i] = ray.direction.y;
        packet.dir_z[i] = ray.direction.z;
        packet.tfar[i] = ray.tMax;
        packet.id[i] = ray.seed;
    }
}

}  // namespace

void Accel::closest(std::span<const Ray> rays, shared::Hit* hits, bool coherent) const
{
    EmbreeQuery query(coherent);
    alignas(64) int valid[kPacket];
    RTCRayHit16 packet;
    for (size_t first = 0; first < rays.size(); first += kPacket) {
        const size_t count = std::min(kPacket, rays.size() - first);
        fillPacket(rays.subspan(first, count), valid, packet.ray);
        std::fill_n(packet.hit.geomID, kPacket, RTC_INVALID_GEOMETRY_ID);
        std::fill_n(packet.hit.instID[0], kPacket, RTC_INVALID_GEOMETRY_ID);
        if (scenes_->still) query.closest(valid, scenes_->still, packet);
        if (scenes_->moving) query.closest(valid, scenes_->moving, packet);
        for (size_t i = 0; i < count; ++i) {
            shared::Hit& hit = hits[first + i];
            hit.t = packet.ray.tfar[i];
            hit.barycentrics = {packet.hit.u[i], packet.hit.v[i]};
            hit.slot = scenes_->slotOf(packet.hit.geomID[i], packet.hit.primID[i],
                                       packet.hit.instID[0][i]);
        }
    }
}

void Accel::occluded(std::span<const Ray> rays, uint8_t* blocked) const
{
    EmbreeQuery query;
    alignas(64) int valid[kPacket];
    RTCRay16 packet;
    for (size_t first = 0; first < rays.size(); first += kPacket) {
        const size_t count = std::min(kPacket, rays.size() - first);
        fillPacket(rays.subspan(first, count), valid, packet);
        if (scenes_->still) query.any(valid, scenes_->still, packet);
        if (scenes_->moving) {
            for (size_t i = 0; i < kPacket; ++i) valid[i] = packet.tfar[i] < 0.0f ? 0 : valid[i];
            query.any(valid, scenes_->moving, packet);
        }
        for (size_t i = 0; i < count; ++i)
            blocked[first + i] = packet.tfar[i] < 0.0f && isTraceable(rays[first + i]);
    }
}

uint32_t Accel::occluded(const RayPacket& rays, uint32_t count) const
{
    static_assert(RayPacket::kSize == kPacket);
    EmbreeQuery query(scenes_->shadowsMayBeCoherent);
    alignas(64) int valid[kPacket];
    RTCRay16 packet;
    const auto copy = [](const auto& from, auto& to) { std::memcpy(to, from.data(), sizeof(to)); };
    copy(rays.originX, packet.org_x);
    copy(rays.originY, packet.org_y);
    copy(rays.originZ, packet.org_z);
    copy(rays.directionX, packet.dir_x);
    copy(rays.directionY, packet.dir_y);
    copy(rays.directionZ, packet.dir_z);
    copy(rays.tMax, packet.tfar);
    copy(rays.seed, packet.id);
    for (uint32_t i = 0; i < kPacket; ++i) {
        valid[i] = -1;
        packet.tnear[i] = packet.time[i] = 0;
        packet.mask[i] = 0xffffffffu;
        packet.flags[i] = 0;
    }
    for (size_t i = count; i < kPacket; ++i) switchOff(packet, valid, i);
    if (scenes_->still) query.any(valid, scenes_->still, packet);
    if (scenes_->moving) {
        for (size_t i = 0; i < kPacket; ++i) valid[i] = packet.tfar[i] < 0.0f ? 0 : valid[i];
        query.any(valid, scenes_->moving, packet);
    }
    uint32_t blocked = 0;
    for (uint32_t i = 0; i < kPacket; ++i) blocked |= (packet.tfar[i] < 0.0f ? 1u : 0u) << i;
    return blocked & ((1u << count) - 1);
}

AccelStats Accel::stats() const
{
    return {scenes_->buildSeconds, static_cast<size_t>(scenes_->bytes),
            static_cast<size_t>(scenes_->peakBytes)};
}

const World& Accel::world() const
{
    return *scenes_->world;
}

void takeWorld(std::unique_ptr<Accel>& accel, std::shared_ptr<const World> world,
               const std::function<void(const char*, double)>& progress)
{
    std::unique_ptr<Accel> old = std::move(accel);
    if (old && sameTopology(old->world(), *world)) {
        old->setPose(std::move(world), progress);
    } else {
        old.reset();
        old = std::make_unique<Accel>(std::move(world), progress);
    }
    accel = std::move(old);
}

}  // namespace core
