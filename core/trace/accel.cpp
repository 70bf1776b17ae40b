// The scene as Embree has it: what rests and what moves are two of its scenes, traced one after the
// other, so that a pose leaves the large one alone. What rests is one geometry of opaque triangles
// and one of those whose alpha is tested (the former never meet a filter function), what moves one
// geometry per use of a mesh, all over the world's arrays.
#include "core/trace/accel.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <exception>
#include <limits>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "core/base/check.h"
#include "core/base/handoff.h"
#include "core/base/time.h"
#include "core/trace/embree.h"
#include "core/trace/scene_view.h"

namespace core {

namespace {

/// Triangles of the world that are one of Embree's geometries, whose id is the place in a list.
struct Piece {
    IndexRange triangles;
    bool moves = false, filtered = false;
};

/// What the filter needs, as the geometry's user data. The seed of a ray travels in its id.
struct FilterData {
    const shared::SceneView* scene;
    const std::vector<Piece>* pieces;
};

void alphaFilter(const RTCFilterFunctionNArguments* args)
{
    const auto* data = static_cast<const FilterData*>(args->geometryUserPtr);
    for (unsigned i = 0; i < args->N; ++i) {
        if (args->valid[i] != -1) continue;
        const Piece& piece = (*data->pieces)[RTCHitN_geomID(args->hit, args->N, i)];
        const uint32_t slot = piece.triangles.begin + RTCHitN_primID(args->hit, args->N, i);
        const glm::vec2 w(RTCHitN_u(args->hit, args->N, i), RTCHitN_v(args->hit, args->N, i));
        const uint32_t seed = RTCRayN_id(args->ray, args->N, i);
        if (!shared::alphaPasses(*data->scene, slot, w, seed)) args->valid[i] = 0;
    }
}

bool hasAlpha(const World& world, const WorldTriangle& triangle)
{
    const uint32_t flags = shared::kMaterialAlphaMask | shared::kMaterialAlphaBlend;
    return (world.materials[triangle.material].flags & flags) != 0;
}

/// Whether light may go straight through the triangle somewhere: smooth or not is a matter of
/// textures.
bool mayBePane(const World& world, const WorldTriangle& triangle)
{
    const shared::Material& m = world.materials[triangle.material];
    return m.transmission > 0 && (m.flags & shared::kMaterialVolume) == 0;
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
    Handoff begun{}, ended{};
};

bool goesOn(BuildMonitor& monitor, double fraction)
{
    const std::lock_guard lock(monitor.mutex);
    if (monitor.thrown || monitor.stop.stop_requested()) return false;
    try {
        if (monitor.progress) monitor.progress("accelerate", fraction);
    } catch (...) {
        monitor.thrown = std::current_exception();
    }
    return !monitor.thrown;
}

bool continueBuild(void* pointer, double fraction)
{
    auto* monitor = static_cast<BuildMonitor*>(pointer);
    monitor->begun.happensAfter();
    const bool more = goesOn(*monitor, fraction);
    monitor->ended.happensBefore();
    return more;
}

}  // namespace

struct Accel::Impl {
    std::shared_ptr<const World> world;
    shared::SceneView view;
    std::vector<Piece> pieces;
    FilterData filterData{&view, &pieces};  // also of the poses to come: view stays where it is
    RTCDevice device = nullptr;
    RTCScene still = nullptr, moving = nullptr;  // null: no such triangles
    RTCScene panes = nullptr;                    // triangles of the others again
    std::vector<glm::uvec3> paneIndices;         // of `panes`
    // Read by `still`, also once the world is at another pose
    SharedArray<glm::vec3> stillPositions;
    std::atomic<ssize_t> bytes = 0, peakBytes = 0;
    Handoff handoff;
    double buildSeconds = 0;

    explicit Impl(std::shared_ptr<const World> w)
        : world(std::move(w)), view(sceneView(*world)), stillPositions(world->positions)
    {
        findPieces();
    }
    ~Impl()
    {
        if (panes) rtcReleaseScene(panes);
        if (moving) rtcReleaseScene(moving);
        if (still) rtcReleaseScene(still);
        if (device) rtcReleaseDevice(device);
    }

    uint32_t slotOf(unsigned geometry, unsigned primitive) const
    {
        return geometry == RTC_INVALID_GEOMETRY_ID ? shared::kNone
                                                   : pieces[geometry].triangles.begin + primitive;
    }

