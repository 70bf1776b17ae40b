// Frames on a surface: acquires an image, hands out a command buffer, submits and presents; makes
// the swapchain anew when the surface asks for it, and the surface when that is lost.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "app/gpu/base/device.h"

namespace gpu {

/// What the display system says about a swapchain; every other failure is an Error.
enum class Outcome {
    ok,
    notReady,     // no image within the time: nothing is wrong, nothing was acquired
    suboptimal,   // it worked, but a new swapchain would fit better
    outOfDate,    // a new swapchain is needed (size, mode, or full-screen access lost)
    surfaceLost,  // a new surface is needed
};

/// Of acquiring, presenting, creating a swapchain and asking for the capabilities of a surface.
/// Throws as Device::check for what is none of the above.
Outcome outcomeOf(Device& device, VkResult result, const char* call);

/// What one frame is drawn into. The image is in no layout that matters (undefined).
struct WindowFrame {
    VkCommandBuffer commands = VK_NULL_HANDLE;  // being recorded
    VkImage image = VK_NULL_HANDLE;
    VkFramebuffer framebuffer = VK_NULL_HANDLE;  // of renderPass()
    glm::uvec2 size{0};
};

class Swapchain {
public:
    static constexpr uint32_t kSlots = 2;  // frames in flight

    /// Takes the device's surface; `makeSurface` makes another when it is lost. Throws core::Error
    /// (noDevice) when the surface takes no format that fits.
    Swapchain(Device& device, std::function<VkSurfaceKHR(VkInstance)> makeSurface);
    ~Swapchain();
    Swapchain(const Swapchain&) = delete;
    Swapchain& operator=(const Swapchain&) = delete;

    /// Waits for the commands of two frames ago, then acquires an image; none when there is nothing
    /// to draw on now: skip the frame. `size` is that of the window's framebuffer.
    std::optional<WindowFrame> begin(glm::uvec2 size);

    /// Submits and presents what has been recorded since begin(); the commands leave the image in
    /// PRESENT_SRC. False when it was not shown: the next begin() makes what is needed anew.
    bool end();

    /// Until no submitted commands run.
    void wait();

    /// The same for ends: does not fail, and does not wait for a device that hangs.
    void settle() noexcept;

    /// One colour attachment of format(), loaded and stored, in COLOR_ATTACHMENT_OPTIMAL before and
    /// after.
    VkRenderPass renderPass() const { return renderPass_.get(); }
    VkFormat format() const { return format_.format; }
    bool swapped() const { return format_.format == VK_FORMAT_B8G8R8A8_UNORM; }  // blue comes first
    uint64_t made() const { return made_; }  // swapchains so far

private:
    struct Image {
        VkImage image = VK_NULL_HANDLE;
        Handle<VkImageView, &Api::DestroyImageView> view;
        Handle<VkFramebuffer, &Api::DestroyFramebuffer> framebuffer;
        Handle<VkSemaphore, &Api::DestroySemaphore> drawn;  // waited for by the presentation
    };
    struct Chain {
        Handle<VkSwapchainKHR, &Api::DestroySwapchainKHR> swapchain;
        std::vector<Image> images;
        // Signalled, and never waited for
        std::vector<Handle<VkSemaphore, &Api::DestroySemaphore>> abandoned;
        glm::uvec2 size{0};
        bool presented = false, replaced = false;
        uint64_t retired = 0;  // last frame that may have used it
    };
    struct Slot {
        VkCommandBuffer commands = VK_NULL_HANDLE;
        Handle<VkFence, &Api::DestroyFence> fence;
        Handle<VkSemaphore, &Api::DestroySemaphore> acquired;
        uint64_t frame = 0;  // that runs, 0: none
    };

    Handle<VkSemaphore, &Api::DestroySemaphore> semaphore() const;
    void chooseFormat();
    void makeRenderPass();
    void waitFor(Slot& slot);
    void retire();
    void destroyRetired();
    void renewSurface();
    bool makeChain(glm::uvec2 size);
    std::optional<Outcome> acquire(glm::uvec2 size);
    Image makeImage(VkImage image, glm::uvec2 size);

    Device& device_;
    std::function<VkSurfaceKHR(VkInstance)> makeSurface_;
    VkSurfaceKHR surface_ = VK_NULL_HANDLE;
    VkSurfaceFormatKHR format_{};
    VkPresentModeKHR presentMode_ = VK_PRESENT_MODE_FIFO_KHR;
    Handle<VkRenderPass, &Api::DestroyRenderPass> renderPass_;
    Handle<VkCommandPool, &Api::DestroyCommandPool> pool_;
    std::array<Slot, kSlots> slots_;
    std::vector<Chain> retired_;
    Chain chain_;
    glm::uvec2 wanted_{0};  // the size that chain_ was made for
    bool stale_ = true;     // chain_ must be made anew
    bool open_ = false;     // between begin and end
    uint32_t next_ = 0, image_ = 0;
    int losses_ = 0;  // of the surface, in a row
    uint64_t submitted_ = 0, completed_ = 0, made_ = 0;
};

}  // namespace gpu
