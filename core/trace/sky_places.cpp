// Walks scatter as if all surfaces were diffuse and white, and go straight on where one transmits.
#include "core/trace/sky_places.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/parallel.h"
#include "core/base/pcg32.h"
#include "core/scene/light_table.h"
#include "core/trace/scene_view.h"
#include "shared/instances.h"

namespace core {

namespace {

using glm::vec2, glm::vec3;

constexpr size_t kBlock = 256;          // walks that go on together
constexpr uint32_t kCameraEvents = 6;   // surfaces that a walk meets
constexpr uint32_t kSurfaceEvents = 3;  // one that began at a surface
constexpr size_t kMostCameras = 16;

struct Walk {
    vec3 origin{0}, direction{0};
};

vec2 pairOf(Pcg32& random)
{
    const auto unit = [&] {
        return std::min(static_cast<float>(random()), shared::kOneMinusEpsilon);
    };
    const float x = unit();
    return {x, unit()};
}

Walk fromCamera(const Camera& camera, Pcg32& random)
{
    const glm::uvec2 size = sizeForWidth(camera, 256);
    Walk walk;
    shared::cameraRay(cameraData(camera, size.x, size.y), pairOf(random) * vec2(size), vec2(size),
                      vec2(0.5f), walk.origin, walk.direction);
    return walk;
}

/// The prototype that a stored triangle belongs to; null where it stands for itself.
const Prototype* prototypeOf(const World& world, size_t triangle)
{
    if (triangle < flatTriangles(world)) return nullptr;
    return std::upper_bound(world.prototypes.begin(), world.prototypes.end(), triangle,
                            [](size_t t, const Prototype& p) { return t < p.triangles.begin; }) -
           1;
}

/// Of an edge in an instance to that of its prototype, more or less.
double sizeOf(const shared::InstanceMatrix& m)
{
    const glm::dvec3 a(m.row0), b(m.row1), c(m.row2);
    return std::cbrt(std::abs(glm::dot(glm::cross(a, b), c)));
}

/// How many triangles of the table there are for one of the world: it holds so many, of more it has
/// every n-th.
size_t strideOf(const World& world)
{
    return world.triangles.size() / (kMaxCdfEntries / 2) + 1;
}

/// Chooses triangles by the root of their area: a ground of kilometres is not all there is. Those
/// of prototypes count as often as they are shown.
std::vector<float> surfaceCdf(const World& world)
{
    std::vector<double> shown(world.prototypes.size(), 0.0);
    for (size_t p = 0; p < shown.size(); ++p) {
        const IndexRange& instances = world.prototypes[p].instances;
        for (uint32_t i = instances.begin; i < instances.end; ++i)
            shown[p] += sizeOf(world.instances[i]);
    }
    const size_t stride = strideOf(world);
    std::vector<double> weights;
    weights.reserve(world.triangles.size() / stride + 1);
    for (size_t i = 0; i < world.triangles.size(); i += stride) {
        const WorldTriangle& t = world.triangles[i];
        const vec3 a = world.positions[t.v0];
        const vec3 n = glm::cross(world.positions[t.v1] - a, world.positions[t.v2] - a);
        const Prototype* prototype = prototypeOf(world, i);
        weights.push_back(
            std::sqrt(std::sqrt(static_cast<double>(glm::dot(n, n)))) *
            (prototype ? shown[static_cast<size_t>(prototype - world.prototypes.begin())] : 1.0));
    }
    return makeCdf(weights);
}

struct ShownTriangle {
    vec3 a, b, c;
    float offset;  // of rays that leave it, at least
};

/// A triangle as it is shown, one of its instances if it has such.
ShownTriangle shownTriangle(const World& world, size_t triangle, Pcg32& random)
{
    const WorldTriangle& t = world.triangles[triangle];
    vec3 a = world.positions[t.v0], b = world.positions[t.v1], c = world.positions[t.v2];
    float placed = 0;
    if (const Prototype* prototype = prototypeOf(world, triangle)) {
        const auto any = static_cast<uint32_t>(random() * prototype->instances.size());
        const shared::InstanceMatrix& m = world.instances[prototype->instances.begin + any];
        for (vec3* corner : {&a, &b, &c}) *corner = shared::transformPoint(m, *corner);
        placed = shared::placedBy(m);
    }
    return {a, b, c, shared::leastOffset(a, b, c, placed)};
}

Walk fromSurface(const World& world, const std::vector<float>& cdf, Pcg32& random)
{
    const auto above =
        std::upper_bound(cdf.begin(), cdf.end() - 1, static_cast<float>(random() * (1 - 0x1p-24)));
    const auto i = static_cast<size_t>(std::max<std::ptrdiff_t>(above - cdf.begin(), 1) - 1);
    const auto [a, b, c, offset] = shownTriangle(world, i * strideOf(world), random);
    const vec2 w = shared::sampleTriangle(pairOf(random));
    const vec3 cross = glm::cross(b - a, c - a);
    const float length = glm::length(cross);
    const vec3 normal = length > 0 ? cross / length : vec3(0, 1, 0);
    const vec3 side = random() < 0.5 ? normal : -normal;
    return {
        shared::offsetRay(a + w.x * (b - a) + w.y * (c - a), side, offset),
        shared::toWorld(shared::makeFrame(side), shared::sampleCosineHemisphere(pairOf(random)))};
}

/// Takes a walk on from what it has met; false where it ends.
bool meet(const World& world, const shared::Hit& hit, Pcg32& random, Walk& walk,
          std::vector<Place>& places)
{
    if (hit.slot == shared::kNone) return false;
    const shared::SurfacePoint s = shared::makeSurfacePoint(sceneView(world), hit, walk.direction);
    const vec3 outside = s.backFace != 0 ? -s.normal : s.normal;
    if (random() < static_cast<double>(world.materials[s.material].transmission)) {
        walk.origin = shared::offsetRay(s.position, -outside, s.offset);
        return true;
    }
    places.push_back({s.position, s.frame[2], s.offset});
    walk.origin = shared::offsetRay(s.position, outside, s.offset);
    walk.direction =
        shared::toWorld(shared::makeFrame(outside), shared::sampleCosineHemisphere(pairOf(random)));
    return true;
}

std::vector<Place> follow(const Accel& accel, std::vector<Walk> walks, uint32_t events,
                          Pcg32& random)
{
    std::vector<Place> places;
    std::vector<Ray> rays(walks.size());
    std::vector<shared::Hit> hits(walks.size());
    for (uint32_t event = 0; event < events && !walks.empty(); ++event) {
        for (size_t i = 0; i < walks.size(); ++i)
            rays[i] = {walks[i].origin, shared::kInfinity, walks[i].direction, random.bits()};
        accel.closest({rays.data(), walks.size()}, hits.data());
        size_t kept = 0;
        for (size_t i = 0; i < walks.size(); ++i) {
            Walk walk = walks[i];
            if (meet(accel.world(), hits[i], random, walk, places)) walks[kept++] = walk;
        }
        walks.resize(kept);
    }
    return places;
}

}  // namespace

std::vector<Place> findPlaces(const Accel& accel, size_t walks, uint64_t seed)
{
    const World& world = accel.world();
    if (world.triangles.empty()) return {};
    const size_t cameras = std::min(world.cameras.size(), kMostCameras);
    const size_t fromCameras = cameras > 0 ? walks : 0;
    const size_t fromSurfaces = cameras > 0 ? walks / 2 : walks + walks / 2;
    const std::vector<float> cdf = surfaceCdf(world);
    // Blocks of either kind, in order.
    const size_t cameraBlocks = (fromCameras + kBlock - 1) / kBlock;
    const size_t blocks = cameraBlocks + (fromSurfaces + kBlock - 1) / kBlock;
    std::vector<std::vector<Place>> found(blocks);
    parallelFor(blocks, 1, [&](size_t begin, size_t end) {
        for (size_t block = begin; block < end; ++block) {
            Pcg32 random(seed, block);
            const bool camera = block < cameraBlocks;
            std::vector<Walk> begun(kBlock);
            for (size_t i = 0; i < kBlock; ++i)
                begun[i] = camera ? fromCamera(world.cameras[i % cameras], random)
                                  : fromSurface(world, cdf, random);
            found[block] =
                follow(accel, std::move(begun), camera ? kCameraEvents : kSurfaceEvents, random);
        }
    });
    std::vector<Place> places;
    for (const std::vector<Place>& some : found)
        places.insert(places.end(), some.begin(), some.end());
    return places;
}

void Bringing::add(const Place& place, const shared::EmitterSample& sample, float weight,
                   float& brings)
{
    brings = 0;
    const float cosine = glm::dot(sample.wi, place.normal);
    if (!(cosine > 0)) return;
    shared::ShadowRay shadow =
        shared::noShadowRay(shared::offsetRay(place.position, place.normal, place.offset));
    shadow.contribution = sample.radiance * (weight * cosine);
    if (!(shared::luminance(shadow.contribution) < 1e30f)) return;
    shadow.wi = shadow.direction = sample.wi;
    shadow.tMax = shared::kDistant;
    if (sample.distance < 0.5f * shared::kDistant) {
        shadow.direction = (place.position - shadow.origin) + sample.distance * sample.wi;
        shadow.tMax = shared::connectionEnd(glm::length(shadow.direction));
    }
    constexpr uint32_t kMostPanes = 8;
    shadow.passes = kMostPanes;
    shadows_.push_back(shadow);
    brings_.push_back(&brings);
}

void Bringing::trace()
{
    const World& world = accel_.world();
    const bool panes = (world.features & shared::kFeaturePanes) != 0;
    rays_.resize(shadows_.size());
    blocked_.resize(shadows_.size());
    for (size_t i = 0; i < shadows_.size(); ++i)
        rays_[i] = {shadows_[i].origin, shadows_[i].tMax, shadows_[i].direction, 0};
    accel_.occluded(rays_, blocked_.data());
    for (size_t i = 0; i < shadows_.size(); ++i) {
        shared::ShadowRay& shadow = shadows_[i];
        bool open = blocked_[i] == 0;
        bool passes = !open && panes && accel_.meetsPane(rays_[i]);
        shared::Hit hit;
        while (passes) {
            open = !accel_.closest({shadow.origin, shadow.tMax, shadow.direction, 0}, hit);
            passes = !open && shared::passPane(sceneView(world), hit, shadow);
        }
        *brings_[i] = open ? shared::luminance(shadow.contribution) : 0.0f;
    }
    shadows_.clear();
    brings_.clear();
}

}  // namespace core
