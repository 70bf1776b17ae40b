// See backend.h.
#include "app/view/imgui/backend.h"

#include <utility>

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_vulkan.h>
#include <imgui.h>

namespace app {

namespace {

using gpu::vk;

VkResult imguiResult = VK_SUCCESS;  // the first failure inside ImGui's back end

void onImguiResult(VkResult result)
{
    if (result < 0 && imguiResult >= 0) imguiResult = result;
}

VkDescriptorPool makePool(VkDevice device)
{
    constexpr uint32_t kImages = 8;  // one for the letters; since 1.91.6 the back end wants room
    const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, kImages};
    VkDescriptorPoolCreateInfo pool{};
    pool.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO;
    pool.flags = VK_DESCRIPTOR_POOL_CREATE_FREE_DESCRIPTOR_SET_BIT;  // it frees them since 1.90
    pool.maxSets = kImages;
    pool.poolSizeCount = 1;
    pool.pPoolSizes = &size;
    VkDescriptorPool object;
    VK_CHECK(vk.CreateDescriptorPool(device, &pool, nullptr, &object));
    return object;
}

void startBackEnd(ImGui_ImplVulkan_InitInfo& init, VkRenderPass renderPass)
{
#if IMGUI_VERSION_NUM >= 19240
    init.PipelineInfoMain.RenderPass = renderPass;
    init.PipelineInfoMain.MSAASamples = VK_SAMPLE_COUNT_1_BIT;
    ImGui_ImplVulkan_Init(&init);
#elif IMGUI_VERSION_NUM >= 19030
    init.RenderPass = renderPass;
    init.MSAASamples = VK_SAMPLE_COUNT_1_BIT;
    ImGui_ImplVulkan_Init(&init);
#else
    init.MSAASamples = VK_SAMPLE_COUNT_1_BIT;
    ImGui_ImplVulkan_Init(&init, renderPass);
#endif
}

void uploadFonts([[maybe_unused]] gpu::Device& device)
{
#if IMGUI_VERSION_NUM >= 19200
    // Letters are drawn and uploaded as they are needed.
#elif IMGUI_VERSION_NUM >= 19000
    ImGui_ImplVulkan_CreateFontsTexture();
#else
    device.submit([](VkCommandBuffer commands) { ImGui_ImplVulkan_CreateFontsTexture(commands); });
    ImGui_ImplVulkan_DestroyFontUploadObjects();
#endif
}

}  // namespace

void checkImgui()
{
    gpu::checkVulkan(std::exchange(imguiResult, VK_SUCCESS), "a call of Dear ImGui");
}

ImguiContext::ImguiContext(GLFWwindow* window)
{
    IMGUI_CHECKVERSION();
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;
    ImGui::GetIO().LogFilename = nullptr;
    ImGui_ImplGlfw_InitForVulkan(window, true);
}

ImguiContext::~ImguiContext()
{
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
}

ImguiVulkan::ImguiVulkan(gpu::Device& device, VkRenderPass renderPass, uint32_t frames)
    : device_(device.get()), pool_(device.get(), makePool(device.get()))
{
    ImGui_ImplVulkan_InitInfo init{};
    init.Instance = device.instance();
    init.PhysicalDevice = device.physical();
    init.Device = device.get();
    init.QueueFamily = device.queueFamily();
    init.Queue = device.queue();
    init.DescriptorPool = pool_.get();
    init.MinImageCount = 2;
    init.ImageCount = frames;
    init.CheckVkResultFn = onImguiResult;
    imguiResult = VK_SUCCESS;
    startBackEnd(init, renderPass);
    uploadFonts(device);
}

ImguiVulkan::~ImguiVulkan()
{
    if (!gpu::isAbandoned(device_)) {
        ImGui_ImplVulkan_Shutdown();
        return;
    }
    ImGui::GetIO().BackendRendererName = nullptr;  // a device that hangs keeps what it has
    ImGui::GetIO().BackendRendererUserData = nullptr;
}

void beginImguiFrame()
{
    ImGui_ImplVulkan_NewFrame();
    ImGui_ImplGlfw_NewFrame();
}

}  // namespace app
