// See accel_scenes.h.
#include "core/trace/accel_scenes.h"

#include <algorithm>
#include <string>
#include <utility>

#include "core/base/check.h"
#include "core/scene/features.h"

namespace core {

namespace {

RTCSceneFlags robust(RTCSceneFlags flags)
{
    return static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | static_cast<int>(flags));
}

}  // namespace

AccelScenes::AccelScenes(std::shared_ptr<const World> w)
    : world(std::move(w)), view(sceneView(*world)), stillPositions_(world->positions)
{
    CHECK(world->positions.size() < (1ull << 32) && world->triangles.size() < (1ull << 32));
    findPieces();
    findPrototypes();
}

AccelScenes::~AccelScenes()
{
    if (panes) rtcReleaseScene(panes);
    if (moving) rtcReleaseScene(moving);
    if (still) rtcReleaseScene(still);
    for (RTCScene scene : prototypes_) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
}

void AccelScenes::build(const std::function<void(const char*, double)>& progress,
                        std::stop_token stop, AccelQuality quality)
{
    device = rtcNewDevice(nullptr);
    if (!device) throw Error("Embree cannot start on this processor", ExitCode::noDevice);
    rtcSetDeviceMemoryMonitorFunction(device, countMemory, this);
    const bool high = quality == AccelQuality::high ||
                      (quality == AccelQuality::automatic && world->triangles.size() <= 4'000'000);
    const RTCBuildQuality stillQuality = high ? RTC_BUILD_QUALITY_HIGH : RTC_BUILD_QUALITY_MEDIUM;
    const RTCSceneFlags stillFlags =
        quality == AccelQuality::compact ? RTC_SCENE_FLAG_COMPACT : RTC_SCENE_FLAG_NONE;
    shadowsMayBeCoherent = world->instances.empty() && quality != AccelQuality::compact;
    Monitor monitor{progress, std::move(stop)};
    makePrototypes(stillQuality, stillFlags, monitor);
    still = makeScene(false, stillQuality, stillQuality, stillFlags);
    attachInstances();
    commit(still, monitor);
    // Embree refits only in scenes of low quality (over 72 thousand triangles 1 ms of processor
    // time instead of 25); what is low there is the tree above the pieces. Where these are one,
    // what goes separate ways would be in one tree: that is built anew.
    moving = makeScene(true, RTC_BUILD_QUALITY_LOW,
                       movesApart() ? RTC_BUILD_QUALITY_REFIT : RTC_BUILD_QUALITY_LOW,
                       RTC_SCENE_FLAG_DYNAMIC);
    commit(moving, monitor);
    makePanes(monitor);
}

void AccelScenes::setPose(std::shared_ptr<const World> next,
                          const std::function<void(const char*, double)>& progress,
                          std::stop_token stop)
{
    CHECK(sameTopology(*world, *next));
    const bool moved = !world->positions.sharesWith(next->positions);
    const std::shared_ptr<const World> before = std::exchange(world, std::move(next));
    view = sceneView(*world);
    if (!moved) return;
    Monitor monitor{progress, std::move(stop)};
    replacePositions();
    commit(moving, monitor);
    makePanes(monitor);
}

/// Whether each use of a mesh that moves is a geometry of its own. A million of them would take
/// 600 bytes and 2 us each.
bool AccelScenes::movesApart() const
{
    constexpr size_t kMostPieces = 1 << 16;
    return world->movingPieces.size() <= kMostPieces;
}

/// Cuts what stands for itself into geometries. See World for the order of its triangles.
void AccelScenes::findPieces()
{
    const uint32_t count = flatTriangles(*world);
    uint32_t opaque = count;  // before the first whose alpha is tested
    if ((world->features & shared::kFeatureAlpha) != 0) {
        opaque = 0;
        while (opaque < count && !hasAlphaTest(world->materials[world->triangles[opaque].material]))
            ++opaque;
    }
    const IndexRange moves = world->movingTriangles;
    const auto add = [&](const Piece& piece) {
        if (!piece.triangles.empty()) pieces_.push_back(piece);
    };
    add({{0, moves.empty() ? opaque : moves.begin}, false, false});
    if (movesApart()) {
        for (const IndexRange& piece : world->movingPieces)
            add({piece, true, piece.begin >= opaque});
    } else {
        const uint32_t middle = std::clamp(opaque, moves.begin, moves.end);
        add({{moves.begin, middle}, true, false});
        add({{middle, moves.end}, true, true});
    }
    add({{moves.empty() ? opaque : moves.end, count}, false, true});
    for (Piece& piece : pieces_) piece.filter = {&view, piece.triangles.begin, 0};
}