    /// Cuts the world into geometries. See World for the order of its triangles.
    void findPieces()
    {
        const uint32_t count = static_cast<uint32_t>(world->triangles.size());
        uint32_t opaque = count;  // before the first whose alpha is tested
        if ((world->features & shared::kFeatureAlpha) != 0) {
            opaque = 0;
            while (opaque < count && !hasAlpha(*world, world->triangles[opaque])) ++opaque;
        }
        const IndexRange moves = world->movingTriangles;
        const auto add = [&](const Piece& piece) {
            if (!piece.triangles.empty()) pieces.push_back(piece);
        };
        add({{0, moves.empty() ? opaque : moves.begin}, false, false});
        for (const IndexRange& piece : world->movingPieces)
            add({piece, true, piece.begin >= opaque});
        add({{moves.empty() ? opaque : moves.end, count}, false, true});
    }

    /// A scene over the pieces that move, or over those that do not, yet to be built; null if there
    /// are none.
    RTCScene makeScene(bool moves, RTCBuildQuality sceneQuality, RTCBuildQuality pieceQuality,
                       RTCSceneFlags flags) const
    {
        RTCScene scene = nullptr;
        for (uint32_t id = 0; id < pieces.size(); ++id) {
            if (pieces[id].moves != moves) continue;
            if (!scene) scene = rtcNewScene(device);
            attach(scene, id, pieceQuality);
        }
        if (!scene) return nullptr;
        rtcSetSceneBuildQuality(scene, sceneQuality);
        rtcSetSceneFlags(scene, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | flags));
        return scene;
    }

    /// Makes the scene of what may be panes anew, for the world as it is; they are few.
    void makePanes(BuildMonitor& monitor)
    {
        if (panes) rtcReleaseScene(std::exchange(panes, nullptr));
        if ((world->features & shared::kFeaturePanes) == 0) return;
        paneIndices.clear();
        for (const WorldTriangle& t : world->triangles)
            if (mayBePane(*world, t)) paneIndices.emplace_back(t.v0, t.v1, t.v2);
        if (paneIndices.empty()) return;
        panes = rtcNewScene(device);
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        setPositions(geometry);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                   paneIndices.data(), 0, sizeof(glm::uvec3), paneIndices.size());
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(panes, geometry);
        rtcReleaseGeometry(geometry);
        rtcSetSceneFlags(panes, RTC_SCENE_FLAG_ROBUST);
        commit(panes, monitor);
    }

    /// Builds a scene, or fits it to what has changed in it.
    void commit(RTCScene scene, BuildMonitor& monitor)
    {
        if (!scene) return;
        rtcSetSceneProgressMonitorFunction(scene, continueBuild, &monitor);
        handoff.happensBefore();
        monitor.begun.happensBefore();
        rtcCommitScene(scene);
        monitor.ended.happensAfter();
        rtcSetSceneProgressMonitorFunction(scene, nullptr, nullptr);
        requireBuilt(monitor);
    }

    /// Points the moving pieces at the present world's positions.
    void replacePositions() const
    {
        for (uint32_t id = 0; id < pieces.size(); ++id) {
            if (!pieces[id].moves) continue;
            RTCGeometry geometry = rtcGetGeometry(moving, id);
            setPositions(geometry);
            rtcCommitGeometry(geometry);
        }
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

private:
    void setPositions(RTCGeometry geometry) const
    {
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                   world->positions.data(), 0, sizeof(glm::vec3),
                                   world->positions.size() - 1);
    }

    void attach(RTCScene scene, uint32_t id, RTCBuildQuality quality) const
    {
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        setPositions(geometry);
        rtcSetGeometryBuildQuality(geometry, quality);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                   world->triangles.data(),
                                   size_t(pieces[id].triangles.begin) * sizeof(WorldTriangle),
                                   sizeof(WorldTriangle), pieces[id].triangles.size());
        if (pieces[id].filtered) {
            rtcSetGeometryUserData(geometry, const_cast<FilterData*>(&filterData));
            rtcSetGeometryIntersectFilterFunction(geometry, alphaFilter);
            rtcSetGeometryOccludedFilterFunction(geometry, alphaFilter);
        }
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(scene, geometry, id);
        rtcReleaseGeometry(geometry);
    }

    /// Throws what ended the build, if anything did.
    void requireBuilt(const BuildMonitor& monitor) const
    {
        const RTCError error = rtcGetDeviceError(device);
        if (monitor.thrown) std::rethrow_exception(monitor.thrown);
        if (error == RTC_ERROR_CANCELLED)
            throw Error("building the hierarchy was cancelled", ExitCode::interrupted);
        if (error != RTC_ERROR_NONE) {
            throw Error("Embree could not build a hierarchy over " +
                            std::to_string(world->triangles.size()) + " triangles" +
                            (error == RTC_ERROR_OUT_OF_MEMORY
                                 ? ": out of memory"
                                 : " (code " + std::to_string(error) + ")"),
                        ExitCode::deviceLost);
        }
    }
};

