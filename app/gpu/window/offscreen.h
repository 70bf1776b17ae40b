// An image that stands in for one of the swapchain's: what is drawn into it can be read back.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <glm/glm.hpp>

#include "app/gpu/base/memory.h"

namespace gpu {

class Offscreen {
public:
    /// `renderPass` has one colour attachment of `format`, which has four bytes per pixel.
    Offscreen(Device& device, glm::uvec2 size, VkFormat format, VkRenderPass renderPass);

    VkImage image() const { return image_.get(); }
    VkFramebuffer framebuffer() const { return framebuffer_.get(); }

    /// Records with `draw`, which leaves the image in TRANSFER_SRC, runs it, and returns the bytes,
    /// rows from the top.
    std::vector<uint8_t> read(const std::function<void(VkCommandBuffer)>& draw);

private:
    Device& device_;
    glm::uvec2 size_;
    Buffer bytes_;
    Handle<VkDeviceMemory, &Api::FreeMemory> memory_;
    Handle<VkImage, &Api::DestroyImage> image_;
    Handle<VkImageView, &Api::DestroyImageView> view_;
    Handle<VkFramebuffer, &Api::DestroyFramebuffer> framebuffer_;
};

/// Exchanges the first and third of every four bytes: B8G8R8A8 to R8G8B8A8 and back.
void swapRedAndBlue(std::vector<uint8_t>& bytes);

}  // namespace gpu
