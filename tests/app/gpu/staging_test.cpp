// Copies to and from memory that the host cannot map: one staging buffer serves them all, and what
// comes back is what went in, also where it takes several pieces.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "app/gpu/base/memory.h"
#include "shared/bindings.h"
#include "tests/support/vulkan/staged_memory.h"

namespace {

using gpu::Api;
using tests::VulkanFaults;

std::vector<std::byte> numbered(size_t bytes, uint32_t seed)
{
    std::vector<std::byte> data(bytes);
    for (size_t i = 0; i < bytes; ++i)
        data[i] = static_cast<std::byte>((i * 2654435761u + seed) >> 13);
    return data;
}

std::vector<std::byte> roundTrip(gpu::Buffer& buffer, const std::vector<std::byte>& data,
                                 uint64_t offset = 0)
{
    buffer.write(data, offset);
    std::vector<std::byte> back(data.size());
    buffer.read(back, offset);
    return back;
}

TEST(Staging, OneBufferServesManyCopies)
{
    VulkanFaults faults;
    tests::StagedMemory memory(faults);
    {
        gpu::Device device({});
        gpu::Buffer buffer(device, "a test", 100000);
        const auto made = [&] { return faults.calls<&Api::CreateBuffer>(); };
        const size_t before = made();
        EXPECT_EQ(roundTrip(buffer, numbered(60000, 1)), numbered(60000, 1));
        EXPECT_EQ(made(), before + 1);
        for (uint32_t i = 2; i < 20; ++i) {  // none is larger than the first was rounded up to
            const std::vector<std::byte> data = numbered(65536 - 100 * i, i);
            EXPECT_EQ(roundTrip(buffer, data, 16 * i), data);
        }
        EXPECT_EQ(made(), before + 1);
        EXPECT_EQ(roundTrip(buffer, numbered(100000, 30)), numbered(100000, 30));
        EXPECT_EQ(made(), before + 2) << "a larger one takes its place";
        roundTrip(buffer, {});
        EXPECT_EQ(made(), before + 2);
    }
    EXPECT_EQ(faults.objects().complaints(), "");
}

TEST(Staging, LargeCopiesGoInPieces)
{
    VulkanFaults faults;
    tests::StagedMemory memory(faults);
    {
        gpu::Device device({});
        const size_t bytes = (size_t(64) << 20) + 12345 * 16;  // one whole piece and a bit
        gpu::Buffer buffer(device, "a test", bytes);
        const size_t before = faults.calls<&Api::CmdCopyBuffer>();
        const std::vector<std::byte> data = numbered(bytes, 5);
        EXPECT_TRUE(roundTrip(buffer, data) == data);
        EXPECT_EQ(faults.calls<&Api::CmdCopyBuffer>(), before + 4);
    }
    EXPECT_EQ(faults.objects().complaints(), "");
}

TEST(Staging, MappedMemoryNeedsNone)
{
    VulkanFaults faults;
    const tests::StagedMemory memory(faults, {tests::StagedMemory::kAllMapped});
    gpu::Device device({});
    gpu::Buffer buffer(device, "a test", 1000);
    const size_t before = faults.calls<&Api::CreateBuffer>();
    EXPECT_EQ(roundTrip(buffer, numbered(1000, 1)), numbered(1000, 1));
    EXPECT_EQ(faults.calls<&Api::CreateBuffer>(), before);
}

/// As on graphics cards with a resizable BAR: the host writes to the device's memory itself, but
/// has no cache for what it would read there.
TEST(Staging, MemoryWithoutACacheIsReadThroughOne)
{
    using Memory = tests::StagedMemory;
    VulkanFaults faults;
    const Memory memory(faults, {Memory::kLocal | Memory::kMapped, Memory::kMapped,
                                 Memory::kMapped | Memory::kCached});
    {
        gpu::Device device({});
        gpu::Buffer buffer(device, "a test", 1000);
        EXPECT_EQ(memory.allocated.back(), 0u);
        const auto copies = [&] { return faults.calls<&Api::CmdCopyBuffer>(); };
        const size_t before = copies();
        const std::vector<std::byte> data = numbered(1000, 1);
        buffer.write(data);
        EXPECT_EQ(copies(), before);
        std::vector<std::byte> few(16), all(1000);
        buffer.read(few);
        EXPECT_TRUE(std::equal(few.begin(), few.end(), data.begin()));
        std::vector<std::byte> counters(sizeof(shared::Counters));
        buffer.read(counters);
        EXPECT_TRUE(std::equal(counters.begin(), counters.end(), data.begin()));
        EXPECT_EQ(copies(), before) << "so little is not worth a submission";
        buffer.read(all);
        EXPECT_EQ(all, data);
        EXPECT_EQ(copies(), before + 1);
        EXPECT_EQ(memory.allocated.back(), 2u);
    }
    EXPECT_EQ(faults.objects().complaints(), "");
}

/// Where the device's own memory is at an end buffers are in the host's, whatever the order of the
/// types.
TEST(Staging, BuffersFindTheHostsMemory)
{
    using Memory = tests::StagedMemory;
    const std::vector<VkMemoryPropertyFlags> orders[] = {
        {Memory::kLocal, Memory::kMapped},
        {Memory::kLocal, Memory::kLocal | Memory::kMapped, Memory::kMapped},
        {Memory::kMapped, Memory::kLocal}};
    for (const auto& types : orders) {
        VulkanFaults faults;
        Memory memory(faults, types);
        {
            gpu::Device device({});
            uint32_t host = 0;
            for (uint32_t i = 0; i < types.size(); ++i) {
                if ((types[i] & Memory::kLocal) != 0)
                    memory.exhausted.insert(i);
                else
                    host = i;
            }
            gpu::Buffer buffer(device, "a test", 1000);
            EXPECT_EQ(memory.allocated.back(), host);
            EXPECT_EQ(roundTrip(buffer, numbered(1000, 3)), numbered(1000, 3));
            memory.exhausted.insert(host);
            EXPECT_THROW(gpu::Buffer(device, "a test", 1000), core::Error);
        }
        EXPECT_EQ(faults.objects().complaints(), "");
    }
}

TEST(Staging, AFailureLeavesTheNextCopyPossible)
{
    VulkanFaults faults;
    tests::StagedMemory memory(faults);
    {
        gpu::Device device({});
        gpu::Buffer buffer(device, "a test", 1000);
        faults.fail<&Api::CreateBuffer>(VK_ERROR_OUT_OF_HOST_MEMORY);
        EXPECT_THROW(buffer.write(numbered(1000, 1)), core::Error);
        EXPECT_EQ(roundTrip(buffer, numbered(1000, 2)), numbered(1000, 2));
    }
    EXPECT_EQ(faults.objects().complaints(), "");
}

}  // namespace
