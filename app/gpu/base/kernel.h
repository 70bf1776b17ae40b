// A compute kernel as renderers use it: SPIR-V, the layout of its own descriptor set, the type of
// its push constants, and its pipelines by what they are specialised on.
#pragma once

#include <algorithm>
#include <array>
#include <future>
#include <map>
#include <type_traits>
#include <vector>

#include "app/gpu/base/descriptors.h"
#include "app/gpu/base/pipeline.h"
#include "shared/bindings.h"

namespace gpu {

/// The sets of one dispatch. A kernel that looks at neither scene nor frame needs neither.
struct KernelSets {
    const DescriptorSet* scene = nullptr;
    const DescriptorSet* frame = nullptr;
    const DescriptorSet* own = nullptr;
};

/// What does not depend on the types: see Kernel.
class KernelBase {
public:
    KernelBase(Device& device, std::span<const uint32_t> spirv, const SharedLayouts* layouts,
               size_t pushBytes);

    /// The layout of the kernel's own set.
    const SetLayout& own() const { return own_; }

protected:
    bool isCompiled(std::span<const uint32_t> constants) const;
    const Pipeline& pipeline(uint32_t first, std::span<const uint32_t> constants);
    void compileBeside(uint32_t first, std::span<const uint32_t> constants);
    void prepare(VkCommandBuffer commands, const Pipeline& pipeline, const KernelSets& sets,
                 const void* push) const;
    void requireGroups(uint32_t groupsX, uint32_t groupsY) const;

private:
    Device& device_;
    std::span<const uint32_t> spirv_;
    uint32_t pushBytes_;
    bool usesScene_, usesFrame_;
    SetLayout own_;
    Handle<VkPipelineLayout, &Api::DestroyPipelineLayout> layout_;
    std::map<std::vector<uint32_t>, Pipeline> pipelines_;
    std::vector<uint32_t> besideKey_;  // constants of what is made beside
    std::future<Pipeline> beside_;     // last: the thread borrows what is above
};

/// Of kernels that are not specialised.
struct NoConstants {};

/// Of kernels that are specialised on what the scene holds, and nothing else.
struct FeatureConstants {
    static constexpr uint32_t kFirst = 0;  // lang.h
    uint32_t features = 0xffffffffu;
};

/// `Push` is what the kernel declares as push constants: its size is checked against the SPIR-V.
/// `Constants` is a structure of uint32_t, the values of the constants from number
/// Constants::kFirst on, or NoConstants.
template <class Push, class Constants = NoConstants> class Kernel : public KernelBase {
    static_assert(sizeof(Push) <= shared::kMostPushBytes);

public:
    /// `spirv` must outlive the kernel. `layouts` may be absent for a kernel that uses neither
    /// scene nor frame. Compiles nothing yet.
    Kernel(Device& device, std::span<const uint32_t> spirv, const SharedLayouts* layouts = nullptr)
        : KernelBase(device, spirv, layouts, sizeof(Push))
    {}

    bool isCompiled(const Constants& constants = {}) const
    {
        return KernelBase::isCompiled(valuesOf(constants));
    }

    /// The pipeline for these constants, made when it is first asked for. It stays where it is.
    /// Throws core::Error (noDevice) when the driver does not compile it.
    const Pipeline& pipeline(const Constants& constants = {})
    {
        return KernelBase::pipeline(first(), valuesOf(constants));
    }

    /// Begins to make that pipeline on another thread; isCompiled() is true when it is there, or
    /// could not be made, which pipeline() then throws.
    void compileBeside(const Constants& constants = {})
    {
        KernelBase::compileBeside(first(), valuesOf(constants));
    }

    /// Records one dispatch, of no more groups than the device takes: of lanes that may be many,
    /// see groupRows(). Barriers are the caller's.
    void dispatch(VkCommandBuffer commands, const Pipeline& pipeline, const KernelSets& sets,
                  const Push& push, uint32_t groupsX, uint32_t groupsY = 1) const
    {
        requireGroups(groupsX, groupsY);
        prepare(commands, pipeline, sets, &push);
        vk.CmdDispatch(commands, groupsX, groupsY, 1);
    }

    /// As dispatch, with the numbers of groups (VkDispatchIndirectCommand) at `offset` of `groups`.
    void dispatchIndirect(VkCommandBuffer commands, const Pipeline& pipeline,
                          const KernelSets& sets, const Push& push, const Buffer& groups,
                          uint64_t offset) const
    {
        prepare(commands, pipeline, sets, &push);
        vk.CmdDispatchIndirect(commands, groups.get(), offset);
    }

private:
    static constexpr uint32_t first()
    {
        if constexpr (std::is_empty_v<Constants>) {
            return 0;
        } else {
            return Constants::kFirst;
        }
    }

    static std::span<const uint32_t> valuesOf(const Constants& constants)
    {
        if constexpr (std::is_empty_v<Constants>) {
            return {};
        } else {
            static_assert(std::is_trivially_copyable_v<Constants> && sizeof(Constants) % 4 == 0 &&
                          alignof(Constants) == 4);
            return {reinterpret_cast<const uint32_t*>(&constants), sizeof(Constants) / 4};
        }
    }
};

/// Groups of kGroupSize lanes that hold `lanes`.
constexpr uint32_t groupsFor(uint64_t lanes)
{
    return static_cast<uint32_t>((lanes + shared::kGroupSize - 1) / shared::kGroupSize);
}

/// Rows of groups that hold `lanes`, of which there may be more than fit one dimension; the kernel
/// numbers its lanes row by row (rowsLane in shared/bindings.h).
struct GroupRows {
    uint32_t x, y;
};
constexpr GroupRows groupRows(uint64_t lanes)
{
    constexpr uint32_t kMost = 1u << 15;  // every device takes twice that
    const uint32_t groups = std::max(groupsFor(lanes), 1u);
    const uint32_t rows = (groups + kMost - 1) / kMost;
    return {(groups + rows - 1) / rows, rows};
}

}  // namespace gpu
