// Ray tracing on the CPU: the nearest hit, and whether anything is in between. Implemented by
// Embree, which this header does not expose.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <stop_token>

#include "core/scene/world.h"
#include "shared/surface.h"

namespace core {

/// Distances count in lengths of `direction`; `seed` decides about surfaces of
/// blended alpha.
struct Ray {
    glm::vec3 origin{0};
    float tMax = shared::kInfinity;
    glm::vec3 direction{0, 0, 1};
    uint32_t seed = 0;
};

/// Sixteen rays side by side. Unlike a Ray each must be finite, and its tMax positive.
struct RayPacket {
    static constexpr uint32_t kSize = 16;
    template <class T> using Lanes = std::array<T, kSize>;

    alignas(64) Lanes<float> originX;
    alignas(64) Lanes<float> originY;
    alignas(64) Lanes<float> originZ;
    alignas(64) Lanes<float> directionX;
    alignas(64) Lanes<float> directionY;
    alignas(64) Lanes<float> directionZ;
    alignas(64) Lanes<float> tMax;
    alignas(64) Lanes<uint32_t> seed;
};

struct AccelStats {
    double buildSeconds = 0;          // of the last world or pose
    size_t bytes = 0, peakBytes = 0;  // held by the hierarchy; most during its build
};

/// How a hierarchy is built. `automatic`: spatial splits up to four million triangles.
enum class AccelQuality { automatic, high, medium, compact };

struct AccelScenes;  // accel_scenes.h

class Accel {
public:
    /// Builds over the world's own arrays, which are not copied. `progress` gets "building the BVH"
    /// with the fraction done. Throws core::Error when memory runs out, and (interrupted) when
    /// `stop` is requested meanwhile. What `progress` throws ends the build and is passed on.
    explicit Accel(std::shared_ptr<const World> world,
                   const std::function<void(const char*, double)>& progress = {},
                   std::stop_token stop = {}, AccelQuality quality = AccelQuality::automatic);
    ~Accel();

    /// Goes over to another pose of the same topology (sameTopology with world()): only what moves
    /// is built. Nobody may trace meanwhile. Throws as the constructor, and then can only be
    /// destroyed.
    void setPose(std::shared_ptr<const World> world,
                 const std::function<void(const char*, double)>& progress = {},
                 std::stop_token stop = {});

    Accel(const Accel&) = delete;
    Accel& operator=(const Accel&) = delete;

    /// The nearest hit in (0, tMax]; false when there is none (`hit` then holds no meaning). Rays
    /// that are not finite hit nothing.
    bool closest(const Ray& ray, shared::Hit& hit) const;

    /// True when something lies in (0, tMax).
    bool occluded(const Ray& ray) const;

    /// The same for many rays at once, in packets of 16: hits[i].slot is kNone where there is none;
    /// blocked[i] is 1 or 0. Which rays share a packet may decide the last bit of a hit: keep that
    /// a function of the image alone. `coherent`: neighbouring rays have similar directions, as
    /// camera rays do; faster where that is true.
    void closest(std::span<const Ray> rays, shared::Hit* hits, bool coherent = false) const;
    void occluded(std::span<const Ray> rays, uint8_t* blocked) const;

    /// The same for one packet whose first `count` rays are there: bit i is 1 where ray i is
    /// blocked. For callers with so many rays that laying each out twice would cost, and whose rays
    /// are coherent: shadow rays between neighbours and a light (others are right, but slower).
    /// Where Embree may not come back from coherent packets they are traced as others are.
    uint32_t occluded(const RayPacket& packet, uint32_t count) const;

    /// Whether a pane lies in (0, tMax): for rays that are blocked, and might go on behind panes.
    bool meetsPane(const Ray& ray) const;

    AccelStats stats() const;
    const World& world() const;

private:
    std::unique_ptr<AccelScenes> scenes_;
};

/// The hierarchy for `world` in place of the one in `accel` (which may be empty): another pose of
/// the same topology is refitted, anything else is built anew once the old one has been freed. When
/// it throws, `accel` is empty.
void takeWorld(std::unique_ptr<Accel>& accel, std::shared_ptr<const World> world,
               const std::function<void(const char*, double)>& progress);

}  // namespace core
