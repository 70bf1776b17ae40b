// Memory types are chosen in order: device-local and mapped, device-local, any that fits.
#include "app/gpu/memory.h"

#include <algorithm>
#include <optional>

namespace gpu {

namespace {

std::optional<uint32_t> memoryType(VkPhysicalDevice physical, uint32_t allowed, VkMemoryPropertyFlags flags)
{
    VkPhysicalDeviceMemoryProperties properties;
    vk.GetPhysicalDeviceMemoryProperties(physical, &properties);
    for (uint32_t i = 0; i < properties.memoryTypeCount; ++i) {
        if ((allowed >> i & 1) != 0 && (properties.memoryTypes[i].propertyFlags & flags) == flags) return i;
    }
    return std::nullopt;
}

constexpr VkMemoryPropertyFlags kMapped =
    VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;

std::string mebibytes(uint64_t bytes)
{
    return std::to_string((bytes + (1 << 20) - 1) >> 20) + " MiB";
}

uint32_t texelBytes(VkFormat format)
{
    switch (format) {
    case VK_FORMAT_R32_SFLOAT: return 4;
    case VK_FORMAT_R16G16B16A16_SFLOAT: return 8;
    default: return 16;
    }
}

/// One-off staging buffer of host memory.
struct Staging {
    Handle<VkBuffer, &Api::DestroyBuffer> buffer;
    Handle<VkDeviceMemory, &Api::FreeMemory> memory;
    void* mapped = nullptr;

