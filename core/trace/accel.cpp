// The scene as Embree has it: one geometry for opaque triangles and one for those whose alpha is
// tested, over the same arrays. The world keeps its alpha-tested triangles last so that the others
// never meet a filter function.
#include "core/trace/accel.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <string>

#include <embree3/rtcore.h>

#include "core/base/check.h"
#include "core/base/handoff.h"
#include "core/base/time.h"
#include "core/trace/scene_view.h"

namespace core {

namespace {

/// What the filter needs, behind the part that Embree knows. The seed of a ray travels in its id.
struct Context {
    RTCIntersectContext embree;
    const shared::SceneView* scene;
    uint32_t firstSlot;  // of the filtered geometry
};

void alphaFilter(const RTCFilterFunctionNArguments* args)
{
    const auto* context = reinterpret_cast<const Context*>(args->context);
    for (unsigned i = 0; i < args->N; ++i) {
        if (args->valid[i] != -1) continue;
        const uint32_t slot = context->firstSlot + RTCHitN_primID(args->hit, args->N, i);
        const glm::vec2 w(RTCHitN_u(args->hit, args->N, i), RTCHitN_v(args->hit, args->N, i));
        const uint32_t seed = RTCRayN_id(args->ray, args->N, i);
        if (!shared::alphaPasses(*context->scene, slot, w, seed)) args->valid[i] = 0;
    }
}

bool hasAlpha(const World& world, const WorldTriangle& triangle)
{
    const uint32_t flags = shared::kMaterialAlphaMask | shared::kMaterialAlphaBlend;
    return (world.materials[triangle.material].flags & flags) != 0;
}

/// Embree must not be given rays that are not finite (Debian's build asserts): they hit nothing.
bool isTraceable(const Ray& ray)
{
    const glm::vec3 size = glm::abs(ray.origin) + glm::abs(ray.direction);
    return size.x + size.y + size.z < 1e18f && ray.tMax > 0.0f;
}

struct BuildMonitor {
    const std::function<void(const char*, double)>& progress;
    std::stop_token stop;
    std::exception_ptr thrown{};  // by `progress`; Embree's stack frames must not be unwound
    std::mutex mutex{};
    Handoff handoff{};
};

bool continueBuild(void* pointer, double fraction)
{
    auto* monitor = static_cast<BuildMonitor*>(pointer);
    monitor->handoff.happensAfter();
    const std::lock_guard lock(monitor->mutex);
    if (monitor->thrown || monitor->stop.stop_requested()) return false;
    try {
        if (monitor->progress) monitor->progress("accelerate", fraction);
    } catch (...) {
        monitor->thrown = std::current_exception();
    }
    return !monitor->thrown;
}

}  // namespace

struct Accel::Impl {
    std::shared_ptr<const World> world;
    shared::SceneView view;
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;
    uint32_t opaque = 0;  // triangles before the first whose alpha is tested
    bool filtered = false;
    std::atomic<ssize_t> bytes = 0, peakBytes = 0;
    Handoff handoff;
    double buildSeconds = 0;

    explicit Impl(std::shared_ptr<const World> w) : world(std::move(w)), view(sceneView(*world)) {}
    ~Impl()
    {
        if (scene) rtcReleaseScene(scene);
        if (device) rtcReleaseDevice(device);
    }

    Context context() const
    {
        Context c;
        rtcInitIntersectContext(&c.embree);
        c.scene = &view;
        c.firstSlot = opaque;
        return c;
    }

