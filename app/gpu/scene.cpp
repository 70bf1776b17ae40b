// Upload of a World. Triangle slots are three words each: vertex | triangle, vertex | material and
// alpha bit, vertex | emitter, in the order of the BVH's leaves.
#include "app/gpu/scene.h"

#include <algorithm>
#include <bit>
#include <span>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/base/time.h"
#include "core/scene/features.h"
#include "core/scene/instances.h"
#include "core/trace/world_bvh.h"

namespace gpu {

namespace {

constexpr uint64_t kNodeWord = sizeof(shared::uvec4), kTriangleBytes = 3 * sizeof(glm::uvec4);

/// The three words of a triangle.
void putTriangle(const core::World& world, uint32_t index, glm::uvec4* words)
{
    const auto word = [](glm::vec3 v, uint32_t w) {
        return glm::uvec4(std::bit_cast<uint32_t>(v.x), std::bit_cast<uint32_t>(v.y),
                          std::bit_cast<uint32_t>(v.z), w);
    };
    const core::WorldTriangle& t = world.triangles[index];
    const bool alpha = core::hasAlphaTest(world.materials[t.material]);
    words[0] = word(world.positions[t.v0], index);
    words[1] = word(world.positions[t.v1], t.material | (alpha ? shared::kTriangleAlphaBit : 0));
    words[2] = word(world.positions[t.v2],
                    world.triangleEmitter.empty() ? shared::kNone : world.triangleEmitter[index]);
}

/// Writes the triangles in the slots that `slotAt` gives for 0 to `count` - 1, from byte `offset`
/// on; in pieces, as memory that is new costs more than what is put there.
template <class SlotAt>
void writeTriangles(Buffer& buffer, uint64_t offset, const core::World& world, size_t count,
                    SlotAt slotAt)
{
    constexpr size_t kPiece = 1 << 16, kBlock = 1 << 12;
    std::vector<glm::uvec4> words(3 * std::min(count, kPiece));
    for (size_t first = 0; first < count; first += kPiece) {
        const size_t triangles = std::min(kPiece, count - first);
        core::parallelFor(triangles, kBlock, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i)
                putTriangle(world, slotAt(first + i), &words[3 * i]);
        });
        buffer.write(std::as_bytes(std::span(words.data(), 3 * triangles)),
                     offset + first * kTriangleBytes);
    }
}

/// The same for the slots of a list.
template <class Slots>
void writeListed(Buffer& buffer, uint64_t offset, const core::World& world, const Slots& slots)
{
    writeTriangles(buffer, offset, world, slots.size(), [&](size_t i) { return slots[i]; });
}

template <class T> std::span<const std::byte> bytesOf(const T& array)
{
    return std::as_bytes(std::span(array.data(), array.size()));
}

}  // namespace

GpuScene::GpuScene(Device& device, const SharedLayouts& layouts, const core::World& world,
                   const core::Progress& progress, SceneUse use)
    : device_(device), use_(use), set_(device, layouts.scene)
{
    setWorld(world, progress);
}

/// The tree of emitters, nothing where it does not choose them.
static core::SharedArray<glm::uvec4> usedTree(const core::World& world)
{
    return world.treeEmitters > 0 ? world.emitterTree : core::SharedArray<glm::uvec4>();
}