void AccelScenes::findPrototypes()
{
    if (world->prototypes.empty()) return;
    const auto firstInstance = static_cast<uint32_t>(pieces_.size());
    for (const Prototype& prototype : world->prototypes) {
        std::vector<Piece> pieces;
        const auto add = [&](IndexRange triangles, bool filtered) {
            if (!triangles.empty())
                pieces.push_back(
                    {triangles, false, filtered, {&view, triangles.begin, firstInstance}});
        };
        add({prototype.triangles.begin, prototype.alphaBegin}, false);
        add({prototype.alphaBegin, prototype.triangles.end}, true);
        prototypeOf_.resize(prototype.instances.end,
                            static_cast<uint32_t>(prototypePieces_.size()));
        prototypePieces_.push_back(std::move(pieces));
    }
    slots_ = instanceSlots({world->prototypes.data(), world->prototypes.size()},
                           prototypeTriangles(*world))
                 .value();
}

uint32_t AccelScenes::slotInInstance(uint32_t instance, unsigned geometry, unsigned primitive) const
{
    const uint32_t p = prototypeOf_[instance];
    const Prototype& prototype = world->prototypes[p];
    const uint32_t triangle = prototypePieces_[p][geometry].triangles.begin + primitive;
    return slots_[p].at(instance - prototype.instances.begin) +
           (triangle - prototype.triangles.begin);
}

void AccelScenes::filterAlpha(const RTCFilterFunctionNArguments* args)
{
    const auto* data = static_cast<const FilterData*>(args->geometryUserPtr);
    for (unsigned i = 0; i < args->N; ++i) {
        if (args->valid[i] != -1) continue;
        const uint32_t triangle = data->firstTriangle + RTCHitN_primID(args->hit, args->N, i);
        const unsigned id = RTCHitN_instID(args->hit, args->N, i, 0);
        const uint32_t instance = id == RTC_INVALID_GEOMETRY_ID ? 0 : id - data->firstInstance + 1;
        const glm::vec2 w(RTCHitN_u(args->hit, args->N, i), RTCHitN_v(args->hit, args->N, i));
        const uint32_t seed = RTCRayN_id(args->ray, args->N, i);  // of a ray, travels in its id
        if (!shared::alphaPasses(*data->scene, triangle, instance, w, seed)) args->valid[i] = 0;
    }
}

bool AccelScenes::Monitor::goesOn(double fraction)
{
    const std::lock_guard lock(mutex);
    if (thrown || stop.stop_requested()) return false;
    try {
        if (progress) progress("building the BVH", fraction);
    } catch (...) {
        thrown = std::current_exception();
    }
    return !thrown;
}

bool AccelScenes::continueBuild(void* pointer, double fraction)
{
    auto* monitor = static_cast<Monitor*>(pointer);
    monitor->begun.happensAfter();
    const bool more = monitor->goesOn(fraction);
    monitor->ended.happensBefore();
    return more;
}

bool AccelScenes::countMemory(void* pointer, ssize_t change, bool)
{
    auto* scenes = static_cast<AccelScenes*>(pointer);
    scenes->handoff_.happensAfter();
    const ssize_t now = scenes->bytes += change;
    ssize_t peak = scenes->peakBytes;
    while (now > peak && !scenes->peakBytes.compare_exchange_weak(peak, now)) {
    }
    return true;
}

void AccelScenes::makePrototypes(RTCBuildQuality quality, RTCSceneFlags flags, Monitor& monitor)
{
    for (const std::vector<Piece>& pieces : prototypePieces_) {
        RTCScene scene = rtcNewScene(device);
        prototypes_.push_back(scene);
        for (uint32_t id = 0; id < pieces.size(); ++id) attach(scene, id, pieces[id], quality);
        rtcSetSceneBuildQuality(scene, quality);
        rtcSetSceneFlags(scene, robust(flags));
        commit(scene, monitor);
    }
}

