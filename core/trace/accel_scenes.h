// The scene as Embree has it: what rests and what moves are two of its scenes, traced one after the
// other, so that a pose leaves the large one alone. What rests is one geometry of opaque triangles
// and one of those whose alpha is tested (the former never meet a filter function), what moves one
// geometry per use of a mesh unless these are too many, all over the world's arrays. Prototypes are
// scenes of their own, whose instances belong to what rests. Private to core/trace.
#pragma once

#include <atomic>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>
#include <vector>

#include "core/base/handoff.h"
#include "core/scene/instances.h"
#include "core/trace/accel.h"
#include "core/trace/embree.h"
#include "core/trace/scene_view.h"

namespace core {

struct AccelScenes {
    std::shared_ptr<const World> world;
    shared::SceneView view;
    RTCDevice device = nullptr;
    RTCScene still = nullptr, moving = nullptr;  // null: no such triangles
    RTCScene panes = nullptr;                    // triangles of the others again
    std::atomic<ssize_t> bytes = 0, peakBytes = 0;
    double buildSeconds = 0;
    /// Whether any-hit packets may be called coherent. Debian 12's Embree (3.13.5) has functions
    /// for processors with AVX-512 that write 16 bits of such a packet's mask and read 64, and do
    /// not come back where others are set: those for instances and for compact triangles. (Read in
    /// the library's code, and seen; its function for the triangles that we usually have is right,
    /// and so are all three of Debian 13's 4.3.3.)
    bool shadowsMayBeCoherent = false;

    explicit AccelScenes(std::shared_ptr<const World> w);
    ~AccelScenes();
    AccelScenes(const AccelScenes&) = delete;
    AccelScenes& operator=(const AccelScenes&) = delete;

    /// Builds everything; see Accel's constructor.
    void build(const std::function<void(const char*, double)>& progress, std::stop_token stop,
               AccelQuality quality);

    /// See Accel::setPose.
    void setPose(std::shared_ptr<const World> next,
                 const std::function<void(const char*, double)>& progress, std::stop_token stop);

    /// The slot of a hit as Embree names it; kNone where there is none.
    uint32_t slotOf(unsigned geometry, unsigned primitive, unsigned instance) const
    {
        if (geometry == RTC_INVALID_GEOMETRY_ID) return shared::kNone;
        if (instance == RTC_INVALID_GEOMETRY_ID)
            return pieces_[geometry].triangles.begin + primitive;
        return slotInInstance(instance - static_cast<uint32_t>(pieces_.size()), geometry,
                              primitive);
    }

private:
    /// What the alpha filter needs, as the geometry's user data.
    struct FilterData {
        const shared::SceneView* scene;
        uint32_t firstTriangle;
        uint32_t firstInstance;  // id of the first instance's geometry
    };

    /// Triangles of the world that are one of Embree's geometries, whose id is the place in a list.
    struct Piece {
        IndexRange triangles;
        bool moves = false, filtered = false;
        FilterData filter{};
    };

    /// How a build reports and is ended.
    struct Monitor {
        const std::function<void(const char*, double)>& progress;
        std::stop_token stop;
        std::exception_ptr thrown{};  // by `progress`; Embree's stack frames must not be unwound
        std::mutex mutex{};
        Handoff begun{}, ended{};

        bool goesOn(double fraction);
    };

    static void filterAlpha(const RTCFilterFunctionNArguments* args);
    static bool continueBuild(void* monitor, double fraction);
    static bool countMemory(void* scenes, ssize_t change, bool);

    bool movesApart() const;
    void findPieces();
    void findPrototypes();
    void makePrototypes(RTCBuildQuality quality, RTCSceneFlags flags, Monitor& monitor);
    void attachInstances();
    RTCScene makeScene(bool moves, RTCBuildQuality sceneQuality, RTCBuildQuality pieceQuality,
                       RTCSceneFlags flags) const;
    void makePanes(Monitor& monitor);
    void commit(RTCScene scene, Monitor& monitor);
    void replacePositions() const;
    void setPositions(RTCGeometry geometry) const;
    void attach(RTCScene scene, uint32_t id, const Piece& piece, RTCBuildQuality quality) const;
    void requireBuilt(const Monitor& monitor) const;
    uint32_t slotInInstance(uint32_t instance, unsigned geometry, unsigned primitive) const;

    std::vector<Piece> pieces_;
    std::vector<std::vector<Piece>> prototypePieces_;  // at most two each
    std::vector<RTCScene> prototypes_;
    std::vector<InstanceSlots> slots_;   // of each prototype
    std::vector<uint32_t> prototypeOf_;  // of each instance
    std::vector<glm::uvec3> paneIndices_;
    // Read by `still`, also once the world is at another pose
    SharedArray<glm::vec3> stillPositions_;
    Handoff handoff_;
};

}  // namespace core
