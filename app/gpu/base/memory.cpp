// Memory types are chosen in order: device-local and mapped, device-local, any that is mapped,
// which Vulkan has for every buffer.
#include "app/gpu/base/memory.h"

#include <algorithm>
#include <vector>

#include "shared/bindings.h"

namespace gpu {

namespace {

constexpr VkMemoryPropertyFlags kMapped =
    VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;

// Types with other properties want features that nobody has asked for.
constexpr VkMemoryPropertyFlags kUsual =
    kMapped | VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT | VK_MEMORY_PROPERTY_HOST_CACHED_BIT;

/// A type of memory, and what it is wanted for.
struct TypeChoice {
    uint32_t type = 0;
    VkMemoryPropertyFlags wish = 0, has = 0;
};

/// The allowed types that have one of `wishes`, in the order of these; each once.
std::vector<TypeChoice> typesFor(VkPhysicalDevice physical, uint32_t allowed,
                                 std::initializer_list<VkMemoryPropertyFlags> wishes)
{
    VkPhysicalDeviceMemoryProperties properties;
    vk.GetPhysicalDeviceMemoryProperties(physical, &properties);
    std::vector<TypeChoice> choices;
    for (const VkMemoryPropertyFlags wish : wishes) {
        for (uint32_t i = 0; i < properties.memoryTypeCount; ++i) {
            const VkMemoryPropertyFlags has = properties.memoryTypes[i].propertyFlags;
            if ((allowed >> i & 1) == 0 || (has & wish) != wish || (has & ~kUsual) != 0) continue;
            choices.push_back({i, wish, has});
            allowed &= ~(1u << i);
        }
    }
    return choices;
}

std::string mebibytes(uint64_t bytes)
{
    return std::to_string((bytes + (1 << 20) - 1) >> 20) + " MiB";
}

uint32_t texelBytes(VkFormat format)
{
    switch (format) {
    case VK_FORMAT_R32_SFLOAT:
    case VK_FORMAT_R32_UINT:
        return 4;
    case VK_FORMAT_R16G16B16A16_SFLOAT:
        return 8;
    default:
        return 16;
    }
}

[[noreturn]] void doesNotFit(const Device& device, const char* name, const std::string& needs,
                             const char* where, const std::string& limit, BufferOf of)
{
    const bool scene = of == BufferOf::scene;
    throw core::Error(std::string("the ") + (scene ? "scene" : "image") +
                          " does not fit the device: " + name + " needs " + needs + ", " + where +
                          " of " + device.info().name + " holds " + limit +
                          (scene ? " — use --device cpu" : " — render a smaller image"),
                      core::ExitCode::deviceLost);
}

/// Refuses what exceeds a limit before anything is made.
void requireFit(const Device& device, const char* name, uint64_t bytes, VkFormat format,
                BufferOf of)
{
    const bool texels = format != VK_FORMAT_UNDEFINED;
    const uint64_t most = device.limits().maxTexelBufferElements;
    if (texels && bytes / texelBytes(format) > most) {
        doesNotFit(device, name, std::to_string(bytes / texelBytes(format)) + " texels",
                   "a texel buffer", std::to_string(most), of);
    }
    if (!texels && bytes > device.limits().maxStorageBufferRange) {
        doesNotFit(device, name, mebibytes(bytes), "a storage buffer",
                   mebibytes(device.limits().maxStorageBufferRange), of);
    }
    if (bytes > device.info().maxAllocation) {
        doesNotFit(device, name, mebibytes(bytes), "a piece of memory",
                   mebibytes(device.info().maxAllocation), of);
    }
}

/// As Device::check; exhausted memory is told with the numbers.
void checkMemory(Device& device, VkResult result, const char* call, const char* name,
                 uint64_t bytes)
{
    if (result != VK_ERROR_OUT_OF_DEVICE_MEMORY && result != VK_ERROR_OUT_OF_HOST_MEMORY &&
        result != VK_ERROR_MEMORY_MAP_FAILED && result != VK_ERROR_TOO_MANY_OBJECTS) {
        device.check(result, call);
        return;
    }
    const char* which = result == VK_ERROR_OUT_OF_DEVICE_MEMORY ? "device" : "host";
    throw core::Error(
        std::string("out of ") + which + " memory: " + name + " needs " + mebibytes(bytes) +
            " beyond the " + mebibytes(device.allocatedBytes) + " in use; " + device.info().name +
            " has " + mebibytes(device.info().heapBytes) + " (" + call + " gave " +
            resultName(result) + ") — render a smaller image or scene, or use --device cpu",
        core::ExitCode::deviceLost);
}

using BufferHandle = Handle<VkBuffer, &Api::DestroyBuffer>;
using MemoryHandle = Handle<VkDeviceMemory, &Api::FreeMemory>;

BufferHandle makeBuffer(Device& device, const char* name, uint64_t bytes, VkBufferUsageFlags usage)
{
    VkBufferCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
    create.size = bytes;
    create.usage = usage;
    VkBuffer object = VK_NULL_HANDLE;
    checkMemory(device, vk.CreateBuffer(device.get(), &create, nullptr, &object), "vkCreateBuffer",
                name, bytes);
    return {device.get(), object};
}

/// What a buffer got: `mapped` is null where it cannot be, or need not be; `cached` tells whether
/// the host reads it as fast as its own.
struct Given {
    MemoryHandle memory;
    uint64_t allocated = 0;
    std::byte* mapped = nullptr;
    bool cached = false;
};

/// Memory of the first type that has one of `wishes` (in their order) and is not exhausted, bound
/// to the buffer, and mapped when the wish says so: the memory that is both the device's and mapped
/// may be a small window only.
Given giveMemory(Device& device, const char* name, VkBuffer buffer,
                 std::initializer_list<VkMemoryPropertyFlags> wishes)
{
    VkMemoryRequirements needs;
    vk.GetBufferMemoryRequirements(device.get(), buffer, &needs);
    VkResult result = VK_ERROR_OUT_OF_DEVICE_MEMORY;
    VkDeviceMemory block = VK_NULL_HANDLE;
    TypeChoice got;
    for (const TypeChoice& choice : typesFor(device.physical(), needs.memoryTypeBits, wishes)) {
        const bool local = (choice.wish & VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT) != 0;
        if (local && device.allocatedBytes + needs.size > device.info().heapBytes) continue;
        got = choice;
        VkMemoryAllocateInfo allocate{};
        allocate.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
        allocate.allocationSize = needs.size;
        allocate.memoryTypeIndex = choice.type;
        result = vk.AllocateMemory(device.get(), &allocate, nullptr, &block);
        if (result != VK_ERROR_OUT_OF_DEVICE_MEMORY) break;
    }
    checkMemory(device, result, "vkAllocateMemory", name, needs.size);
    Given given;
    given.memory = {device.get(), block};
    checkMemory(device, vk.BindBufferMemory(device.get(), buffer, block, 0), "vkBindBufferMemory",
                name, needs.size);
    if ((got.wish & kMapped) == kMapped) {
        void* p = nullptr;
        checkMemory(device, vk.MapMemory(device.get(), block, 0, VK_WHOLE_SIZE, 0, &p),
                    "vkMapMemory", name, needs.size);
        given.mapped = static_cast<std::byte*>(p);
        given.cached = (got.has & VK_MEMORY_PROPERTY_HOST_CACHED_BIT) != 0;
    }
    given.allocated = needs.size;
    return given;
}

// Larger copies are made in pieces of this.
constexpr uint64_t kStagingBytes = uint64_t(64) << 20;

// So few are read sooner than the device could copy them, even from memory that the host has no
// cache for: counters and the heads of queues.
constexpr uint64_t kFewBytes = 512;
static_assert(sizeof(shared::Counters) <= kFewBytes);

}  // namespace

Staging::Staging(Device& device, uint64_t bytes)
    : bytes_(bytes),
      buffer_(makeBuffer(device, "a copy", bytes,
                         VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT))
{
    Given given = giveMemory(device, "a copy", buffer_.get(),
                             {kMapped | VK_MEMORY_PROPERTY_HOST_CACHED_BIT, kMapped});
    memory_ = std::move(given.memory);
    mapped_ = given.mapped;
}

Buffer::Buffer(Device& device, const char* name, uint64_t bytes, VkFormat format, BufferOf of)
    : device_(&device), bytes_(std::max<uint64_t>((bytes + 15) & ~uint64_t(15), 16))
{
    device.requireAlive();
    requireFit(device, name, bytes_, format, of);
    const bool texels = format != VK_FORMAT_UNDEFINED;
    VkBufferUsageFlags usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                               VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                               VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT |
                               VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT;
    if (texels) usage |= VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT;
    buffer_ = makeBuffer(device, name, bytes_, usage);
    Given given = giveMemory(device, name, buffer_.get(),
                             {kMapped | VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT,
                              VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, kMapped});
    memory_ = std::move(given.memory);
    mapped_ = given.mapped;
    cached_ = given.cached;
    if (texels) {
        VkBufferViewCreateInfo view{};
        view.sType = VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO;
        view.buffer = buffer_.get();
        view.format = format;
        view.range = bytes_;
        VkBufferView viewObject = VK_NULL_HANDLE;
        checkMemory(device, vk.CreateBufferView(device.get(), &view, nullptr, &viewObject),
                    "vkCreateBufferView", name, bytes_);
        view_ = {device.get(), viewObject};
    }
    allocated_ = given.allocated;  // last: a constructor that throws has counted nothing
    device.allocatedBytes += allocated_;
    device.peakBytes = std::max(device.peakBytes, device.allocatedBytes);
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
    std::swap(cached_, other.cached_);
    return *this;
}

Buffer::~Buffer()
{
    if (device_ != nullptr) device_->allocatedBytes -= allocated_;
}

void Buffer::write(std::span<const std::byte> data, uint64_t offset)
{
    writeParts(data.size(), offset, [&](std::span<std::byte> part, uint64_t at) {
        std::memcpy(part.data(), data.data() + at, part.size());
    });
}

void Buffer::fill(uint64_t bytes, const Make& make)
{
    writeParts(bytes, 0, make);
}

/// Parts are told where they lie in the `bytes` that go to `offset`.
void Buffer::writeParts(uint64_t bytes, uint64_t offset, const Make& make)
{
    CHECK(offset + bytes <= bytes_);
    if (bytes == 0) return;
    device_->requireAlive();  // what a lost device leaves in memory is undefined
    device_->writtenBytes += bytes;
    if (mapped_ != nullptr) return make({mapped_ + offset, bytes}, 0);
    const Staging& staging = device_->staging(std::min<uint64_t>(bytes, kStagingBytes));
    for (uint64_t done = 0; done < bytes; done += kStagingBytes) {
        const uint64_t part = std::min<uint64_t>(bytes - done, kStagingBytes);
        make({staging.mapped(), part}, done);
        device_->submit(
            [&](VkCommandBuffer commands) {
                const VkBufferCopy copy{0, offset + done, part};
                vk.CmdCopyBuffer(commands, staging.get(), buffer_.get(), 1, &copy);
                barrier(commands);
            },
            "a copy to the device");
    }
}

void Buffer::read(std::span<std::byte> data, uint64_t offset) const
{
    CHECK(offset + data.size() <= bytes_);
    if (device_ != nullptr)
        device_->requireAlive();  // what a lost device leaves in memory is undefined
    if (data.empty()) return;
    if (mapped_ != nullptr && (cached_ || data.size() <= kFewBytes)) {
        std::memcpy(data.data(), mapped_ + offset, data.size());
        return;
    }
    const Staging& staging = device_->staging(std::min<uint64_t>(data.size(), kStagingBytes));
    for (uint64_t done = 0; done < data.size(); done += kStagingBytes) {
        const uint64_t part = std::min<uint64_t>(data.size() - done, kStagingBytes);
        device_->submit(
            [&](VkCommandBuffer commands) {
                const VkBufferCopy copy{offset + done, 0, part};
                vk.CmdCopyBuffer(commands, buffer_.get(), staging.get(), 1, &copy);
                barrier(commands);
            },
            "a copy from the device");
        std::memcpy(data.data() + done, staging.mapped(), part);
    }
}

}  // namespace gpu
