// Dear ImGui's context and its back ends for GLFW and Vulkan, whose calls change from version to
// version. In use with 1.86; what changed up to 1.92 follows its release notes.
#pragma once

#include "app/gpu/base/device.h"
#include "app/gpu/base/handle.h"

struct GLFWwindow;

namespace app {

/// Throws core::Error when a Vulkan call inside ImGui has failed since the last check.
void checkImgui();

/// ImGui's context and its GLFW back end, in the order in which they live.
class ImguiContext {
public:
    explicit ImguiContext(GLFWwindow* window);
    ~ImguiContext();
    ImguiContext(const ImguiContext&) = delete;
    ImguiContext& operator=(const ImguiContext&) = delete;
};

/// The Vulkan back end, with the fonts that ImGui holds when it is made.
class ImguiVulkan {
public:
    /// `frames`: sets of vertices to keep, one for each picture under way.
    ImguiVulkan(gpu::Device& device, VkRenderPass renderPass, uint32_t frames);
    ~ImguiVulkan();
    ImguiVulkan(const ImguiVulkan&) = delete;
    ImguiVulkan& operator=(const ImguiVulkan&) = delete;

private:
    VkDevice device_;
    gpu::Handle<VkDescriptorPool, &gpu::Api::DestroyDescriptorPool> pool_;
};

/// Starts a frame of both back ends; ImGui::NewFrame is the caller's.
void beginImguiFrame();

}  // namespace app