/// Puts the instances into what rests, under the ids behind those of its pieces.
void AccelScenes::attachInstances()
{
    if (world->instances.empty()) return;
    if (!still) {
        still = rtcNewScene(device);
        rtcSetSceneFlags(still, RTC_SCENE_FLAG_ROBUST);
    }
    for (size_t i = 0; i < world->instances.size(); ++i) {
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(geometry, prototypes_[prototypeOf_[i]]);
        rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, &world->instances[i]);
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(still, geometry, static_cast<unsigned>(pieces_.size() + i));
        rtcReleaseGeometry(geometry);
    }
}

/// A scene over the pieces that move, or over those that do not, yet to be built; null if there are
/// none.
RTCScene AccelScenes::makeScene(bool moves, RTCBuildQuality sceneQuality,
                                RTCBuildQuality pieceQuality, RTCSceneFlags flags) const
{
    RTCScene scene = nullptr;
    for (uint32_t id = 0; id < pieces_.size(); ++id) {
        if (pieces_[id].moves != moves) continue;
        if (!scene) scene = rtcNewScene(device);
        attach(scene, id, pieces_[id], pieceQuality);
    }
    if (!scene) return nullptr;
    rtcSetSceneBuildQuality(scene, sceneQuality);
    rtcSetSceneFlags(scene, robust(flags));
    return scene;
}

/// Makes the scene of what may be panes anew, for the world as it is; they are few.
void AccelScenes::makePanes(Monitor& monitor)
{
    if (panes) rtcReleaseScene(std::exchange(panes, nullptr));
    if ((world->features & shared::kFeaturePanes) == 0) return;
    paneIndices_.clear();
    for (uint32_t i = 0; i < flatTriangles(*world); ++i) {
        const WorldTriangle& t = world->triangles[i];
        if (mayBePane(world->materials[t.material])) paneIndices_.emplace_back(t.v0, t.v1, t.v2);
    }
    if (paneIndices_.empty()) return;
    panes = rtcNewScene(device);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    setPositions(geometry);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               paneIndices_.data(), 0, sizeof(glm::uvec3), paneIndices_.size());
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(panes, geometry);
    rtcReleaseGeometry(geometry);
    rtcSetSceneFlags(panes, RTC_SCENE_FLAG_ROBUST);
    commit(panes, monitor);
}

/// Builds a scene, or fits it to what has changed in it.
void AccelScenes::commit(RTCScene scene, Monitor& monitor)
{
    if (!scene) return;
    rtcSetSceneProgressMonitorFunction(scene, continueBuild, &monitor);
    handoff_.happensBefore();
    monitor.begun.happensBefore();
    rtcCommitScene(scene);
    monitor.ended.happensAfter();
    rtcSetSceneProgressMonitorFunction(scene, nullptr, nullptr);
    requireBuilt(monitor);
}

/// Points the moving pieces at the present world's positions.
void AccelScenes::replacePositions() const
{
    for (uint32_t id = 0; id < pieces_.size(); ++id) {
        if (!pieces_[id].moves) continue;
        RTCGeometry geometry = rtcGetGeometry(moving, id);
        setPositions(geometry);
        rtcCommitGeometry(geometry);
    }
}

void AccelScenes::setPositions(RTCGeometry geometry) const
{
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               world->positions.data(), 0, sizeof(glm::vec3),
                               world->positions.size() - 1);
}

void AccelScenes::attach(RTCScene scene, uint32_t id, const Piece& piece,
                         RTCBuildQuality quality) const
{
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    setPositions(geometry);
    rtcSetGeometryBuildQuality(geometry, quality);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               world->triangles.data(),
                               size_t(piece.triangles.begin) * sizeof(WorldTriangle),
                               sizeof(WorldTriangle), piece.triangles.size());
    if (piece.filtered) {
        rtcSetGeometryUserData(geometry, const_cast<FilterData*>(&piece.filter));
        rtcSetGeometryIntersectFilterFunction(geometry, filterAlpha);
        rtcSetGeometryOccludedFilterFunction(geometry, filterAlpha);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, id);
    rtcReleaseGeometry(geometry);
}

/// Throws what ended the build, if anything did.
void AccelScenes::requireBuilt(const Monitor& monitor) const
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

}  // namespace core