Accel::Accel(std::shared_ptr<const World> world,
             const std::function<void(const char*, double)>& progress, std::stop_token stop,
             AccelQuality quality)
    : impl_(std::make_unique<Impl>(std::move(world)))
{
    const Clock::time_point start = Clock::now();
    Impl& impl = *impl_;
    const uint64_t count = impl.world->triangles.size();
    CHECK(impl.world->positions.size() < (1ull << 32) && count < (1ull << 32));
    impl.device = rtcNewDevice(nullptr);
    if (!impl.device) throw Error("Embree cannot start on this processor", ExitCode::noDevice);
    rtcSetDeviceMemoryMonitorFunction(impl.device, Impl::countMemory, &impl);

    const bool high =
        quality == AccelQuality::high || (quality == AccelQuality::automatic && count <= 4'000'000);
    const bool compact = quality == AccelQuality::compact;
    BuildMonitor monitor{progress, std::move(stop)};
    const RTCBuildQuality stillQuality = high ? RTC_BUILD_QUALITY_HIGH : RTC_BUILD_QUALITY_MEDIUM;
    impl.still = impl.makeScene(false, stillQuality, stillQuality,
                                compact ? RTC_SCENE_FLAG_COMPACT : RTC_SCENE_FLAG_NONE);
    impl.commit(impl.still, monitor);
    // Embree refits only in scenes of low quality (over 72 thousand triangles 1 ms of processor
    // time instead of 25); what is low there is the tree above the pieces.
    impl.moving = impl.makeScene(true, RTC_BUILD_QUALITY_LOW, RTC_BUILD_QUALITY_REFIT,
                                 RTC_SCENE_FLAG_DYNAMIC);
    impl.commit(impl.moving, monitor);
    impl.makePanes(monitor);
    impl.buildSeconds = secondsSince(start);
}

void Accel::setPose(std::shared_ptr<const World> world,
                    const std::function<void(const char*, double)>& progress, std::stop_token stop)
{
    const Clock::time_point start = Clock::now();
    Impl& impl = *impl_;
    CHECK(sameTopology(*impl.world, *world));
    const bool moved = !impl.world->positions.sharesWith(world->positions);
    const std::shared_ptr<const World> before = std::exchange(impl.world, std::move(world));
    impl.view = sceneView(*impl.world);
    if (moved) {
        BuildMonitor monitor{progress, std::move(stop)};
        impl.replacePositions();
        impl.commit(impl.moving, monitor);
        impl.makePanes(monitor);
    }
    impl.buildSeconds = secondsSince(start);
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
    r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    if (impl_->still) query.closest(impl_->still, r);
    if (impl_->moving) query.closest(impl_->moving, r);
    hit.slot = impl_->slotOf(r.hit.geomID, r.hit.primID);
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
    if (impl_->still) query.any(impl_->still, r);
    if (impl_->moving && !(r.tfar < 0.0f)) query.any(impl_->moving, r);
    return r.tfar < 0.0f;
}

bool Accel::meetsPane(const Ray& ray) const
{
    if (!impl_->panes || !isTraceable(ray)) return false;
    EmbreeQuery query;
    RTCRay r{ray.origin.x,    ray.origin.y,    ray.origin.z,    0.0f,
             ray.direction.x, ray.direction.y, ray.direction.z, 0.0f,
             ray.tMax,        0xffffffffu,     ray.seed,        0};
    query.any(impl_->panes, r);
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
        if (impl_->still) query.closest(valid, impl_->still, packet);
        if (impl_->moving) query.closest(valid, impl_->moving, packet);
        for (size_t i = 0; i < count; ++i) {
            shared::Hit& hit = hits[first + i];
            hit.t = packet.ray.tfar[i];
            hit.barycentrics = {packet.hit.u[i], packet.hit.v[i]};
            hit.slot = impl_->slotOf(packet.hit.geomID[i], packet.hit.primID[i]);
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
        if (impl_->still) query.any(valid, impl_->still, packet);
        if (impl_->moving) {
            for (size_t i = 0; i < kPacket; ++i) valid[i] = packet.tfar[i] < 0.0f ? 0 : valid[i];
            query.any(valid, impl_->moving, packet);
        }
        for (size_t i = 0; i < count; ++i)
            blocked[first + i] = packet.tfar[i] < 0.0f && isTraceable(rays[first + i]);
    }
}

uint32_t Accel::occluded(const RayPacket& rays, uint32_t count) const
{
    static_assert(RayPacket::kSize == kPacket);
    EmbreeQuery query;
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
    if (impl_->still) query.any(valid, impl_->still, packet);
    if (impl_->moving) {
        for (size_t i = 0; i < kPacket; ++i) valid[i] = packet.tfar[i] < 0.0f ? 0 : valid[i];
        query.any(valid, impl_->moving, packet);
    }
    uint32_t blocked = 0;
    for (uint32_t i = 0; i < kPacket; ++i) blocked |= (packet.tfar[i] < 0.0f ? 1u : 0u) << i;
    return blocked & ((1u << count) - 1);
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