void GpuScene::setWorld(const core::World& world, const core::Progress& progress)
{
    std::shared_ptr<const core::Bvh> bvh;
    if (use_ == SceneUse::traced) {
        const core::Clock::time_point start = core::Clock::now();
        const auto report = [&](double fraction) {
            if (progress) progress("building the BVH", fraction);
        };
        core::BvhCache cache(device_.cacheFolder());
        bvh = core::bvhOf(world, report, {}, &cache);
        buildSeconds_ = core::secondsSince(start);
        hierarchyCached_ = cache.found();
        CHECK(bvh->depth <=
              shared::kBvhMaxDepth);  // deeper, and traversal would overflow its stack
        uploadHierarchy(world, *bvh);
    } else {
        uploadTriangles(world);
    }
    const bool attributed = !world.attributes.empty();
    const uint32_t byTriangle = shared::kFeatureShadingNormals | shared::kFeatureTextures |
                                shared::kFeatureVertexExtra | shared::kFeatureAlpha;
    // The materials of lamps below a coat are found by their triangles.
    const uint32_t coatedLamps = shared::kFeatureClearcoat | shared::kFeatureEmissiveTriangles;
    if (attributed || (world.features & byTriangle) != 0 ||
        (world.features & coatedLamps) == coatedLamps)
        upload(shared::kBindIndices, "the indices", world_.triangles, world.triangles);
    uploadPiece(shared::kBindAttributes, "the vertex attributes", world_.attributes,
                world.attributes,
                core::sameTopology(world_, world) ? world.movingVertices : core::IndexRange{});
    if (!core::sameTopology(world_, world)) uploadInstances(world, bvh.get());
    upload(shared::kBindExtra, "the vertex colours", world_.extra, world.extra);
    upload(shared::kBindMaterials, "the materials", world_.materials, world.materials);
    upload(shared::kBindTextureReferences, "the texture references", world_.textureReferences,
           world.textureReferences);
    upload(shared::kBindTexels, "the textures", world_.texels, world.texels);
    upload(shared::kBindEmitters, "the emitters", world_.emitters, world.emitters);
    upload(shared::kBindEmitterCdf, "the emitters' probabilities", world_.emitterCdf,
           world.emitterCdf);
    upload(shared::kBindEmitterTree, "the tree of emitters", usedTree(world_), usedTree(world));
    upload(shared::kBindEnvironment, "the environment", world_.environment, world.environment);
    upload(shared::kBindEnvironmentCdf, "the environment's probabilities", world_.environmentCdf,
           world.environmentCdf);
    world_ = world;
    bvh_ = bvh;
    if (bvh_) entry_ = core::entryOf(*bvh_);
}

void GpuScene::setSky(std::shared_ptr<const core::SkyRegions> sky)
{
    if (sky == sky_) return;
    sky_ = std::move(sky);
    const size_t words = sky_ ? sky_->words.size() : 0;
    makeBuffer(shared::kBindSkyRegions, "the regions of the sky", words * sizeof(glm::uvec4));
    if (words > 0) buffers_[shared::kBindSkyRegions].write(bytesOf(sky_->words));
}

/// What moves comes first in both buffers: a pose writes their beginnings.
void GpuScene::uploadHierarchy(const core::World& world, const core::Bvh& bvh)
{
    Buffer& nodes = buffers_[shared::kBindNodes];
    Buffer& triangles = buffers_[shared::kBindTriangles];
    const bool wholly = !bvh_ || !core::sameTopology(world_, world) ||
                        !bvh.still.nodes.sharesWith(bvh_->still.nodes) ||
                        bvh.nodeCount() != bvh_->nodeCount();
    if (wholly) {
        makeBuffer(shared::kBindNodes, "the BVH", bvh.nodeCount() * 2 * kNodeWord);
        makeBuffer(shared::kBindTriangles, "the triangles", bvh.slotCount() * kTriangleBytes);
        nodes.write(bytesOf(bvh.still.nodes), bvh.moving.nodes.size() * kNodeWord);
        writeListed(triangles, bvh.moving.slots.size() * kTriangleBytes, world, bvh.still.slots);
    }
    if (wholly || !world.positions.sharesWith(world_.positions)) {
        nodes.write(bytesOf(bvh.moving.nodes));
        writeListed(triangles, 0, world, bvh.moving.slots);
    }
}

void GpuScene::writeMovingTriangles(const core::World& pose, Buffer& buffer) const
{
    CHECK(bvh_ && core::sameTopology(pose, world_));
    writeListed(buffer, 0, pose, bvh_->moving.slots);
}

