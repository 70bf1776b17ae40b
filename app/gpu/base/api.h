// Every Vulkan function that the program calls, in one table: a test replaces entries to make a
// call fail or a device look different. Entries start out as the loader's own functions.
#pragma once

#include <vulkan/vulkan.h>

namespace gpu {

// clang-format off
#define REKINDLE_VULKAN_FUNCTIONS(X) \
    /* instance and devices */ \
    X(CreateInstance) X(DestroyInstance) X(GetInstanceProcAddr) X(EnumeratePhysicalDevices) \
    X(EnumerateInstanceLayerProperties) X(EnumerateDeviceExtensionProperties) X(GetPhysicalDeviceFeatures2) \
    X(GetPhysicalDeviceProperties2) X(GetPhysicalDeviceMemoryProperties) X(GetPhysicalDeviceQueueFamilyProperties) \
    X(CreateDevice) X(DestroyDevice) X(DeviceWaitIdle) X(GetDeviceQueue) \
    /* presentation */ \
    X(DestroySurfaceKHR) X(GetPhysicalDeviceSurfaceSupportKHR) X(GetPhysicalDeviceSurfaceCapabilitiesKHR) \
    X(GetPhysicalDeviceSurfaceFormatsKHR) X(GetPhysicalDeviceSurfacePresentModesKHR) X(CreateSwapchainKHR) \
    X(DestroySwapchainKHR) X(GetSwapchainImagesKHR) X(AcquireNextImageKHR) X(QueuePresentKHR) \
    /* memory, buffers, images */ \
    X(AllocateMemory) X(FreeMemory) X(MapMemory) X(UnmapMemory) X(CreateBuffer) X(DestroyBuffer) X(BindBufferMemory) \
    X(GetBufferMemoryRequirements) X(CreateBufferView) X(DestroyBufferView) X(CreateImage) X(DestroyImage) \
    X(BindImageMemory) X(GetImageMemoryRequirements) X(CreateImageView) X(DestroyImageView) X(CreateSampler) \
    X(DestroySampler) \
    /* pipelines and what they are given */ \
    X(CreateShaderModule) X(DestroyShaderModule) X(CreatePipelineCache) X(DestroyPipelineCache) X(GetPipelineCacheData) \
    X(CreateComputePipelines) X(DestroyPipeline) X(CreatePipelineLayout) X(DestroyPipelineLayout) \
    X(CreateDescriptorSetLayout) X(DestroyDescriptorSetLayout) X(CreateDescriptorPool) X(DestroyDescriptorPool) \
    X(AllocateDescriptorSets) X(UpdateDescriptorSets) X(CreateRenderPass) X(DestroyRenderPass) X(CreateFramebuffer) \
    X(DestroyFramebuffer) \
    /* commands */ \
    X(CreateCommandPool) X(DestroyCommandPool) X(AllocateCommandBuffers) X(BeginCommandBuffer) X(EndCommandBuffer) \
    X(ResetCommandBuffer) X(CmdBindPipeline) X(CmdBindDescriptorSets) X(CmdPushConstants) X(CmdDispatch) \
    X(CmdDispatchIndirect) X(CmdPipelineBarrier) X(CmdCopyBuffer) X(CmdCopyBufferToImage) X(CmdCopyImageToBuffer) \
    X(CmdFillBuffer) X(CmdUpdateBuffer) X(CmdClearColorImage) X(CmdBeginRenderPass) X(CmdEndRenderPass) \
    /* queues and time */ \
    X(QueueSubmit) X(QueueWaitIdle) X(CreateFence) X(DestroyFence) X(WaitForFences) X(GetFenceStatus) X(ResetFences) \
    X(CreateSemaphore) X(DestroySemaphore) X(CreateQueryPool) X(DestroyQueryPool) X(GetQueryPoolResults) \
    X(CmdResetQueryPool) X(CmdWriteTimestamp)
// clang-format on

struct Api {
#define REKINDLE_ENTRY(name) PFN_vk##name name = vk##name;
    REKINDLE_VULKAN_FUNCTIONS(REKINDLE_ENTRY)
#undef REKINDLE_ENTRY
};

/// The table in use. Replaced only while no device lives, by tests.
inline Api vk;

}  // namespace gpu