    void attach(uint32_t first, uint32_t count, bool filter)
    {
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                   world->positions.data(), 0, sizeof(glm::vec3),
                                   world->positions.size() - 1);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                   world->triangles.data(), size_t(first) * sizeof(WorldTriangle),
                                   sizeof(WorldTriangle), count);
        if (filter) {
            rtcSetGeometryIntersectFilterFunction(geometry, alphaFilter);
            rtcSetGeometryOccludedFilterFunction(geometry, alphaFilter);
        }
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(scene, geometry, filter ? 1 : 0);
        rtcReleaseGeometry(geometry);
    }

    void countOpaque()
    {
        const uint32_t count = static_cast<uint32_t>(world->triangles.size());
        opaque = count;
        if ((world->features & shared::kFeatureAlpha) == 0) return;
        opaque = 0;
        while (opaque < count && !hasAlpha(*world, world->triangles[opaque])) ++opaque;
        filtered = opaque < count;
    }

    static bool countMemory(void* pointer, ssize_t change, bool)
    {
        auto* impl = static_cast<Impl*>(pointer);
        impl->handoff.happensAfter();
        const ssize_t now = impl->bytes += change;
        ssize_t peak = impl->peakBytes;
        while (now > peak && !impl->peakBytes.compare_exchange_weak(peak, now)) {
        }
        return true;
    }
};

Accel::Accel(std::shared_ptr<const World> world,
             const std::function<void(const char*, double)>& progress, std::stop_token stop,
             AccelQuality quality)
    : impl_(std::make_unique<Impl>(std::move(world)))
{
    const Clock::time_point start = Clock::now();
    Impl& impl = *impl_;
    const uint32_t count = static_cast<uint32_t>(impl.world->triangles.size());
    CHECK(impl.world->positions.size() < (1ull << 32) &&
          impl.world->triangles.size() < (1ull << 32));
    impl.device = rtcNewDevice(nullptr);
    if (!impl.device) throw Error("Embree cannot start on this processor", ExitCode::noDevice);
    rtcSetDeviceMemoryMonitorFunction(impl.device, Impl::countMemory, &impl);
    impl.scene = rtcNewScene(impl.device);
    impl.countOpaque();
    if (impl.opaque > 0) impl.attach(0, impl.opaque, false);
    if (impl.filtered) impl.attach(impl.opaque, count - impl.opaque, true);

    const bool high =
        quality == AccelQuality::high || (quality == AccelQuality::automatic && count <= 4'000'000);
    const bool compact = quality == AccelQuality::compact;
    rtcSetSceneBuildQuality(impl.scene, high ? RTC_BUILD_QUALITY_HIGH : RTC_BUILD_QUALITY_MEDIUM);
    rtcSetSceneFlags(impl.scene, RTC_SCENE_FLAG_ROBUST |
                                     (compact ? RTC_SCENE_FLAG_COMPACT : RTC_SCENE_FLAG_NONE));
    BuildMonitor monitor{progress, std::move(stop)};
    rtcSetSceneProgressMonitorFunction(impl.scene, continueBuild, &monitor);
    impl.handoff.happensBefore();
    monitor.handoff.happensBefore();
    rtcCommitScene(impl.scene);
    rtcSetSceneProgressMonitorFunction(impl.scene, nullptr, nullptr);
    const RTCError error = rtcGetDeviceError(impl.device);
    if (monitor.thrown) std::rethrow_exception(monitor.thrown);
    if (error == RTC_ERROR_CANCELLED)
        throw Error("building the hierarchy was cancelled", ExitCode::interrupted);
    if (error != RTC_ERROR_NONE) {
        throw Error(
            "Embree could not build a hierarchy over " + std::to_string(count) + " triangles" +
                (error == RTC_ERROR_OUT_OF_MEMORY ? ": out of memory"
                                                  : " (code " + std::to_string(error) + ")"),
            ExitCode::deviceLost);
    }
    impl.buildSeconds = secondsSince(start);
}

Accel::~Accel() = default;

