// Barriers (V2): the rules, the kernels' accesses, planted gaps, and all methods under watch, with
// every barrier left out once to see that the watch would notice.
#include <vector>

#include <gtest/gtest.h>

#include "app/gpu/base/kernel.h"
#include "app/gpu/frame.h"
#include "app/gpu/methods/methods.h"
#include "app/gpu/methods/path.h"
#include "app/gpu/window/display.h"
#include "core/gltf/gltf.h"
#include "core/methods/method.h"
#include "core/methods/reuse_params.h"
#include "spirv/accumulate.h"
#include "spirv/bounce.h"
#include "tests/support/vulkan/barrier_watch.h"
#include "tests/support/vulkan/staged_memory.h"

namespace {

using gpu::Api;
using tests::BarrierWatch;
using tests::missingBarriers;
using tests::VulkanFaults;
using tests::WatchedCommand;

constexpr VkPipelineStageFlags kCompute = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
constexpr VkPipelineStageFlags kTransfer = VK_PIPELINE_STAGE_TRANSFER_BIT;

std::string all(const std::vector<std::string>& lines)
{
    std::string text;
    for (const std::string& line : lines) text += line + '\n';
    return text;
}

// --- the rules

const WatchedCommand kFill{"fill", {{1, kTransfer, VK_ACCESS_TRANSFER_WRITE_BIT}}};
const WatchedCommand kReader{"reader", {{1, kCompute, VK_ACCESS_SHADER_READ_BIT}}};
const WatchedCommand kWriter{"writer", {{1, kCompute, VK_ACCESS_SHADER_WRITE_BIT}}};
const WatchedCommand kIndirect{
    "indirect", {{1, VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT, VK_ACCESS_INDIRECT_COMMAND_READ_BIT}}};

WatchedCommand barrierOf(VkPipelineStageFlags from, VkPipelineStageFlags to,
                         VkAccessFlags fromAccess, VkAccessFlags toAccess)
{
    return {"barrier", {}, from, to, fromAccess, toAccess};
}

TEST(Barriers, WhatTheSpecificationDemandsIsDemanded)
{
    const VkAccessFlags write = VK_ACCESS_SHADER_WRITE_BIT, read = VK_ACCESS_SHADER_READ_BIT;
    const WatchedCommand full = barrierOf(kCompute, kCompute, write, read | write);
    const WatchedCommand order = barrierOf(kCompute, kCompute, 0, 0);
    EXPECT_EQ(missingBarriers({kWriter, kReader}).size(), 1u);
    EXPECT_EQ(missingBarriers({kWriter, kWriter}).size(), 1u);  // what the layer does not see
    EXPECT_EQ(missingBarriers({kReader, kWriter}).size(), 1u);
    EXPECT_EQ(missingBarriers({kReader, kReader}).size(), 0u);
    EXPECT_EQ(missingBarriers({kWriter, full, kReader}).size(), 0u);
    EXPECT_EQ(missingBarriers({kWriter, full, kWriter}).size(), 0u);
    EXPECT_EQ(missingBarriers({kReader, order, kWriter}).size(),
              0u);  // order is enough after a read
    EXPECT_EQ(missingBarriers({kWriter, order, kReader}).size(),
              1u);  // and not enough after a write
    EXPECT_EQ(
        missingBarriers({kWriter, barrierOf(kCompute, kCompute, write, read), kWriter}).size(), 1u);
    EXPECT_EQ(missingBarriers({kFill, full, kReader}).size(), 1u);  // waits for the wrong stage
    EXPECT_EQ(
        missingBarriers(
            {kFill, barrierOf(kTransfer, kCompute, VK_ACCESS_TRANSFER_WRITE_BIT, read), kReader})
            .size(),
        0u);
    EXPECT_EQ(missingBarriers({kWriter, full, kIndirect}).size(), 1u);
    EXPECT_EQ(missingBarriers({kWriter, full, kReader}, 1).size(), 1u);
    EXPECT_EQ(missingBarriers({kWriter, full, kWriter, kReader}).size(),
              1u);  // the barrier is before, not between
    EXPECT_EQ(
        missingBarriers({kWriter, full, kReader, kReader, full, kWriter, full, kIndirect}).size(),
        1u);
}

TEST(Barriers, ChainsOfBarriersHold)
{
    const VkAccessFlags write = VK_ACCESS_SHADER_WRITE_BIT;
    const WatchedCommand toTransfer =
        barrierOf(kCompute, kTransfer, write, VK_ACCESS_TRANSFER_READ_BIT);
    const WatchedCommand fromTransfer =
        barrierOf(kTransfer, kCompute, 0, VK_ACCESS_SHADER_READ_BIT);
    EXPECT_EQ(missingBarriers({kWriter, toTransfer, fromTransfer, kReader}).size(), 0u);
    EXPECT_EQ(missingBarriers({kWriter, fromTransfer, toTransfer, kReader}).size(), 1u);
}

TEST(Barriers, TheKernelsTextSaysWhatIsTouched)
{
    const VkAccessFlags read = VK_ACCESS_SHADER_READ_BIT, write = VK_ACCESS_SHADER_WRITE_BIT;
    const uint32_t scene = shared::kSetScene, frame = shared::kSetFrame, own = shared::kSetKernel;
    const std::map<tests::SetBinding, VkAccessFlags> accumulate{
        {{frame, shared::kBindFrame}, VK_ACCESS_UNIFORM_READ_BIT},
        {{frame, shared::kBindCounters}, read | write},
        {{own, shared::kBindRadiance}, read},
        {{own, shared::kBindFilm0}, read | write},
        {{own, shared::kBindFilm1}, read | write},
        {{own, shared::kBindFilm2}, read | write},
        {{own, shared::kBindFilmWeight}, read | write}};
    EXPECT_EQ(tests::kernelAccess(k_accumulate), accumulate);
    const auto bounce = tests::kernelAccess(k_bounce);
    EXPECT_EQ(bounce.at({own, shared::kBindStates}), write);
    EXPECT_EQ(bounce.at({own, shared::kBindStateTexels}), read);
    EXPECT_EQ(bounce.at({scene, shared::kBindNodes}), read);
    EXPECT_EQ(bounce.at({own, shared::kBindQueues}), read | write);
    EXPECT_EQ(bounce.at({own, shared::kBindRadiance}), read | write);
    EXPECT_FALSE(bounce.contains({own, shared::kBindFilmWeight}));
}

// --- planted gaps

TEST(Barriers, AGapBetweenTwoWritesIsSeenAcrossSubmissionsToo)
{
    VulkanFaults faults;
    BarrierWatch watch(faults);
    gpu::Device device({});
    const gpu::Buffer a(device, "a test", 1024), b(device, "a test", 1024);
    const auto fill = [&](VkCommandBuffer commands, const gpu::Buffer& buffer) {
        gpu::vk.CmdFillBuffer(commands, buffer.get(), 0, VK_WHOLE_SIZE, 0);
    };
    device.submit([&](VkCommandBuffer commands) {
        fill(commands, a);
        fill(commands, b);
        gpu::barrier(commands);
        fill(commands, a);
    });
    EXPECT_EQ(all(missingBarriers(watch.commands())), "");
    device.submit([&](VkCommandBuffer commands) {
        fill(commands, b);
    });  // the barrier was in the other submission
    EXPECT_EQ(all(missingBarriers(watch.commands())), "");
    // A has been written since
    device.submit([&](VkCommandBuffer commands) { fill(commands, a); });
    EXPECT_EQ(missingBarriers(watch.commands()).size(), 1u)
        << all(missingBarriers(watch.commands()));
}

TEST(Barriers, AForgottenBarrierBetweenDispatchesIsSeen)
{
    for (const bool forgotten : {false, true}) {
        VulkanFaults faults;
        BarrierWatch watch(faults);
        gpu::Device device({});
        const gpu::SharedLayouts layouts(device);
        gpu::Kernel<shared::Batch> kernel(device, k_accumulate, &layouts);
        gpu::DescriptorSet own(device, kernel.own());
        const gpu::Frame frame(device, layouts);
        const gpu::Buffer film(device, "a film", 1024);
        own.bind(shared::kBindFilm0, film);
        device.submit([&](VkCommandBuffer commands) {
            for (int i = 0; i < 2; ++i) {
                kernel.dispatch(commands, kernel.pipeline(), {nullptr, &frame.set(), &own}, {}, 1);
                if (!forgotten) gpu::barrier(commands);
            }
        });
        EXPECT_EQ(missingBarriers(watch.commands()).empty(), !forgotten)
            << all(missingBarriers(watch.commands()));
    }
}

// --- the renderers

/// Leaves out every barrier in turn and counts how often the watch notices. It cannot notice the
/// absence of those that serve the host alone, nor of the second of two that follow each other
/// across a submission.
size_t noticedGaps(const std::vector<WatchedCommand>& commands, size_t& barriers)
{
    size_t noticed = 0;
    barriers = 0;
    for (size_t i = 0; i < commands.size(); ++i) {
        if (!commands[i].isBarrier()) continue;
        ++barriers;
        noticed += missingBarriers(commands, i).empty() ? 0u : 1u;
    }
    return noticed;
}

std::vector<VkMemoryPropertyFlags> typesOfMemory(bool staged)
{
    using Memory = tests::StagedMemory;
    if (!staged) return {Memory::kAllMapped};
    return {Memory::kLocal, Memory::kMapped};
}

/// Renders small images under watch and returns the last.
core::Estimate watchRenderer(core::Kernel kernel, bool staged)
{
    const auto world =
        core::makeWorld(core::loadGltf(REKINDLE_SOURCE_DIR "/assets/textured-box.gltf"));
    core::Estimate film;
    VulkanFaults faults;
    BarrierWatch watch(faults);
    const tests::StagedMemory memory(faults, typesOfMemory(staged));
    {
        const auto renderer = gpu::makePathRenderer({});
        renderer->setWorld(world, {});
        core::PathParams params;
        params.kernel = kernel;
        params.maxDepth = 20;  // more than one submission of bounces
        params.rouletteDepth = 4096;
        for (const uint32_t size : {40u, 24u}) {
            renderer->setView({world->cameras.at(0), {size, size}, params}, core::Start::anew);
            for (int i = 0; i < 2; ++i) renderer->advance({.samples = 2}, {});
            film = renderer->read(core::Reading::everything);
            renderer->read(core::Reading::mean);
            renderer->aovs();
        }
    }
    const std::vector<std::string> missing = missingBarriers(watch.commands());
    EXPECT_EQ(missing.size(), 0u) << all(missing).substr(0, 2000);
    size_t barriers = 0;
    const size_t noticed = noticedGaps(watch.commands(), barriers);
    EXPECT_GT(barriers, 10u);
    EXPECT_GE(3 * noticed, barriers)
        << "of " << barriers << " gaps only " << noticed << " are noticed";
    EXPECT_EQ(faults.calls<&Api::CmdCopyBuffer>() > 10, staged);
    EXPECT_EQ(faults.objects().complaints(), "");
    return film;
}

TEST(Barriers, ThePathTracerHasThemAllAndStagedMemoryGivesTheSameImage)
{
    const core::Estimate mapped = watchRenderer(core::Kernel::wavefront, false);
    const core::Estimate staged = watchRenderer(core::Kernel::wavefront, true);
    EXPECT_EQ(mapped.mean.pixels, staged.mean.pixels);
    EXPECT_EQ(mapped.mean.pixels, watchRenderer(core::Kernel::megakernel, true).mean.pixels);
}

/// Two views of a method, the second one moved.
void watchMethod(const gpu::Method& method, const core::AnyParams& params)
{
    static const auto world =
        core::makeWorld(core::loadGltf(REKINDLE_SOURCE_DIR "/assets/textured-box.gltf"));
    VulkanFaults faults;
    BarrierWatch watch(faults);
    const tests::StagedMemory memory(faults, typesOfMemory(true));
    {
        const auto renderer = method.make({});
        renderer->setWorld(world, {});
        core::Camera camera = world->cameras.at(0);
        for (const core::Start start : {core::Start::anew, core::Start::moved}) {
            renderer->setView({camera, {16, 12}, params}, start);
            for (int i = 0; i < 2; ++i) renderer->advance({.samples = 1}, {});
            renderer->read(core::Reading::everything);
            renderer->read(core::Reading::mean);
            renderer->aovs();
            renderer->maps();
            camera.position.x += 0.01;
        }
    }
    const std::vector<std::string> missing = missingBarriers(watch.commands());
    EXPECT_EQ(missing.size(), 0u) << all(missing).substr(0, 2000);
    size_t barriers = 0;
    EXPECT_GT(noticedGaps(watch.commands(), barriers), 4u) << "of " << barriers;
    EXPECT_EQ(faults.objects().complaints(), "");
}

TEST(Barriers, SlowEveryMethodHasThemAll)
{
    for (const gpu::Method& method : gpu::methods()) {
        if (method.make == nullptr) continue;
        SCOPED_TRACE(method.id);
        watchMethod(method, core::findMethod(method.id)->defaults);
        if (method.id != "reuse") continue;
        for (const core::ReuseStrategy strategy :
             {core::ReuseStrategy::svgf, core::ReuseStrategy::full})
            watchMethod(method, core::ReuseParams{.reuse = strategy});
    }
}

/// The display kernel as the window uses it: frames that are not waited for, the output copied
/// after each.
TEST(Barriers, TheDisplayHasThemAll)
{
    for (const bool staged : {false, true}) {
        VulkanFaults faults;
        BarrierWatch watch(faults);
        const tests::StagedMemory memory(faults, typesOfMemory(staged));
        {
            gpu::Device device({});
            gpu::Display display(device);
            const core::Image image(20, 10, 3);
            const gpu::Buffer copy(device, "a copy", 20 * 10 * 4);
            display.setSize(20, 10);
            for (int frame = 0; frame < 3; ++frame) {
                display.setImage(0, &image);
                device.submit([&](VkCommandBuffer commands) {
                    for (int i = 0; i < 2; ++i) {
                        display.record(commands, {}, false);
                        const VkBufferCopy region{0, 0, copy.bytes()};
                        if (i == 0)
                            gpu::vk.CmdCopyBuffer(commands, display.output().get(), copy.get(), 1,
                                                  &region);
                    }
                });
            }
        }
        EXPECT_GE(watch.commands().size(), 12u);
        EXPECT_EQ(all(missingBarriers(watch.commands())), "") << (staged ? "staged" : "mapped");
    }
}

}  // namespace
