// The text of shared/guide.h on the device against the same text in C++ (T-29), for every
// representation of directions: leaves, densities and samples. Validation is on.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "app/gpu/base/kernel.h"
#include "core/base/pcg32.h"
#include "core/guiding/guide.h"
#include "tests/kernels/guide_check.h"

#include "spirv/guide_check.h"
#include "tests/support/methods/guide_kinds.h"
#include "tests/support/statistics/random_values.h"

namespace {

using core::Pcg32;
using core::guiding::Guide;
using core::guiding::GuideTables;
using core::guiding::PathRecords;
using glm::vec3;
using shared::GuideCheckInput;
using shared::GuideCheckOutput;
using tests::nameOfKind;
using tests::uniform;

constexpr size_t kGuideCases = 50000;

struct GuideConstants {
    static constexpr uint32_t kFirst = shared::kSpecializeGuided;
    uint32_t guided = 0;
};

vec3 someDirection(Pcg32& random)
{
    const float u = uniform(random);
    return shared::sampleSphere({u, uniform(random)});
}

vec3 somewhere(Pcg32& random)
{
    const float x = uniform(random), y = uniform(random);
    return {x, y, uniform(random)};
}

/// What paths leave in a room with a narrow lamp and a wide glow.
std::vector<PathRecords> someRecords(size_t count, uint64_t seed)
{
    Pcg32 random(seed);
    std::vector<PathRecords> parts(1);
    for (size_t i = 0; i < count; ++i) {
        shared::GuideRecord record{};
        record.position = somewhere(random);
        const vec3 wi = someDirection(random);
        record.direction = shared::packOct(wi);
        record.pdf = record.bsdfPdf = 0.25f * shared::kInvPi;
        record.beta = 1;
        record.place = random.bits() % shared::kGuideRoots;
        const float light = 50 * std::exp(300 * (wi.z - 1)) + std::exp(3 * (wi.x - 1));
        parts[0].records.push_back(record);
        parts[0].ends.push_back({1, light * (1 + record.position.x) / record.pdf, 0});
    }
    return parts;
}

template <class T>
gpu::Buffer filled(gpu::Device& device, const std::vector<T>& items,
                   VkFormat format = VK_FORMAT_UNDEFINED)
{
    gpu::Buffer buffer(device, "the guide's", items.size() * sizeof(T), format);
    buffer.writeAll(items);
    return buffer;
}

std::vector<GuideCheckOutput> onDevice(const GuideTables& tables,
                                       const std::vector<GuideCheckInput>& inputs)
{
    gpu::Device device({.index = -1, .validation = true});
    gpu::Kernel<shared::ItemRange, GuideConstants> kernel(device, k_guide_check);
    gpu::DescriptorSet set(device, kernel.own());
    constexpr VkFormat kWords = VK_FORMAT_R32G32B32A32_UINT;
    const gpu::Buffer in = filled(device, inputs);
    const gpu::Buffer out(device, "the answers", inputs.size() * sizeof(GuideCheckOutput));
    const gpu::Buffer nodes = filled(device, tables.nodes, kWords);
    const gpu::Buffer leaves = filled(device, tables.leaves, kWords);
    const gpu::Buffer directions = filled(device, tables.directions, VK_FORMAT_R32G32B32A32_SFLOAT);
    uint32_t binding = 0;
    for (const gpu::Buffer* buffer : {&in, &out, &nodes, &leaves, &directions})
        set.bind(binding++, *buffer);
    const shared::ItemRange range{static_cast<uint32_t>(inputs.size())};
    device.submit([&](VkCommandBuffer commands) {
        kernel.dispatch(commands, kernel.pipeline({tables.kind}), {nullptr, nullptr, &set}, range,
                        gpu::groupsFor(range.count));
        gpu::barrier(commands);
    });
    std::vector<GuideCheckOutput> outputs(inputs.size());
    out.read(std::as_writable_bytes(std::span(outputs)));
    return outputs;
}

bool nearlyEqual(float a, float b)
{
    return std::abs(a - b) <= 1e-4f * std::max(std::abs(a), std::abs(b)) + 1e-12f;
}

class GuideOnDevice : public testing::TestWithParam<uint32_t> {};

TEST_P(GuideOnDevice, SaysWhatTheHostSays)
{
    Guide guide({.kind = GetParam()});
    for (uint64_t k = 1; k <= 3; ++k) guide.learn(someRecords(20000, k), double(k));
    const GuideTables& tables = *guide.tables();
    Pcg32 random(9);
    std::vector<GuideCheckInput> inputs(kGuideCases);
    for (GuideCheckInput& a : inputs) {
        a.position = somewhere(random);
        a.normal = someDirection(random);
        const float x = uniform(random);
        a.u = {x, uniform(random)};
        a.direction = someDirection(random);
    }
    const std::vector<GuideCheckOutput> outputs = onDevice(tables, inputs);
    size_t others = 0;
    for (size_t i = 0; i < inputs.size(); ++i) {
        const GuideCheckOutput host = shared::checkGuide(tables.view(), inputs[i]);
        const GuideCheckOutput& device = outputs[i];
        ASSERT_EQ(device.leaf, host.leaf);
        ASSERT_EQ(device.share, host.share);
        ASSERT_EQ(device.reflected, host.reflected);
        // Rounding may take a direction over the rim of a cell, a number to the next lobe.
        const bool same = nearlyEqual(device.density, host.density) &&
                          nearlyEqual(device.pdf, host.pdf) && device.drawn == host.drawn &&
                          glm::distance(device.wi, host.wi) < 1e-4f;
        others += same ? 0u : 1u;
    }
    EXPECT_LT(others, kGuideCases / 1000);
}

INSTANTIATE_TEST_SUITE_P(Kinds, GuideOnDevice,
                         testing::Values(shared::kGuideHistogram, shared::kGuideLobes,
                                         shared::kGuideTree),
                         nameOfKind);

}  // namespace