bool Accel::closest(const Ray& ray, shared::Hit& hit) const
{
    if (!isTraceable(ray)) return false;
    Context context = impl_->context();
    RTCRayHit r;
    r.ray = {ray.origin.x,    ray.origin.y,    ray.origin.z,    0.0f,
             ray.direction.x, ray.direction.y, ray.direction.z, 0.0f,
             ray.tMax,        0xffffffffu,     ray.seed,        0};
    r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(impl_->scene, &context.embree, &r);
    if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    hit.t = r.ray.tfar;
    hit.barycentrics = {r.hit.u, r.hit.v};
    hit.slot = r.hit.primID + (r.hit.geomID == 1 ? impl_->opaque : 0);
    return true;
}

bool Accel::occluded(const Ray& ray) const
{
    if (!isTraceable(ray)) return false;
    Context context = impl_->context();
    RTCRay r{ray.origin.x,    ray.origin.y,    ray.origin.z,    0.0f,
             ray.direction.x, ray.direction.y, ray.direction.z, 0.0f,
             ray.tMax,        0xffffffffu,     ray.seed,        0};
    rtcOccluded1(impl_->scene, &context.embree, &r);
    return r.tfar < 0.0f;
}

namespace {

constexpr size_t kPacket = 16;

/// Fills lanes [0, count) of a packet; the others are switched off.
void fillPacket(std::span<const Ray> rays, int* valid, RTCRay16& packet)
{
    for (size_t i = 0; i < kPacket; ++i) {
        const Ray& ray = rays[std::min(i, rays.size() - 1)];
        valid[i] = i < rays.size() && isTraceable(ray) ? -1 : 0;
        packet.org_x[i] = ray.origin.x;
        packet.org_y[i] = ray.origin.y;
        packet.org_z[i] = ray.origin.z;
        packet.tnear[i] = 0.0f;
        packet.dir_x[i] = ray.direction.x;
        packet.dir_y[i] = ray.direction.y;
        packet.dir_z[i] = ray.direction.z;
        packet.time[i] = 0.0f;
        packet.tfar[i] = ray.tMax;
        packet.mask[i] = 0xffffffffu;
        packet.id[i] = ray.seed;
        packet.flags[i] = 0;
    }
}

}  // namespace

void Accel::closest(std::span<const Ray> rays, shared::Hit* hits, bool coherent) const
{
    Context context = impl_->context();
    if (coherent) context.embree.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    alignas(64) int valid[kPacket];
    RTCRayHit16 packet;
    for (size_t first = 0; first < rays.size(); first += kPacket) {
        const size_t count = std::min(kPacket, rays.size() - first);
        fillPacket(rays.subspan(first, count), valid, packet.ray);
        std::fill_n(packet.hit.geomID, kPacket, RTC_INVALID_GEOMETRY_ID);
        rtcIntersect16(valid, impl_->scene, &context.embree, &packet);
        for (size_t i = 0; i < count; ++i) {
            shared::Hit& hit = hits[first + i];
            const unsigned geometry = packet.hit.geomID[i];
            hit.t = packet.ray.tfar[i];
            hit.barycentrics = {packet.hit.u[i], packet.hit.v[i]};
            hit.slot = geometry == RTC_INVALID_GEOMETRY_ID
                           ? shared::kNone
                           : packet.hit.primID[i] + (geometry == 1 ? impl_->opaque : 0);
        }
    }
}

void Accel::occluded(std::span<const Ray> rays, uint8_t* blocked) const
{
    Context context = impl_->context();
    alignas(64) int valid[kPacket];
    RTCRay16 packet;
    for (size_t first = 0; first < rays.size(); first += kPacket) {
        const size_t count = std::min(kPacket, rays.size() - first);
        fillPacket(rays.subspan(first, count), valid, packet);
        rtcOccluded16(valid, impl_->scene, &context.embree, &packet);
        for (size_t i = 0; i < count; ++i) blocked[first + i] = packet.tfar[i] < 0.0f;
    }
}

AccelStats Accel::stats() const
{
    return {impl_->buildSeconds, static_cast<size_t>(impl_->bytes),
            static_cast<size_t>(impl_->peakBytes)};
}

const World& Accel::world() const
{
    return *impl_->world;
}

}  // namespace core