/// Where slots that belong to instances lead.
void GpuScene::uploadInstances(const core::World& world, const core::Bvh* bvh)
{
    const std::vector<glm::uvec4> table =
        core::makeInstanceTable(world, bvh ? bvh->prototypeSlots : core::prototypeTriangles(world));
    makeBuffer(shared::kBindInstances, "the instances", table.size() * sizeof(glm::uvec4));
    if (!table.empty()) buffers_[shared::kBindInstances].writeAll(table);
}

/// As the world has them.
void GpuScene::uploadTriangles(const core::World& world)
{
    if (world.positions.sharesWith(world_.positions) &&
        world.triangles.sharesWith(world_.triangles))
        return;
    makeBuffer(shared::kBindTriangles, "the triangles", world.triangles.size() * kTriangleBytes);
    writeTriangles(buffers_[shared::kBindTriangles], 0, world, world.triangles.size(),
                   [](size_t i) { return static_cast<uint32_t>(i); });
}

/// A buffer of so many bytes, the present one if it has just these; none for no bytes.
void GpuScene::makeBuffer(uint32_t binding, const char* name, uint64_t bytes)
{
    Buffer& buffer = buffers_[binding];
    if (bytes > 0 && buffer.bytes() == ((bytes + 15) & ~uint64_t(15))) return;
    set_.unbind(binding);
    buffer = {};  // first: both at once might not fit
    if (bytes == 0) return;
    buffer = Buffer(device_, name, bytes, sceneTexelFormat(binding), BufferOf::scene);
    set_.bind(binding, buffer);
}

template <class T>
void GpuScene::upload(uint32_t binding, const char* name, const core::SharedArray<T>& before,
                      const core::SharedArray<T>& now)
{
    uploadPiece(binding, name, before, now, {});
}

/// `changed`: the only items that may be others, if as many were there before; all when empty.
template <class T>
void GpuScene::uploadPiece(uint32_t binding, const char* name, const core::SharedArray<T>& before,
                           const core::SharedArray<T>& now, core::IndexRange changed)
{
    if (now.sharesWith(before)) return;
    makeBuffer(binding, name, now.size() * sizeof(T));
    if (now.empty()) return;
    std::span<const T> items(now.data(), now.size());
    size_t first = 0;
    if (!changed.empty() && before.size() == now.size()) {
        first = changed.begin;
        items = items.subspan(first, changed.size());
    }
    buffers_[binding].write(std::as_bytes(items), first * sizeof(T));
}

uint32_t GpuScene::features() const
{
    uint32_t features = world_.features | (sky_ ? shared::kFeatureSkyRegions : 0);
    if (!bvh_) return features;
    const bool surrounded = entry_.way != shared::kBvhDone;
    if (surrounded) features |= shared::kFeatureSurroundings;
    if (bvh_->gridChanges() > (surrounded ? 1u : 0u)) features |= shared::kFeatureGridChanges;
    return features;
}

void GpuScene::addTo(core::RenderStats& stats) const
{
    stats.buildSeconds = buildSeconds_;
    stats.hierarchyCached = hierarchyCached_;
}

uint64_t GpuScene::bytes() const
{
    uint64_t sum = 0;
    for (const Buffer& buffer : buffers_) sum += buffer.bytes();
    return sum;
}

bool takeWorld(std::unique_ptr<GpuScene>& scene, std::shared_ptr<const core::World>& held,
               std::shared_ptr<const core::World> world, Context& context,
               const core::Progress& progress, SceneUse use)
{
    std::unique_ptr<GpuScene> next = std::move(scene);
    const bool pose = next && core::sameTopology(*held, *world);
    held.reset();
    if (pose) {
        next->setWorld(*world, progress);
    } else {
        next.reset();  // two scenes at once might not fit
        next = std::make_unique<GpuScene>(context.device, context.layouts, *world, progress, use);
    }
    scene = std::move(next);
    held = std::move(world);
    return pose;
}

}  // namespace gpu
