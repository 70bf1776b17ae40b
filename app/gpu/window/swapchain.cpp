// Semaphores as the specification demands: the one that an acquisition signals belongs to the frame
// slot, whose fence says that it has been waited for; the one that a presentation waits for belongs
// to the image, whose next acquisition says so. Old swapchains are handed to the new ones and
// destroyed once a later frame has been drawn.
#include "app/gpu/window/swapchain.h"

#include <algorithm>

namespace gpu {

namespace {

constexpr int kLossesInARow = 5;
constexpr uint64_t kAcquireNanoseconds = 100'000'000;

}  // namespace

Outcome outcomeOf(Device& device, VkResult result, const char* call)
{
    switch (result) {
    case VK_SUCCESS:
        return Outcome::ok;
    case VK_TIMEOUT:
    case VK_NOT_READY:
        return Outcome::notReady;
    case VK_SUBOPTIMAL_KHR:
        return Outcome::suboptimal;
    case VK_ERROR_OUT_OF_DATE_KHR:
    case VK_ERROR_FULL_SCREEN_EXCLUSIVE_MODE_LOST_EXT:
        return Outcome::outOfDate;
    case VK_ERROR_SURFACE_LOST_KHR:
        return Outcome::surfaceLost;
    default:
        device.check(result, call);
        return Outcome::ok;
    }
}

Swapchain::Swapchain(Device& device, std::function<VkSurfaceKHR(VkInstance)> makeSurface)
    : device_(device), makeSurface_(std::move(makeSurface)), surface_(device.takeSurface())
{
    CHECK(surface_ != VK_NULL_HANDLE);
    try {
        chooseFormat();
        makeRenderPass();
        VkCommandPoolCreateInfo pool{};
        pool.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
        pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
        pool.queueFamilyIndex = device.queueFamily();
        VkCommandPool poolObject;
        VK_CHECK(vk.CreateCommandPool(device.get(), &pool, nullptr, &poolObject));
        pool_ = {device.get(), poolObject};
        for (Slot& slot : slots_) {
            VkCommandBufferAllocateInfo allocate{};
            allocate.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
            allocate.commandPool = poolObject;
            allocate.commandBufferCount = 1;
            VK_CHECK(vk.AllocateCommandBuffers(device.get(), &allocate, &slot.commands));
            VkFenceCreateInfo fence{};
            fence.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO;
            VkFence fenceObject;
            VK_CHECK(vk.CreateFence(device.get(), &fence, nullptr, &fenceObject));
            slot.fence = {device.get(), fenceObject};
            slot.acquired = semaphore();
        }
    } catch (...) {
        vk.DestroySurfaceKHR(device_.instance(), surface_, nullptr);
        throw;
    }
}

Swapchain::~Swapchain()
{
    settle();
    retired_.clear();
    chain_ = {};
    if (!isAbandoned(device_.get())) vk.DestroySurfaceKHR(device_.instance(), surface_, nullptr);
}

Handle<VkSemaphore, &Api::DestroySemaphore> Swapchain::semaphore() const
{
    VkSemaphoreCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO;
    VkSemaphore object;
    VK_CHECK(vk.CreateSemaphore(device_.get(), &create, nullptr, &object));
    return {device_.get(), object};
}

/// Formats without encoding: what is written is sRGB-encoded already.
void Swapchain::chooseFormat()
{
    uint32_t count = 0;
    VK_CHECK(vk.GetPhysicalDeviceSurfaceFormatsKHR(device_.physical(), surface_, &count, nullptr));
    std::vector<VkSurfaceFormatKHR> formats(count);
    VK_CHECK(vk.GetPhysicalDeviceSurfaceFormatsKHR(device_.physical(), surface_, &count,
                                                   formats.data()));
    const auto found =
        std::find_if(formats.begin(), formats.end(), [](const VkSurfaceFormatKHR& f) {
            return f.colorSpace == VK_COLOR_SPACE_SRGB_NONLINEAR_KHR &&
                   (f.format == VK_FORMAT_B8G8R8A8_UNORM || f.format == VK_FORMAT_R8G8B8A8_UNORM);
        });
    if (found == formats.end()) {
        throw core::Error(
            device_.info().name +
                " offers this window no 8-bit format without encoding — `rekindle render "
                "SCENE -o FILE` needs no window",
            core::ExitCode::noDevice);
    }
    format_ = *found;

    VK_CHECK(
        vk.GetPhysicalDeviceSurfacePresentModesKHR(device_.physical(), surface_, &count, nullptr));
    std::vector<VkPresentModeKHR> modes(count);
    VK_CHECK(vk.GetPhysicalDeviceSurfacePresentModesKHR(device_.physical(), surface_, &count,
                                                        modes.data()));
    // The newest frame at the next refresh: the program limits its rate itself and must not wait
    // for the display.
    const bool mailbox =
        std::find(modes.begin(), modes.end(), VK_PRESENT_MODE_MAILBOX_KHR) != modes.end();
    presentMode_ = mailbox ? VK_PRESENT_MODE_MAILBOX_KHR : VK_PRESENT_MODE_FIFO_KHR;
}

void Swapchain::makeRenderPass()
{
    VkAttachmentDescription attachment{};
    attachment.format = format_.format;
    attachment.samples = VK_SAMPLE_COUNT_1_BIT;
    attachment.loadOp = VK_ATTACHMENT_LOAD_OP_LOAD;
    attachment.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    attachment.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
    attachment.stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
    attachment.initialLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    attachment.finalLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    const VkAttachmentReference reference{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    VkSubpassDescription subpass{};
    subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
    subpass.colorAttachmentCount = 1;
    subpass.pColorAttachments = &reference;
    VkRenderPassCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO;
    create.attachmentCount = 1;
    create.pAttachments = &attachment;
    create.subpassCount = 1;
    create.pSubpasses = &subpass;
    VkRenderPass object;
    VK_CHECK(vk.CreateRenderPass(device_.get(), &create, nullptr, &object));
    renderPass_ = {device_.get(), object};
}

// --- waiting and destroying
// -------------------------------------------------------------------------------------

void Swapchain::waitFor(Slot& slot)
{
    if (slot.frame == 0) return;
    const VkFence fence = slot.fence.get();
    // Whatever happens, nobody waits for it again
    const uint64_t frame = std::exchange(slot.frame, 0);
    device_.wait(fence, "a frame of the window");
    VK_CHECK(vk.ResetFences(device_.get(), 1, &fence));
    completed_ = std::max(completed_, frame);
}

void Swapchain::wait()
{
    for (Slot& slot : slots_) waitFor(slot);
}

void Swapchain::settle() noexcept
{
    try {
        wait();
    } catch (const core::Error&) {
        // What is left of a lost device's work ends soon; of a device that hangs nothing is
        // destroyed.
    }
    // Fences tell of drawing; presenting, which waits for semaphores of ours, ends with the queue.
    if (!isAbandoned(device_.get())) vk.DeviceWaitIdle(device_.get());
}

/// Puts the present swapchain away; what it has shown may still be on its way to the display.
void Swapchain::retire()
{
    if (!chain_.swapchain) return;
    chain_.retired = submitted_;
    retired_.push_back(std::exchange(chain_, {}));
}

void Swapchain::destroyRetired()
{
    std::erase_if(retired_, [&](const Chain& chain) {
        return completed_ > chain.retired || (completed_ == chain.retired && !chain.presented);
    });
}

void Swapchain::renewSurface()
{
    if (++losses_ > kLossesInARow) {
        throw core::Error("the display took the window's surface away " + std::to_string(losses_) +
                              " times in a row",
                          core::ExitCode::failure);
    }
    wait();
    device_.check(vk.DeviceWaitIdle(device_.get()),
                  "vkDeviceWaitIdle");  // presenting, too: see settle()
    retired_.clear();  // a window has one surface at a time, and a surface outlives its swapchains
    chain_ = {};
    stale_ = true;
    vk.DestroySurfaceKHR(device_.instance(), std::exchange(surface_, VK_NULL_HANDLE), nullptr);
    surface_ = makeSurface_(device_.instance());
    VkBool32 presents = VK_FALSE;
    VK_CHECK(vk.GetPhysicalDeviceSurfaceSupportKHR(device_.physical(), device_.queueFamily(),
                                                   surface_, &presents));
    if (presents == VK_FALSE) {
        throw core::Error(device_.info().name + " cannot present to the window any more",
                          core::ExitCode::noDevice);
    }
}

// --- making
// ----------------------------------------------------------------------------------------------------

Swapchain::Image Swapchain::makeImage(VkImage image, glm::uvec2 size)
{
    Image made;
    made.image = image;
    VkImageViewCreateInfo view{};
    view.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO;
    view.image = image;
    view.viewType = VK_IMAGE_VIEW_TYPE_2D;
    view.format = format_.format;
    view.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    VkImageView viewObject;
    VK_CHECK(vk.CreateImageView(device_.get(), &view, nullptr, &viewObject));
    made.view = {device_.get(), viewObject};
    VkFramebufferCreateInfo framebuffer{};
    framebuffer.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO;
    framebuffer.renderPass = renderPass_.get();
    framebuffer.attachmentCount = 1;
    framebuffer.pAttachments = &viewObject;
    framebuffer.width = size.x;
    framebuffer.height = size.y;
    framebuffer.layers = 1;
    VkFramebuffer framebufferObject;
    VK_CHECK(vk.CreateFramebuffer(device_.get(), &framebuffer, nullptr, &framebufferObject));
    made.framebuffer = {device_.get(), framebufferObject};
    made.drawn = semaphore();
    return made;
}

/// Replaces the present swapchain. False when the surface has no area, or another surface is needed
/// first.
bool Swapchain::makeChain(glm::uvec2 size)
{
    VkSurfaceCapabilitiesKHR can{};
    Outcome outcome = outcomeOf(
        device_, vk.GetPhysicalDeviceSurfaceCapabilitiesKHR(device_.physical(), surface_, &can),
        "vkGetPhysicalDeviceSurfaceCapabilitiesKHR");
    if (outcome == Outcome::surfaceLost) {
        renewSurface();
        return false;
    }
    glm::uvec2 extent{can.currentExtent.width, can.currentExtent.height};
    if (extent == glm::uvec2(0xffffffffu)) {
        extent = glm::clamp(size, glm::uvec2(can.minImageExtent.width, can.minImageExtent.height),
                            glm::uvec2(can.maxImageExtent.width, can.maxImageExtent.height));
    }
    retire();
    if (extent.x == 0 || extent.y == 0) return false;
    if (retired_.size() >
        kSlots) {  // refused again and again, or resized faster than frames are drawn
        wait();
        destroyRetired();
    }
    const VkImageUsageFlags usage =
        VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    if ((can.supportedUsageFlags & usage) != usage) {
        throw core::Error(device_.info().name + " cannot copy pictures to this window",
                          core::ExitCode::noDevice);
    }

    VkSwapchainCreateInfoKHR create{};
    create.sType = VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR;
    create.surface = surface_;
    create.minImageCount = std::max(can.minImageCount, kSlots + 1);
    if (can.maxImageCount > 0)
        create.minImageCount = std::min(create.minImageCount, can.maxImageCount);
    create.imageFormat = format_.format;
    create.imageColorSpace = format_.colorSpace;
    create.imageExtent = {extent.x, extent.y};
    create.imageArrayLayers = 1;
    create.imageUsage = usage;
    create.imageSharingMode = VK_SHARING_MODE_EXCLUSIVE;
    create.preTransform = can.currentTransform;
    // Opaque where there is a choice; else the lowest bit there is.
    create.compositeAlpha =
        (can.supportedCompositeAlpha & VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR) != 0
            ? VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR
            : static_cast<VkCompositeAlphaFlagBitsKHR>(can.supportedCompositeAlpha &
                                                       (~can.supportedCompositeAlpha + 1));
    create.presentMode = presentMode_;
    create.clipped = VK_TRUE;
    if (!retired_.empty() && !retired_.back().replaced) {
        create.oldSwapchain = retired_.back().swapchain.get();
        retired_.back().replaced = true;
    }
    VkSwapchainKHR object = VK_NULL_HANDLE;
    outcome = outcomeOf(device_, vk.CreateSwapchainKHR(device_.get(), &create, nullptr, &object),
                        "vkCreateSwapchainKHR");
    if (outcome == Outcome::surfaceLost) renewSurface();
    if (outcome != Outcome::ok) return false;
    chain_.swapchain = {device_.get(), object};
    ++made_;

    uint32_t count = 0;
    VK_CHECK(vk.GetSwapchainImagesKHR(device_.get(), object, &count, nullptr));
    std::vector<VkImage> images(count);
    VK_CHECK(vk.GetSwapchainImagesKHR(device_.get(), object, &count, images.data()));
    for (const VkImage image : images) chain_.images.push_back(makeImage(image, extent));
    chain_.size = extent;
    wanted_ = size;
    stale_ = false;
    return true;
}

// --- frames
// ----------------------------------------------------------------------------------------------------

/// One try: none when there is no swapchain to try it on.
std::optional<Outcome> Swapchain::acquire(glm::uvec2 size)
{
    if ((stale_ || !chain_.swapchain || wanted_ != size) && !makeChain(size)) return std::nullopt;
    const Outcome outcome =
        outcomeOf(device_,
                  vk.AcquireNextImageKHR(device_.get(), chain_.swapchain.get(), kAcquireNanoseconds,
                                         slots_[next_].acquired.get(), VK_NULL_HANDLE, &image_),
                  "vkAcquireNextImageKHR");
    if (outcome == Outcome::suboptimal || outcome == Outcome::outOfDate) stale_ = true;
    if (outcome == Outcome::surfaceLost) renewSurface();
    return outcome;
}

std::optional<WindowFrame> Swapchain::begin(glm::uvec2 size)
{
    Slot& slot = slots_[next_];
    waitFor(slot);
    destroyRetired();
    if (open_) {  // a frame that was begun and not ended: its image cannot be given back, its
                  // semaphore stays signalled
        chain_.abandoned.push_back(std::exchange(slot.acquired, semaphore()));
        stale_ = true;
        open_ = false;
    }
    if (size.x == 0 || size.y == 0) {
        retire();
        return std::nullopt;
    }
    std::optional<Outcome> outcome;
    for (int attempt = 0; attempt < 2; ++attempt) {
        outcome = acquire(size);
        if (outcome == Outcome::ok || outcome == Outcome::suboptimal ||
            outcome == Outcome::notReady)
            break;
    }
    if (outcome != Outcome::ok && outcome != Outcome::suboptimal) return std::nullopt;
    open_ = true;
    VkCommandBufferBeginInfo begin{};
    begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    VK_CHECK(vk.BeginCommandBuffer(slot.commands, &begin));
    const Image& image = chain_.images[image_];
    return WindowFrame{slot.commands, image.image, image.framebuffer.get(), chain_.size};
}

bool Swapchain::end()
{
    CHECK(open_);
    Slot& slot = slots_[next_];
    const VkSemaphore acquired = slot.acquired.get(), drawn = chain_.images[image_].drawn.get();
    VK_CHECK(vk.EndCommandBuffer(slot.commands));
    // The first that touches the image
    const VkPipelineStageFlags stage = VK_PIPELINE_STAGE_TRANSFER_BIT;
    VkSubmitInfo submit{};
    submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
    submit.waitSemaphoreCount = 1;
    submit.pWaitSemaphores = &acquired;
    submit.pWaitDstStageMask = &stage;
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &slot.commands;
    submit.signalSemaphoreCount = 1;
    submit.pSignalSemaphores = &drawn;
    device_.check(vk.QueueSubmit(device_.queue(), 1, &submit, slot.fence.get()), "vkQueueSubmit");
    slot.frame = ++submitted_;
    open_ = false;
    next_ = (next_ + 1) % kSlots;

    const VkSwapchainKHR swapchain = chain_.swapchain.get();
    VkPresentInfoKHR present{};
    present.sType = VK_STRUCTURE_TYPE_PRESENT_INFO_KHR;
    present.waitSemaphoreCount = 1;
    present.pWaitSemaphores = &drawn;
    present.swapchainCount = 1;
    present.pSwapchains = &swapchain;
    present.pImageIndices = &image_;
    const Outcome outcome =
        outcomeOf(device_, vk.QueuePresentKHR(device_.queue(), &present), "vkQueuePresentKHR");
    chain_.presented = true;
    if (outcome == Outcome::ok || outcome == Outcome::suboptimal) losses_ = 0;
    if (outcome != Outcome::ok) stale_ = true;
    if (outcome == Outcome::surfaceLost) renewSurface();
    return outcome == Outcome::ok || outcome == Outcome::suboptimal;
}

}  // namespace gpu
