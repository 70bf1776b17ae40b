// One frame: the display kernel if something changed, a copy of its output to the window's image,
// ImGui's triangles over it. ImGui's Vulkan back end is made anew when the size of letters changes,
// for it cannot replace its font.
#include "app/view/gui.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>

#include <backends/imgui_impl_vulkan.h>
#include <imgui.h>

#include "app/gpu/window/display.h"
#include "app/gpu/window/offscreen.h"
#include "app/gpu/window/swapchain.h"
#include "app/view/gui_style.h"
#include "app/view/imgui/backend.h"

namespace app {

namespace {

using gpu::vk;

struct Use {
    VkPipelineStageFlags stage;
    VkAccessFlags access;
    VkImageLayout layout;
};
constexpr Use kNoUse{VK_PIPELINE_STAGE_TRANSFER_BIT, 0, VK_IMAGE_LAYOUT_UNDEFINED};
constexpr Use kCopiedTo{VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                        VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL};
constexpr Use kCleared = kCopiedTo;
constexpr Use kDrawn{VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
                     VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT,
                     VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
constexpr Use kPresented{VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, 0, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR};
constexpr Use kCopiedFrom{VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT,
                          VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL};

void transition(VkCommandBuffer commands, VkImage image, const Use& from, const Use& to)
{
    VkImageMemoryBarrier barrier{};
    barrier.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
    barrier.srcAccessMask = from.access;
    barrier.dstAccessMask = to.access;
    barrier.oldLayout = from.layout;
    barrier.newLayout = to.layout;
    barrier.srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = image;
    barrier.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    vk.CmdPipelineBarrier(commands, from.stage, to.stage, 0, 0, nullptr, 0, nullptr, 1, &barrier);
}

/// What is beside the picture is the ground of the panel and of the line of status, which draw
/// none: software devices clear an image in a fraction of the time that a rectangle over it takes.
void clear(VkCommandBuffer commands, VkImage image)
{
    const ImVec4& ground = ImGui::GetStyle().Colors[ImGuiCol_WindowBg];
    const VkClearColorValue colour{{ground.x, ground.y, ground.z, 1}};
    const VkImageSubresourceRange range{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    vk.CmdClearColorImage(commands, image, kCleared.layout, &colour, 1, &range);
    transition(commands, image, kCleared, kCopiedTo);
}

template <class T> size_t hashOf(const ImVector<T>& items)
{
    return std::hash<std::string_view>{}(
        {reinterpret_cast<const char*>(items.Data), size_t(items.size_in_bytes())});
}

/// Of all triangles and where they are cut off.
size_t hashOf(const ImDrawData& data)
{
    size_t hash = 0;
    const auto add = [&](size_t more) { hash = (hash ^ more) * 0x9e3779b97f4a7c15u; };
    for (int i = 0; i < data.CmdListsCount; ++i) {
        const ImDrawList& list = *data.CmdLists[i];
        add(hashOf(list.VtxBuffer));
        add(hashOf(list.IdxBuffer));
        for (const ImDrawCmd& command : list.CmdBuffer) {
            const ImVec4& r = command.ClipRect;
            const std::array<float, 5> numbers{r.x, r.y, r.z, r.w, float(command.ElemCount)};
            add(std::hash<std::string_view>{}(
                {reinterpret_cast<const char*>(numbers.data()), sizeof(numbers)}));
        }
    }
    return hash;
}

/// The picture's area inside a frame of that size.
std::pair<glm::uvec2, glm::uvec2> areaIn(glm::uvec2 frame, const DisplayInputs& inputs)
{
    if (inputs.size.x == 0 || inputs.size.y == 0) return {glm::uvec2(0), frame};
    const glm::uvec2 corner = glm::min(inputs.corner, frame - 1u);
    return {corner, glm::min(inputs.size, frame - corner)};
}

}  // namespace

struct Gui::Impl {
    Window& window;
    gpu::Device device;
    gpu::Swapchain swapchain;
    gpu::Display display;
    ImguiContext context;
    std::optional<ImguiVulkan> imgui;
    float wantedScale, scale = 0;  // wanted 0: the display's
    DisplayInputs shown;           // what the kernel ran with last
    bool ran = false;
    bool composed = false;            // ImGui's frame is ended
    bool missed = true;               // the last frame did not come to the window
    size_t drawn = 0, presented = 0;  // what ImGui has drawn, as a hash; what is in the window
    glm::uvec2 presentedSize{0};
    GuiStats stats;

    Impl(Window& w, const GuiOptions& options)
        : window(w),
          device({.index = options.deviceIndex,
                  .validation = options.validation,
                  .instanceExtensions = w.instanceExtensions(),
                  .surface = [&w](VkInstance instance) { return w.makeSurface(instance); },
                  .cacheFolder = options.cacheFolder}),
          swapchain(device, [&w](VkInstance instance) { return w.makeSurface(instance); }),
          display(device), context(w.get()), wantedScale(options.uiScale)
    {
        applyScale();
    }
    ~Impl() { swapchain.settle(); }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    void applyScale();
    void compose();
    bool shows(const DisplayInputs& inputs, glm::uvec2 corner) const;
    void upload(const DisplayInputs& inputs);
    void runKernel(const gpu::WindowFrame& frame, const DisplayInputs& inputs);
    void draw(VkCommandBuffer commands, VkImage image, VkFramebuffer framebuffer, glm::uvec2 size,
              const Use& after);
};

/// Style and fonts for the scale that is wanted now.
void Gui::Impl::applyScale()
{
    const float now = wantedScale > 0 ? std::clamp(wantedScale, 0.5f, 8.0f) : window.contentScale();
    if (std::abs(now - scale) < 0.01f) return;
    scale = now;
    swapchain.wait();
    imgui.reset();
    ImGui::GetStyle() = baseStyle();
    ImGui::GetStyle().ScaleAllSizes(scale);
    addFonts(*ImGui::GetIO().Fonts, scale);
    constexpr uint32_t kFrames = gpu::Swapchain::kSlots + 1;  // those in flight and a screenshot
    imgui.emplace(device, swapchain.renderPass(), kFrames);
    checkImgui();
}

/// Ends ImGui's frame, once.
void Gui::Impl::compose()
{
    if (std::exchange(composed, true)) return;
    ImGui::Render();
    drawn = hashOf(*ImGui::GetDrawData());
}

/// Whether that is what the kernel ran with last.
bool Gui::Impl::shows(const DisplayInputs& inputs, glm::uvec2 corner) const
{
    return ran && inputs.a == shown.a && inputs.b == shown.b && corner == shown.corner &&
           std::memcmp(&inputs.settings, &shown.settings, sizeof(shown.settings)) == 0 &&
           inputs.places == shown.places;
}

/// Images whose pointers changed go to the device.
void Gui::Impl::upload(const DisplayInputs& inputs)
{
    if (ran && inputs.a == shown.a && inputs.b == shown.b) return;
    swapchain.wait();
    ran = false;
    if (inputs.a != shown.a) display.setImage(0, inputs.a.get());
    shown.a = inputs.a;
    if (inputs.b != shown.b) display.setImage(1, inputs.b.get());
    shown.b = inputs.b;
}

void Gui::Impl::runKernel(const gpu::WindowFrame& frame, const DisplayInputs& inputs)
{
    const auto [corner, size] = areaIn(frame.size, inputs);
    if (glm::uvec2(display.width(), display.height()) != size) {
        swapchain.wait();
        display.setSize(size.x, size.y);
        ran = false;
    }
    shown.corner = corner;
    if (shows(inputs, corner)) return;
    display.record(frame.commands, inputs.settings, swapchain.swapped(), inputs.places);
    shown.settings = inputs.settings;
    shown.places = inputs.places;
    ran = true;
}

/// The kernel's output, and over it what ImGui has rendered last.
void Gui::Impl::draw(VkCommandBuffer commands, VkImage image, VkFramebuffer framebuffer,
                     glm::uvec2 size, const Use& after)
{
    const glm::uvec2 area(display.width(), display.height());
    transition(commands, image, kNoUse, kCopiedTo);
    if (area != size) clear(commands, image);
    // After a present that failed the display may be that of a larger window.
    const glm::uvec2 inside = glm::min(area, size - glm::min(shown.corner, size));
    VkBufferImageCopy copy{};
    copy.bufferRowLength = area.x;
    copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    copy.imageOffset = {static_cast<int>(shown.corner.x), static_cast<int>(shown.corner.y), 0};
    copy.imageExtent = {inside.x, inside.y, 1};
    if (inside.x > 0 && inside.y > 0)
        vk.CmdCopyBufferToImage(commands, display.output().get(), image, kCopiedTo.layout, 1,
                                &copy);
    transition(commands, image, kCopiedTo, kDrawn);
    VkRenderPassBeginInfo begin{};
    begin.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO;
    begin.renderPass = swapchain.renderPass();
    begin.framebuffer = framebuffer;
    begin.renderArea.extent = {size.x, size.y};
    vk.CmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
    ImDrawData* data = ImGui::GetDrawData();
    if (data != nullptr && data->Valid) {
        // The window may have changed since ImGui laid things out: pixels stay pixels, what sticks
        // out is cut off.
        data->DisplaySize = {static_cast<float>(size.x) / data->FramebufferScale.x,
                             static_cast<float>(size.y) / data->FramebufferScale.y};
        ImGui_ImplVulkan_RenderDrawData(data, commands);
    }
    vk.CmdEndRenderPass(commands);
    transition(commands, image, kDrawn, after);
    checkImgui();
}

Gui::Gui(Window& window, const GuiOptions& options) : impl_(std::make_unique<Impl>(window, options))
{}
Gui::~Gui() = default;

bool Gui::begin()
{
    const glm::uvec2 size = impl_->window.framebufferSize();
    if (size.x == 0 || size.y == 0) {
        ++impl_->stats.skipped;
        return false;
    }
    impl_->applyScale();
    beginImguiFrame();
    impl_->window.applyInjected();
    const ImVec2 extent = ImGui::GetIO().DisplaySize;
    if (!(extent.x >= 0 && extent.y >= 0)) {  // a display that has gone tells anything
        ++impl_->stats.skipped;
        return false;
    }
    ImGui::NewFrame();
    impl_->composed = false;
    return true;
}

GuiChanges Gui::changes(const DisplayInputs& inputs)
{
    Impl& i = *impl_;
    i.compose();
    const glm::uvec2 frame = i.window.framebufferSize();
    if (i.missed || frame != i.presentedSize) return {true, true};
    const auto [corner, size] = areaIn(frame, inputs);
    const bool same =
        size == glm::uvec2(i.display.width(), i.display.height()) && i.shows(inputs, corner);
    return {!same, i.drawn != i.presented};
}

void Gui::end(const DisplayInputs& inputs)
{
    Impl& i = *impl_;
    i.compose();
    i.upload(inputs);
    const std::optional<gpu::WindowFrame> frame = i.swapchain.begin(i.window.framebufferSize());
    i.missed = true;
    if (!frame) {
        ++i.stats.skipped;
        return;
    }
    i.runKernel(*frame, inputs);
    i.draw(frame->commands, frame->image, frame->framebuffer, frame->size, kPresented);
    if (i.swapchain.end()) {
        ++i.stats.presented;
        i.presentedSize = frame->size;
        i.presented = i.drawn;
        i.missed = false;
    } else {
        ++i.stats.skipped;
    }
}

std::vector<uint8_t> Gui::readFrame(glm::uvec2& size)
{
    Impl& i = *impl_;
    size = i.presentedSize;
    if (size.x == 0) return {};
    i.swapchain.wait();
    gpu::Offscreen copy(i.device, size, i.swapchain.format(), i.swapchain.renderPass());
    std::vector<uint8_t> bytes = copy.read([&](VkCommandBuffer commands) {
        i.draw(commands, copy.image(), copy.framebuffer(), size, kCopiedFrom);
    });
    if (i.swapchain.swapped()) gpu::swapRedAndBlue(bytes);
    for (size_t p = 3; p < bytes.size(); p += 4)
        bytes[p] = 255;  // the window is opaque, whatever blending left
    return bytes;
}

std::vector<uint8_t> Gui::readPicture(glm::uvec2& size)
{
    Impl& i = *impl_;
    size = i.ran ? glm::uvec2(i.display.width(), i.display.height()) : glm::uvec2(0);
    if (size.x == 0) return {};
    i.swapchain.wait();
    std::vector<uint8_t> bytes(size_t(size.x) * size.y * 4);
    i.display.output().read(std::as_writable_bytes(std::span(bytes)));
    if (i.swapchain.swapped()) gpu::swapRedAndBlue(bytes);
    return bytes;
}

void Gui::setUiScale(float scale)
{
    impl_->wantedScale = scale;
}

GuiStats Gui::stats() const
{
    GuiStats stats = impl_->stats;
    stats.swapchains = impl_->swapchain.made();
    stats.deviceBytes = impl_->device.allocatedBytes;
    return stats;
}

std::string Gui::deviceName() const
{
    return impl_->device.info().name;
}

}  // namespace app
