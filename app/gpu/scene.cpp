// Upload of a World. Triangle slots are three words each: vertex | triangle, vertex | material and
// alpha bit, vertex | emitter, in the order of the BVH's leaves.
#include "app/gpu/scene.h"

#include <bit>
#include <chrono>
#include <exception>
#include <stop_token>

namespace gpu {

namespace {

std::vector<glm::uvec4> triangleWords(const core::World& world, const core::Bvh& bvh)
{
    std::vector<glm::uvec4> words;
    words.reserve(3 * bvh.slots.size());
    const auto word = [](glm::vec3 v, uint32_t w) {
        return glm::uvec4(std::bit_cast<uint32_t>(v.x), std::bit_cast<uint32_t>(v.y),
                          std::bit_cast<uint32_t>(v.z), w);
    };
    for (const uint32_t index : bvh.slots) {
        const core::WorldTriangle& t = world.triangles[index];
        const bool alpha = (world.materials[t.material].flags &
                            (shared::kMaterialAlphaMask | shared::kMaterialAlphaBlend)) != 0;
        words.push_back(word(world.positions[t.v0], index));
        words.push_back(
            word(world.positions[t.v1], t.material | (alpha ? shared::kTriangleAlphaBit : 0)));
        words.push_back(word(world.positions[t.v2], world.triangleEmitter.empty()
                                                        ? shared::kNone
                                                        : world.triangleEmitter[index]));
    }
    return words;
}

}  // namespace

GpuScene::GpuScene(Device& device, const SharedLayouts& layouts, const core::World& world,
                   const core::Progress& progress)
    : set_(device, layouts.scene), features_(world.features)
{
    const auto upload = [&](uint32_t binding, const char* name, const auto& data) {
        if (data.empty()) return;
        buffers_[binding] =
            Buffer(device, name, data.size() * sizeof(data[0]), sceneTexelFormat(binding));
        buffers_[binding].writeAll(data);
        set_.bind(binding, buffers_[binding]);
    };
    {
        const auto start = std::chrono::steady_clock::now();
        std::stop_source stop;
        std::exception_ptr thrown;  // by `progress`
        const auto tell = [&](double fraction) {
            if (!progress || thrown) return;
            try {
                progress("building the BVH", fraction);
            } catch (...) {
                thrown = std::current_exception();
                stop.request_stop();
            }
        };
        const core::Bvh bvh =
            core::buildBvh(world.positions, world.triangles, {}, tell, stop.get_token());
        if (thrown) std::rethrow_exception(thrown);
        buildSeconds_ =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        // Deeper, and traversal would overflow its stack unnoticed.
        CHECK(bvh.depth <= shared::kBvhMaxDepth);
        gridLow_ = bvh.gridLow;
        gridScale_ = bvh.gridScale;
        upload(shared::kBindNodes, "the BVH", bvh.nodes);
        upload(shared::kBindTriangles, "the triangles", triangleWords(world, bvh));
    }
    const bool attributed = !world.attributes.empty();
    const uint32_t byTriangle = shared::kFeatureShadingNormals | shared::kFeatureTextures |
                                shared::kFeatureVertexExtra | shared::kFeatureAlpha;
    if (attributed || (features_ & byTriangle) != 0)
        upload(shared::kBindIndices, "the indices", world.triangles);
    upload(shared::kBindAttributes, "the vertex attributes", world.attributes);
    upload(shared::kBindExtra, "the vertex colours", world.extra);
    upload(shared::kBindMaterials, "the materials", world.materials);
    upload(shared::kBindTextureReferences, "the texture references", world.textureReferences);
    upload(shared::kBindTexels, "the textures", world.texels);
    upload(shared::kBindEmitters, "the emitters", world.emitters);
    upload(shared::kBindEmitterCdf, "the emitters' probabilities", world.emitterCdf);
    upload(shared::kBindEnvironment, "the environment", world.environment);
    upload(shared::kBindEnvironmentCdf, "the environment's probabilities", world.environmentCdf);
}

uint64_t GpuScene::bytes() const
{
    uint64_t sum = 0;
    for (const Buffer& buffer : buffers_) sum += buffer.bytes();
    return sum;
}

}  // namespace gpu
