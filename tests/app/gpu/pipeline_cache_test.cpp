// The cache of compiled kernels (V14): what is damaged or foreign counts as absent (how, is tested
// in cache_folder_test), and kernels that do not compile are reported.
#include <gtest/gtest.h>

#include "app/gpu/base/kernel.h"
#include "app/gpu/base/pipeline_cache.h"
#include "spirv/accumulate.h"
#include "tests/support/files/picture_bytes.h"
#include "tests/support/files/temporary_folder.h"
#include "tests/support/files/whole_files.h"
#include "tests/support/vulkan/vulkan_faults.h"

namespace {

using gpu::Api;
using tests::bytesOf;
using tests::TemporaryFolder;
using tests::VulkanFaults;
using tests::writeAll;

gpu::CacheKey someKey()
{
    gpu::CacheKey key;
    key.cacheUuid[3] = 7;
    key.driverVersion = 5;
    key.kernel = 0x1234567890u;
    return key;
}

std::filesystem::path onlyFile(const TemporaryFolder& folder)
{
    EXPECT_EQ(folder.count(), 1u);
    return std::filesystem::directory_iterator(folder.path())->path();
}

TEST(PipelineCache, GivesBackWhatItWasGiven)
{
    const TemporaryFolder folder;
    const auto data = bytesOf("what the driver said");
    EXPECT_TRUE(gpu::readCache(folder.path(), someKey()).empty());
    gpu::writeCache(folder.path(), someKey(), data);
    EXPECT_EQ(gpu::readCache(folder.path(), someKey()), data);
    EXPECT_EQ(folder.count(), 1u);  // nothing unfinished is left
    gpu::writeCache(folder.path(), someKey(), bytesOf("something newer"));
    EXPECT_EQ(gpu::readCache(folder.path(), someKey()), bytesOf("something newer"));
}

TEST(PipelineCache, AnotherDeviceOrDriverOrKernelHasItsOwn)
{
    const TemporaryFolder folder;
    gpu::writeCache(folder.path(), someKey(), bytesOf("mine"));
    const auto differs = [&folder](auto change) {
        gpu::CacheKey key = someKey();
        change(key);
        EXPECT_TRUE(gpu::readCache(folder.path(), key).empty());
    };
    differs([](gpu::CacheKey& k) { k.cacheUuid[15] = 1; });
    differs([](gpu::CacheKey& k) { k.vendor = 1; });
    differs([](gpu::CacheKey& k) { k.device = 1; });
    differs([](gpu::CacheKey& k) { k.driverVersion = 6; });
    differs([](gpu::CacheKey& k) { k.kernel ^= uint64_t(1) << 40; });
    // A file of that other key's name with our content is foreign, too.
    gpu::CacheKey other = someKey();
    other.driverVersion = 6;
    const std::filesystem::path mine = onlyFile(folder);
    gpu::writeCache(folder.path(), other, bytesOf("theirs"));
    for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
        if (entry.path() != mine)
            std::filesystem::copy_file(mine, entry.path(),
                                       std::filesystem::copy_options::overwrite_existing);
    }
    EXPECT_TRUE(gpu::readCache(folder.path(), other).empty());
}

/// A driver that keeps something: it records what it is given, and gives its header and some bytes.
struct KeepingDriver {
    std::vector<size_t> given;
    size_t bytes = 500;

    void install(VulkanFaults& faults)
    {
        faults.replace<&Api::CreatePipelineCache>([this](auto driver, VkDevice device,
                                                         const VkPipelineCacheCreateInfo* info,
                                                         auto* allocator, VkPipelineCache* cache) {
            given.push_back(info->initialDataSize);
            VkPipelineCacheCreateInfo empty = *info;
            empty.initialDataSize = 0;
            return driver(device, &empty, allocator, cache);
        });
        faults.replace<&Api::GetPipelineCacheData>(
            [this](auto, VkDevice, VkPipelineCache, size_t* size, void* data) {
                *size = bytes;
                if (data != nullptr) std::memset(data, 42, bytes);
                return VK_SUCCESS;
            });
    }
};

void makeKernel(const std::filesystem::path& folder, uint32_t features = 0)
{
    gpu::DeviceOptions options;
    options.cacheFolder = folder;
    gpu::Device device(options);
    const gpu::SharedLayouts layouts(device);
    gpu::Kernel<shared::Batch, gpu::FeatureConstants> kernel(device, k_accumulate, &layouts);
    kernel.pipeline({features});
}

TEST(PipelineCache, TheSecondRunGivesTheDriverWhatTheFirstKept)
{
    const TemporaryFolder folder;
    VulkanFaults faults;
    KeepingDriver driver;
    driver.install(faults);
    makeKernel(folder.path());
    makeKernel(folder.path());
    makeKernel(folder.path(), 1);  // specialised in another way: another kernel
    EXPECT_EQ(driver.given, (std::vector<size_t>{0, 500, 0}));
    EXPECT_EQ(folder.count(), 2u);
    for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
        writeAll(entry.path(), "garbage");
    makeKernel(folder.path());
    makeKernel(folder.path());  // what was garbage has been written anew
    EXPECT_EQ(driver.given, (std::vector<size_t>{0, 500, 0, 0, 500}));
    makeKernel("");
    EXPECT_EQ(driver.given.size(), 5u);
    EXPECT_EQ(faults.objects().complaints(), "");
}

TEST(PipelineCache, ADriverThatKeepsOnlyItsHeaderGetsNoFile)
{
    const TemporaryFolder folder;
    VulkanFaults faults;
    KeepingDriver driver;
    driver.bytes = sizeof(VkPipelineCacheHeaderVersionOne);
    driver.install(faults);
    makeKernel(folder.path());
    EXPECT_EQ(folder.count(), 0u);
}

TEST(PipelineCache, AKernelThatFailsWithWhatWasKeptIsCompiledWithoutIt)
{
    const TemporaryFolder folder;
    VulkanFaults faults;
    KeepingDriver driver;
    driver.install(faults);
    makeKernel(folder.path());
    faults.fail<&Api::CreateComputePipelines>(VK_ERROR_UNKNOWN);
    makeKernel(folder.path());
    EXPECT_EQ(faults.struck(), 1u);
    faults.fail<&Api::CreatePipelineCache>(VK_ERROR_OUT_OF_HOST_MEMORY);
    makeKernel(folder.path());
    EXPECT_EQ(faults.struck(), 2u);
    EXPECT_EQ(faults.objects().complaints(), "");
}

TEST(PipelineCache, AKernelThatDoesNotCompileIsToldWithItsDevice)
{
    const std::string device = gpu::Device({}).info().name;
    VulkanFaults faults;
    faults.fail<&Api::CreateComputePipelines>(VK_ERROR_UNKNOWN);
    try {
        makeKernel("");
        ADD_FAILURE() << "nothing was thrown";
    } catch (const core::Error& error) {
        EXPECT_EQ(error.code(), core::ExitCode::noDevice);
        const std::string text = error.what();
        EXPECT_NE(text.find("does not compile on " + device), std::string::npos) << text;
        EXPECT_NE(text.find("VK_ERROR_UNKNOWN"), std::string::npos) << text;
    }
    EXPECT_EQ(faults.objects().complaints(), "");
}

}  // namespace
