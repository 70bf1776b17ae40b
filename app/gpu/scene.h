// A World in device memory: BVH, triangles in its order, attributes, materials, texels, emitters.
#pragma once

#include <array>
#include <memory>

#include "app/gpu/context.h"
#include "core/methods/renderer.h"
#include "core/trace/bvh.h"
#include "core/trace/sky_regions.h"
#include "shared/bindings.h"

namespace gpu {

/// Whether kernels trace rays through a scene. Without, there is no hierarchy, and the slot of a
/// triangle is its number in the world.
enum class SceneUse { traced, shaded };

class GpuScene {
public:
    /// Takes the hierarchy of the world, which is built if need be, and uploads. Buffers that would
    /// be empty are not made.
    GpuScene(Device& device, const SharedLayouts& layouts, const core::World& world,
             const core::Progress& progress, SceneUse use = SceneUse::traced);

    /// Takes another world; uploads what it does not share with the present one: of another pose,
    /// what moves. When it throws, the scene can only be destroyed.
    void setWorld(const core::World& world, const core::Progress& progress);

    /// The regions that the environment is drawn by from now on; null: it is drawn as a whole.
    void setSky(std::shared_ptr<const core::SkyRegions> sky);

    /// Set 0 of the kernels that look at the scene.
    const DescriptorSet& set() const { return set_; }

    /// What kernels need to know of the world and of its hierarchy, as kFeature bits.
    uint32_t features() const;
    /// Where rays begin in the hierarchy of a scene that is traced.
    const shared::BvhEntry& entry() const { return entry_; }
    /// Of a scene that is traced.
    const core::Bvh& hierarchy() const { return *bvh_; }
    /// The same, to be kept.
    std::shared_ptr<const core::Bvh> sharedHierarchy() const { return bvh_; }
    /// Writes the triangles of the hierarchy's moving part where `pose`, one of the same topology,
    /// has them: as in kBindTriangles, 48 bytes each, in the order of their slots.
    void writeMovingTriangles(const core::World& pose, Buffer& buffer) const;
    /// How the hierarchy was come by.
    void addTo(core::RenderStats& stats) const;
    uint64_t bytes() const;

private:
    void uploadHierarchy(const core::World& world, const core::Bvh& bvh);
    void uploadTriangles(const core::World& world);
    void uploadInstances(const core::World& world, const core::Bvh* bvh);
    template <class T>
    void upload(uint32_t binding, const char* name, const core::SharedArray<T>& before,
                const core::SharedArray<T>& now);
    template <class T>
    void uploadPiece(uint32_t binding, const char* name, const core::SharedArray<T>& before,
                     const core::SharedArray<T>& now, core::IndexRange changed);
    void makeBuffer(uint32_t binding, const char* name, uint64_t bytes);

    Device& device_;
    SceneUse use_;
    core::World world_;                     // what is in the buffers
    std::shared_ptr<const core::Bvh> bvh_;  // null where no rays are traced
    shared::BvhEntry entry_{};
    std::shared_ptr<const core::SkyRegions> sky_;
    std::array<Buffer, shared::kSceneBindings> buffers_;
    DescriptorSet set_;
    double buildSeconds_ = 0;
    bool hierarchyCached_ = false;
};

/// Another world in place of the one that `scene` and `held` have (both may be empty): of another
/// pose of the same topology only what moves is uploaded, of anything else everything, once the old
/// scene has been freed. Returns whether it was a pose. When it throws, both are empty.
bool takeWorld(std::unique_ptr<GpuScene>& scene, std::shared_ptr<const core::World>& held,
               std::shared_ptr<const core::World> world, Context& context,
               const core::Progress& progress, SceneUse use = SceneUse::traced);

}  // namespace gpu
