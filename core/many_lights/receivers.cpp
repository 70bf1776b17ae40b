// See receivers.h.
#include "core/many_lights/receivers.h"

#include <algorithm>
#include <array>

#include "core/trace/scene_view.h"
#include "shared/path.h"

namespace core::many_lights {

namespace {

using glm::vec2, glm::vec3;

constexpr size_t kWave = 256;

/// A camera ray on its way through mirrors and glass.
struct Walk {
    shared::PathState path;
    shared::SampleStream stream;
    uint32_t place;
};

/// Every second bit of x.
uint32_t everySecondBit(uint32_t x)
{
    uint32_t bits = 0;
    for (uint32_t i = 0; i < 16; ++i) bits |= ((x >> (2 * i)) & 1u) << i;
    return bits;
}

Walk beginWalk(const ReceiverJob& job, glm::uvec2 pixel, uint32_t cell)
{
    const uint32_t perPixel = job.side * job.side;
    Walk walk;
    walk.place = (pixel.y * job.settings.imageWidth + pixel.x) * perPixel + cell;
    walk.stream = receiverStream(job, walk.place);
    vec2 inCell(0.5f), lens(0.5f);
    if (!job.centred) {
        inCell = shared::streamVec2(walk.stream, shared::kDimensionPixel);
        lens = shared::streamVec2(walk.stream, shared::kDimensionLens);
    }
    const vec2 corner(static_cast<float>(cell % job.side), static_cast<float>(cell / job.side));
    const vec2 film = vec2(pixel) + (corner + inCell) / static_cast<float>(job.side);
    vec3 origin, direction;
    shared::cameraRay(job.camera, film, vec2(job.settings.imageWidth, job.settings.imageHeight),
                      lens, origin, direction);
    walk.path = shared::pathAlong(origin, direction);
    return walk;
}

/// Whether a lobe without density is drawn with uLobe = u; `probability`: of any such lobe.
bool drawsDelta(const shared::Vertex& v, float u, float& probability)
{
    const bool coat = (v.bsdf.parts & shared::kBsdfCoat) != 0 && v.bsdf.coatAlpha == 0;
    const bool facet = (v.bsdf.parts & shared::kBsdfMicrofacet) != 0 && v.bsdf.alpha == 0;
    probability = (coat ? v.lobes.coat : 0.0f) + (facet ? v.lobes.facet : 0.0f);
    if (u < v.lobes.coat) return coat;
    return u < v.lobes.coat + v.lobes.facet && facet;
}

/// One surface: true where the walk goes on.
bool meetSurface(const ReceiverJob& job, const shared::SceneView& scene, shared::Hit hit,
                 Walk& walk, std::vector<Receiver>& receivers, vec3& direct)
{
    hit.barycentrics =
        shared::insideTriangle(shared::triangleInSlot(scene, hit.slot), hit.barycentrics);
    shared::Vertex v;
    if (!shared::prepareVertex(scene, job.settings, hit, walk.path, v, direct)) return false;
    const shared::VertexNumbers numbers = shared::drawVertexNumbers(walk.stream, walk.path.depth);
    float deltas;
    if (drawsDelta(v, numbers.lobe.x, deltas) || shared::isDelta(v.bsdf)) {
        shared::BsdfSample next;
        return shared::sampleLobes(v.bsdf, v.lobes, v.wo, numbers.lobe.x, numbers.bsdf, next) &&
               shared::follow(job.settings, numbers, v, next, walk.path);
    }
    Receiver r;
    r.position = v.surface.position;
    r.slot = hit.slot;
    r.normal = v.surface.backFace != 0 ? -v.surface.normal : v.surface.normal;
    r.place = walk.place;
    r.barycentrics = hit.barycentrics;
    r.direction = walk.path.direction;
    r.throughput = walk.path.beta / (1 - deltas);
    r.events = walk.path.depth;
    r.medium = walk.path.medium;
    receivers.push_back(r);
    return false;
}

uint64_t finishWave(const ReceiverJob& job, std::span<Walk> walks, std::vector<Receiver>& receivers,
                    std::span<vec3> direct)
{
    const shared::SceneView scene = sceneView(job.accel->world());
    std::array<Ray, kWave> rays;
    std::array<shared::Hit, kWave> hits;
    uint64_t traced = 0;
    for (size_t going = walks.size(); going > 0;) {
        for (size_t i = 0; i < going; ++i)
            rays[i] = {walks[i].path.origin, shared::kInfinity, walks[i].path.direction,
                       shared::alphaSeed(walks[i].stream, walks[i].path.depth, 0)};
        job.accel->closest({rays.data(), going}, hits.data(), true);
        traced += going;
        size_t kept = 0;
        for (size_t i = 0; i < going; ++i) {
            vec3& seen = direct[walks[i].place];
            if (hits[i].slot == shared::kNone)
                seen += shared::shadeMiss(scene, job.settings, walks[i].path);
            else if (meetSurface(job, scene, hits[i], walks[i], receivers, seen))
                walks[kept++] = walks[i];
        }
        going = kept;
    }
    return traced;
}

}  // namespace

shared::SampleStream receiverStream(const ReceiverJob& job, uint32_t place)
{
    const uint32_t perPixel = job.side * job.side;
    const uint32_t pixel = place / perPixel;
    return shared::makeStream(job.settings.samplerKind, job.settings.seed,
                              {pixel % job.settings.imageWidth, pixel / job.settings.imageWidth},
                              job.frame * perPixel + place % perPixel, shared::kPurposePath);
}

uint64_t traceReceivers(const ReceiverJob& job, const Tile& tile, std::vector<Receiver>& receivers,
                        std::span<vec3> direct)
{
    const uint32_t width = tile.x1 - tile.x0, height = tile.y1 - tile.y0;
    uint32_t curve = 1;  // a power of two that covers both
    while (curve < std::max(width, height)) curve *= 2;
    std::array<Walk, kWave> walks;
    size_t count = 0;
    uint64_t rays = 0;
    for (uint32_t z = 0; z < curve * curve; ++z) {
        const glm::uvec2 at(everySecondBit(z), everySecondBit(z >> 1));
        if (at.x >= width || at.y >= height) continue;
        for (uint32_t cell = 0; cell < job.side * job.side; ++cell) {
            walks[count++] = beginWalk(job, {tile.x0 + at.x, tile.y0 + at.y}, cell);
            if (count < kWave) continue;
            rays += finishWave(job, walks, receivers, direct);
            count = 0;
        }
    }
    return rays + finishWave(job, std::span(walks).first(count), receivers, direct);
}

}  // namespace core::many_lights