    Staging(const Device& device, uint64_t bytes)
    {
        VkBufferCreateInfo create{};
        create.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
        create.size = bytes;
        create.usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
        VkBuffer object;
        VK_CHECK(vk.CreateBuffer(device.get(), &create, nullptr, &object));
        buffer = {device.get(), object};
        VkMemoryRequirements needs;
        vk.GetBufferMemoryRequirements(device.get(), object, &needs);
        VkMemoryAllocateInfo allocate{};
        allocate.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
        allocate.allocationSize = needs.size;
        allocate.memoryTypeIndex = memoryType(device.physical(), needs.memoryTypeBits, kMapped).value();
        VkDeviceMemory block;
        VK_CHECK(vk.AllocateMemory(device.get(), &allocate, nullptr, &block));
        memory = {device.get(), block};
        VK_CHECK(vk.BindBufferMemory(device.get(), object, block, 0));
        VK_CHECK(vk.MapMemory(device.get(), block, 0, VK_WHOLE_SIZE, 0, &mapped));
    }
};

constexpr uint64_t kStagingBytes = uint64_t(64) << 20;

}  // namespace

Buffer::Buffer(Device& device, const char* name, uint64_t bytes, VkFormat format)
    : device_(&device), bytes_(std::max<uint64_t>((bytes + 15) & ~uint64_t(15), 16))
{
    const bool texels = format != VK_FORMAT_UNDEFINED;
    if (texels && bytes_ / texelBytes(format) > device.limits().maxTexelBufferElements) {
        throw core::Error("the scene does not fit the device: " + std::string(name) + " needs " +
                              std::to_string(bytes_ / texelBytes(format)) + " texels, a texel buffer of " +
                              device.info().name + " holds " +
                              std::to_string(device.limits().maxTexelBufferElements) + " — use --device cpu",
                          core::ExitCode::deviceLost);
    }
    if (!texels && bytes_ > device.limits().maxStorageBufferRange) {
        throw core::Error("the image does not fit the device: " + std::string(name) + " needs " + mebibytes(bytes_) +
                              ", a storage buffer of " + device.info().name + " holds " +
                              mebibytes(device.limits().maxStorageBufferRange) + " — render a smaller image",
                          core::ExitCode::deviceLost);
    }
    VkBufferCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
    create.size = bytes_;
    create.usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                   VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT |
                   VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT;
    if (texels) create.usage |= VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT;
    VkBuffer object;
    VK_CHECK(vk.CreateBuffer(device.get(), &create, nullptr, &object));
    buffer_ = {device.get(), object};

    VkMemoryRequirements needs;
    vk.GetBufferMemoryRequirements(device.get(), object, &needs);
    auto type = memoryType(device.physical(), needs.memoryTypeBits, kMapped | VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    const bool mappable = type.has_value();
    if (!type) type = memoryType(device.physical(), needs.memoryTypeBits, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    if (!type) type = memoryType(device.physical(), needs.memoryTypeBits, 0);
    VkMemoryAllocateInfo allocate{};
    allocate.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
    allocate.allocationSize = needs.size;
    allocate.memoryTypeIndex = type.value();
    VkDeviceMemory block = VK_NULL_HANDLE;
    const VkResult result = device.allocatedBytes + needs.size > device.info().heapBytes
                                ? VK_ERROR_OUT_OF_DEVICE_MEMORY
                                : vk.AllocateMemory(device.get(), &allocate, nullptr, &block);
    if (result != VK_SUCCESS) {
        throw core::Error("out of device memory: " + std::string(name) + " needs " + mebibytes(needs.size) +
                              " beyond the " + mebibytes(device.allocatedBytes) + " in use; " + device.info().name +
                              " has " + mebibytes(device.info().heapBytes) + " — use --device cpu",
                          core::ExitCode::deviceLost);
    }
    memory_ = {device.get(), block};
    allocated_ = needs.size;
    device.allocatedBytes += allocated_;
    device.peakBytes = std::max(device.peakBytes, device.allocatedBytes);
    VK_CHECK(vk.BindBufferMemory(device.get(), object, block, 0));
    if (mappable) {
        void* p = nullptr;
        VK_CHECK(vk.MapMemory(device.get(), block, 0, VK_WHOLE_SIZE, 0, &p));
        mapped_ = static_cast<std::byte*>(p);
    }
    if (texels) {
        VkBufferViewCreateInfo view{};
        view.sType = VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO;
        view.buffer = object;
        view.format = format;
        view.range = bytes_;
        VkBufferView viewObject;
        VK_CHECK(vk.CreateBufferView(device.get(), &view, nullptr, &viewObject));
        view_ = {device.get(), viewObject};
    }
}

Buffer& Buffer::operator=(Buffer&& other) noexcept
{
    std::swap(device_, other.device_);
    std::swap(bytes_, other.bytes_);
    std::swap(allocated_, other.allocated_);
    std::swap(buffer_, other.buffer_);
    std::swap(memory_, other.memory_);
    std::swap(view_, other.view_);
    std::swap(mapped_, other.mapped_);
    return *this;
}

Buffer::~Buffer()
{
    if (device_ != nullptr) device_->allocatedBytes -= allocated_;
}

void Buffer::write(std::span<const std::byte> data, uint64_t offset)
{
    CHECK(offset + data.size() <= bytes_);
    if (mapped_ != nullptr) {
        std::memcpy(mapped_ + offset, data.data(), data.size());
        return;
    }
    const Staging staging(*device_, std::min<uint64_t>(data.size(), kStagingBytes));
    for (uint64_t done = 0; done < data.size(); done += kStagingBytes) {
        const uint64_t part = std::min<uint64_t>(data.size() - done, kStagingBytes);
        std::memcpy(staging.mapped, data.data() + done, part);
        device_->submit([&](VkCommandBuffer commands) {
            const VkBufferCopy copy{0, offset + done, part};
            vk.CmdCopyBuffer(commands, staging.buffer.get(), buffer_.get(), 1, &copy);
            barrier(commands);
        });
    }
}

void Buffer::read(std::span<std::byte> data, uint64_t offset) const
{
    CHECK(offset + data.size() <= bytes_);
    if (mapped_ != nullptr) {
        std::memcpy(data.data(), mapped_ + offset, data.size());
        return;
    }
    const Staging staging(*device_, std::min<uint64_t>(data.size(), kStagingBytes));
    for (uint64_t done = 0; done < data.size(); done += kStagingBytes) {
        const uint64_t part = std::min<uint64_t>(data.size() - done, kStagingBytes);
        device_->submit([&](VkCommandBuffer commands) {
            const VkBufferCopy copy{offset + done, 0, part};
            vk.CmdCopyBuffer(commands, buffer_.get(), staging.buffer.get(), 1, &copy);
            barrier(commands);
        });
        std::memcpy(data.data() + done, staging.mapped, part);
    }
}

}  // namespace gpu
