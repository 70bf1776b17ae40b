// A colour attachment with its memory, view and framebuffer, and a buffer for its pixels.
#include "app/gpu/window/offscreen.h"

#include <optional>

namespace gpu {

namespace {

uint32_t deviceLocalType(VkPhysicalDevice physical, uint32_t allowed)
{
    VkPhysicalDeviceMemoryProperties properties;
    vk.GetPhysicalDeviceMemoryProperties(physical, &properties);
    std::optional<uint32_t> any;
    for (uint32_t i = 0; i < properties.memoryTypeCount; ++i) {
        if ((allowed >> i & 1) == 0) continue;
        if ((properties.memoryTypes[i].propertyFlags & VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT) != 0)
            return i;
        if (!any) any = i;
    }
    return any.value();
}

}  // namespace

Offscreen::Offscreen(Device& device, glm::uvec2 size, VkFormat format, VkRenderPass renderPass)
    : device_(device), size_(size), bytes_(device, "the screenshot", uint64_t(size.x) * size.y * 4)
{
    VkImageCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO;
    create.imageType = VK_IMAGE_TYPE_2D;
    create.format = format;
    create.extent = {size.x, size.y, 1};
    create.mipLevels = 1;
    create.arrayLayers = 1;
    create.samples = VK_SAMPLE_COUNT_1_BIT;
    create.tiling = VK_IMAGE_TILING_OPTIMAL;
    create.usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT |
                   VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    VkImage image;
    VK_CHECK(vk.CreateImage(device.get(), &create, nullptr, &image));
    image_ = {device.get(), image};
    VkMemoryRequirements needs;
    vk.GetImageMemoryRequirements(device.get(), image, &needs);
    VkMemoryAllocateInfo allocate{};
    allocate.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
    allocate.allocationSize = needs.size;
    allocate.memoryTypeIndex = deviceLocalType(device.physical(), needs.memoryTypeBits);
    VkDeviceMemory memory;
    VK_CHECK(vk.AllocateMemory(device.get(), &allocate, nullptr, &memory));
    memory_ = {device.get(), memory};
    VK_CHECK(vk.BindImageMemory(device.get(), image, memory, 0));

    VkImageViewCreateInfo view{};
    view.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO;
    view.image = image;
    view.viewType = VK_IMAGE_VIEW_TYPE_2D;
    view.format = format;
    view.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    VkImageView viewObject;
    VK_CHECK(vk.CreateImageView(device.get(), &view, nullptr, &viewObject));
    view_ = {device.get(), viewObject};
    VkFramebufferCreateInfo framebuffer{};
    framebuffer.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO;
    framebuffer.renderPass = renderPass;
    framebuffer.attachmentCount = 1;
    framebuffer.pAttachments = &viewObject;
    framebuffer.width = size.x;
    framebuffer.height = size.y;
    framebuffer.layers = 1;
    VkFramebuffer framebufferObject;
    VK_CHECK(vk.CreateFramebuffer(device.get(), &framebuffer, nullptr, &framebufferObject));
    framebuffer_ = {device.get(), framebufferObject};
}

std::vector<uint8_t> Offscreen::read(const std::function<void(VkCommandBuffer)>& draw)
{
    device_.submit([&](VkCommandBuffer commands) {
        draw(commands);
        VkBufferImageCopy copy{};
        copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        copy.imageExtent = {size_.x, size_.y, 1};
        vk.CmdCopyImageToBuffer(commands, image_.get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                                bytes_.get(), 1, &copy);
        barrier(commands);
    });
    std::vector<uint8_t> bytes(size_t(size_.x) * size_.y * 4);
    bytes_.read(std::as_writable_bytes(std::span(bytes)));
    return bytes;
}

void swapRedAndBlue(std::vector<uint8_t>& bytes)
{
    for (size_t i = 0; i + 3 < bytes.size(); i += 4) std::swap(bytes[i], bytes[i + 2]);
}

}  // namespace gpu
