// What kernels say of themselves against what the host gives them: bindings, push constants and the
// numbers in shared/bindings.h, for every kernel of the program; texts that are no kernels; and
// kernels compiled beside other work (V14).
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <thread>

#include "app/gpu/base/kernel.h"
#include "app/gpu/window/display.h"
#include "shared/virtual_light.h"
#include "tests/support/vulkan/vulkan_faults.h"

#include "spirv/accumulate.h"
#include "spirv/bench_any.h"
#include "spirv/bench_closest.h"
#include "spirv/bounce.h"
#include "spirv/display.h"
#include "spirv/first_hits.h"
#include "spirv/gather.h"
#include "spirv/mean.h"
#include "spirv/megakernel.h"
#include "spirv/occlusion.h"
#include "spirv/reuse_bounce.h"
#include "spirv/reuse_full.h"
#include "spirv/reuse_hits.h"
#include "spirv/reuse_new.h"
#include "spirv/reuse_old.h"
#include "spirv/reuse_weigh.h"
#include "spirv/seen.h"

namespace {

using gpu::KernelBinding;
using gpu::KernelInterface;
using gpu::readKernelInterface;

constexpr VkDescriptorType kTexels = VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
constexpr VkDescriptorType kUniforms = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
constexpr VkDescriptorType kStorage = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;

struct NamedKernel {
    const char* name;
    std::span<const uint32_t> spirv;
};

const NamedKernel kKernels[] = {
    {"accumulate", k_accumulate},
    {"bench_any", k_bench_any},
    {"bench_closest", k_bench_closest},
    {"bounce", k_bounce},
    {"display", k_display},
    {"first_hits", k_first_hits},
    {"gather", k_gather},
    {"mean", k_mean},
    {"megakernel", k_megakernel},
    {"occlusion", k_occlusion},
    {"reuse_bounce", k_reuse_bounce},
    {"reuse_full", k_reuse_full},
    {"reuse_hits", k_reuse_hits},
    {"reuse_new", k_reuse_new},
    {"reuse_old", k_reuse_old},
    {"reuse_weigh", k_reuse_weigh},
    {"seen", k_seen},
};

TEST(Kernel, TheBounceWantsWhatItIsGiven)
{
    const KernelInterface bounce = readKernelInterface(k_bounce);
    EXPECT_EQ(bounce.pushBytes, sizeof(shared::BounceBatch));
    const std::vector<KernelBinding> own{
        {shared::kSetKernel, shared::kBindRadiance, kStorage, false},
        {shared::kSetKernel, shared::kBindStateTexels, kTexels, true},
        {shared::kSetKernel, shared::kBindStates, kStorage, false},
        {shared::kSetKernel, shared::kBindQueues, kStorage, false}};
    EXPECT_EQ(bounce.ofSet(shared::kSetKernel), own);
    EXPECT_EQ(bounce.ofSet(shared::kSetScene).size(), size_t(shared::kSceneBindings));
    EXPECT_TRUE(readKernelInterface(k_display).ofSet(shared::kSetScene).empty());
}

TEST(Kernel, TheSharedSetsAreThoseThatEveryKernelDeclares)
{
    gpu::Device device({});
    const gpu::SharedLayouts layouts(device);
    for (const NamedKernel& kernel : kKernels) {
        const KernelInterface wants = readKernelInterface(kernel.spirv);
        for (const auto& [set, layout] : {std::pair{shared::kSetScene, &layouts.scene},
                                          std::pair{shared::kSetFrame, &layouts.frame}}) {
            for (const KernelBinding& b : wants.ofSet(set)) {
                EXPECT_NE(std::ranges::find(layout->bindings(), b), layout->bindings().end())
                    << kernel.name << ": set " << b.set << ", binding " << b.binding;
            }
        }
        EXPECT_FALSE(wants.ofSet(shared::kSetKernel).empty()) << kernel.name;
        EXPECT_TRUE(wants.ofSet(shared::kSetCount).empty()) << kernel.name;
    }
}

TEST(Kernel, LimitsAreThoseOfTheKernels)
{
    // What the layouts of a kernel count to: shared sets as a whole, where they are used.
    uint32_t texels = 0, storage = 0, resources = 0, push = 0;
    for (const NamedKernel& kernel : kKernels) {
        const KernelInterface wants = readKernelInterface(kernel.spirv);
        std::map<VkDescriptorType, uint32_t> count;
        for (const KernelBinding& b : wants.ofSet(shared::kSetKernel)) ++count[b.type];
        if (!wants.ofSet(shared::kSetScene).empty()) count[kTexels] += shared::kSceneBindings;
        if (!wants.ofSet(shared::kSetFrame).empty()) {
            ++count[kUniforms];
            ++count[kStorage];
        }
        texels = std::max(texels, count[kTexels]);
        storage = std::max(storage, count[kStorage]);
        resources = std::max(resources, count[kTexels] + count[kStorage] + count[kUniforms]);
        push = std::max(push, wants.pushBytes);
    }
    EXPECT_EQ(texels, shared::kMostTexelBuffers);
    EXPECT_EQ(storage, shared::kMostStorageBuffers);
    EXPECT_EQ(resources, shared::kMostResources);
    EXPECT_LE(push, shared::kMostPushBytes);
}

TEST(Kernel, PushConstantsAreAsLongAsTheirTypes)
{
    EXPECT_EQ(readKernelInterface(k_accumulate).pushBytes, sizeof(shared::Batch));
    EXPECT_EQ(readKernelInterface(k_megakernel).pushBytes, sizeof(shared::Batch));
    EXPECT_EQ(readKernelInterface(k_mean).pushBytes, sizeof(shared::PixelRange));
    EXPECT_EQ(readKernelInterface(k_first_hits).pushBytes, sizeof(shared::TileRange));
    EXPECT_EQ(readKernelInterface(k_seen).pushBytes, sizeof(shared::TileRange));
    EXPECT_EQ(readKernelInterface(k_reuse_old).pushBytes, sizeof(shared::ReuseBatch));
    EXPECT_EQ(readKernelInterface(k_reuse_bounce).pushBytes, sizeof(shared::ReuseBounceBatch));
    EXPECT_EQ(readKernelInterface(k_gather).pushBytes, sizeof(shared::GatherRules));
    EXPECT_EQ(readKernelInterface(k_bench_any).pushBytes, sizeof(shared::ItemRange));
    EXPECT_EQ(readKernelInterface(k_display).pushBytes, sizeof(shared::DisplaySettings));
}

/// Every lane has a group, few have none, and no dimension exceeds what every device takes.
TEST(Kernel, ManyLanesAreRowsOfGroups)
{
    for (const uint64_t lanes :
         {uint64_t(0), uint64_t(1), uint64_t(64), uint64_t(65), uint64_t(32768) * 64,
          uint64_t(32768) * 64 + 1, uint64_t(3840) * 2160, uint64_t(1) << 31}) {
        const gpu::GroupRows rows = gpu::groupRows(lanes);
        EXPECT_LE(std::max(rows.x, rows.y), 65535u) << lanes;
        EXPECT_GE(std::min(rows.x, rows.y), 1u) << lanes;
        EXPECT_GE(uint64_t(rows.x) * rows.y * 64, lanes);
        EXPECT_LE(uint64_t(rows.x) * rows.y, (lanes + 63) / 64 + rows.y) << lanes;
        // The last group's last lane, as kernels number it.
        EXPECT_EQ(shared::rowsLane({rows.x * 64 - 1, rows.y - 1, 0}, {rows.x, rows.y, 1}),
                  rows.x * rows.y * 64 - 1);
    }
}

TEST(Kernel, PipelinesAreMadeOncePerConstants)
{
    gpu::Device device({});
    gpu::Kernel<shared::DisplaySettings, gpu::DisplayChoices> kernel(device, k_display);
    gpu::DisplayChoices choices;
    EXPECT_FALSE(kernel.isCompiled(choices));
    const gpu::Pipeline& first = kernel.pipeline(choices);
    EXPECT_TRUE(kernel.isCompiled(choices));
    choices.swapped = 1;
    EXPECT_FALSE(kernel.isCompiled(choices));
    EXPECT_NE(&kernel.pipeline(choices), &first);
    EXPECT_EQ(&kernel.pipeline({}), &first);
}

TEST(Kernel, PipelinesAreMadeBesideOtherWork)
{
    gpu::Device device({});
    gpu::Kernel<shared::DisplaySettings, gpu::DisplayChoices> kernel(device, k_display);
    const gpu::DisplayChoices choices;
    kernel.compileBeside(choices);
    kernel.compileBeside(choices);  // is under way
    while (!kernel.isCompiled(choices)) std::this_thread::yield();
    const gpu::Pipeline& made = kernel.pipeline(choices);
    EXPECT_NE(made.get(), VkPipeline(VK_NULL_HANDLE));
    EXPECT_EQ(&kernel.pipeline(choices), &made);
    kernel.compileBeside(choices);  // is there
    EXPECT_TRUE(kernel.isCompiled(choices));

    gpu::DisplayChoices other;
    other.swapped = 1;
    kernel.compileBeside(other);
    EXPECT_NE(kernel.pipeline(other).get(), made.get());  // waits for it
    other.swapped = 0;
    other.map = 1;
    kernel.compileBeside(other);  // nobody asks for it: ended with the kernel
}

TEST(Kernel, WhatIsNotCompiledBesideIsReported)
{
    gpu::Device device({});
    gpu::Kernel<shared::DisplaySettings, gpu::DisplayChoices> kernel(device, k_display);
    {
        tests::VulkanFaults faults;
        faults.fail<&gpu::Api::CreateComputePipelines>(VK_ERROR_UNKNOWN);
        kernel.compileBeside();
        while (!kernel.isCompiled()) std::this_thread::yield();
    }
    EXPECT_THROW(kernel.pipeline(), core::Error);
    EXPECT_NE(kernel.pipeline().get(), VkPipeline(VK_NULL_HANDLE));  // anew
}

TEST(Kernel, WhatIsNoKernelIsRefused)
{
    std::vector<uint32_t> text(k_mean, k_mean + std::size(k_mean));
    const auto refused = [](std::span<const uint32_t> spirv, const std::string& why) {
        try {
            readKernelInterface(spirv);
            ADD_FAILURE() << "taken for a kernel: " << why;
        } catch (const core::Error& error) {
            EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
        }
    };
    refused({}, "header");
    refused(std::span(text).first(6), "without an end");  // in the middle of the first instruction
    text[0] ^= 1;
    refused(text, "header");
}

}  // namespace
