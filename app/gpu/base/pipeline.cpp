// Creation of pipelines, through the driver's cache where the device has a folder for it.
#include "app/gpu/base/pipeline.h"

#include <algorithm>
#include <vector>

#include "app/gpu/base/pipeline_cache.h"
#include "core/base/content_hash.h"

namespace gpu {

namespace {

using CacheHandle = Handle<VkPipelineCache, &Api::DestroyPipelineCache>;

CacheKey keyOf(const Device& device, std::span<const uint32_t> spirv,
               const ConstantValues& constants)
{
    const VkPhysicalDeviceProperties& p = device.properties();
    CacheKey key;
    std::copy(std::begin(p.pipelineCacheUUID), std::end(p.pipelineCacheUUID),
              key.cacheUuid.begin());
    key.vendor = p.vendorID;
    key.device = p.deviceID;
    key.driverVersion = p.driverVersion;
    core::ContentHash hash;
    hash.add(std::as_bytes(spirv));
    hash.add(std::as_bytes(constants.values));
    key.kernel = hash.value();
    return key;
}

/// The driver's cache with these bytes in it; none when the driver makes none.
CacheHandle driverCache(const Device& device, std::span<const std::byte> data)
{
    VkPipelineCacheCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO;
    create.initialDataSize = data.size();
    create.pInitialData = data.data();
    VkPipelineCache object = VK_NULL_HANDLE;
    if (vk.CreatePipelineCache(device.get(), &create, nullptr, &object) != VK_SUCCESS) return {};
    return {device.get(), object};
}

std::vector<std::byte> contents(const Device& device, const CacheHandle& cache)
{
    size_t bytes = 0;
    if (!cache || vk.GetPipelineCacheData(device.get(), cache.get(), &bytes, nullptr) != VK_SUCCESS)
        return {};
    std::vector<std::byte> data(bytes);
    if (vk.GetPipelineCacheData(device.get(), cache.get(), &bytes, data.data()) != VK_SUCCESS)
        return {};
    data.resize(bytes);
    // Mesa's software device keeps nothing but the header (it has a cache of its own): not worth a
    // file.
    if (bytes <= sizeof(VkPipelineCacheHeaderVersionOne)) return {};
    return data;
}

}  // namespace

Pipeline::Pipeline(const Device& device, VkPipelineLayout layout, std::span<const uint32_t> spirv,
                   const ConstantValues& constants)
{
    VkShaderModuleCreateInfo module{};
    module.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
    module.codeSize = spirv.size_bytes();
    module.pCode = spirv.data();
    VkShaderModule moduleObject;
    VK_CHECK(vk.CreateShaderModule(device.get(), &module, nullptr, &moduleObject));
    const Handle<VkShaderModule, &Api::DestroyShaderModule> owner(device.get(), moduleObject);

    std::vector<VkSpecializationMapEntry> entries;
    for (uint32_t i = 0; i < constants.values.size(); ++i)
        entries.push_back({constants.first + i, i * uint32_t(sizeof(uint32_t)), sizeof(uint32_t)});
    const VkSpecializationInfo info{static_cast<uint32_t>(entries.size()), entries.data(),
                                    constants.values.size_bytes(), constants.values.data()};
    VkComputePipelineCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO;
    create.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    create.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    create.stage.module = moduleObject;
    create.stage.pName = "main";
    create.stage.pSpecializationInfo = &info;
    create.layout = layout;

    const bool keeps = !device.cacheFolder().empty();
    const CacheKey key = keeps ? keyOf(device, spirv, constants) : CacheKey();
    const std::vector<std::byte> kept =
        keeps ? readCache(device.cacheFolder(), key) : std::vector<std::byte>();
    const CacheHandle cache = keeps ? driverCache(device, kept) : CacheHandle();
    VkPipeline object = VK_NULL_HANDLE;
    VkResult result =
        vk.CreateComputePipelines(device.get(), cache.get(), 1, &create, nullptr, &object);
    if (result < 0 && !kept.empty()) {  // perhaps by what was kept
        result =
            vk.CreateComputePipelines(device.get(), VK_NULL_HANDLE, 1, &create, nullptr, &object);
    }
    if (result == VK_ERROR_OUT_OF_HOST_MEMORY || result == VK_ERROR_OUT_OF_DEVICE_MEMORY) {
        checkVulkan(result, "vkCreateComputePipelines");
    }
    if (result < 0) {
        throw core::Error("a kernel does not compile on " + device.info().name + " (" +
                              device.info().driver + "): " + resultName(result) +
                              " — another driver may do; --device cpu needs none",
                          core::ExitCode::noDevice);
    }
    pipeline_ = {device.get(), object};
    if (keeps && kept.empty()) writeCache(device.cacheFolder(), key, contents(device, cache));
}

}  // namespace gpu
