// Buffers: device-local, mapped where the device allows it (software devices, resizable BAR),
// staged otherwise, and where the host reads much of what it has no cache for.
#pragma once

#include <cstring>
#include <functional>
#include <span>
#include <vector>

#include "app/gpu/base/device.h"

namespace gpu {

/// What a buffer grows with, so that one that does not fit says what to do about it.
enum class BufferOf { image, scene };

/// A buffer with its memory and, when `format` is given, a uniform texel view of all of it.
class Buffer {
public:
    Buffer() = default;

    /// `bytes` is rounded up to 16 and at least 16. Throws core::Error with the numbers when `name`
    /// exceeds a limit of the device or its memory.
    Buffer(Device& device, const char* name, uint64_t bytes, VkFormat format = VK_FORMAT_UNDEFINED,
           BufferOf of = BufferOf::image);
    Buffer(Buffer&& other) noexcept { *this = std::move(other); }
    Buffer& operator=(Buffer&& other) noexcept;
    ~Buffer();

    VkBuffer get() const { return buffer_.get(); }
    VkBufferView view() const { return view_.get(); }
    uint64_t bytes() const { return bytes_; }

    /// Writes a part of what goes to the device, which begins at `offset` of all.
    using Make = std::function<void(std::span<std::byte> part, uint64_t offset)>;

    /// Copies to the device; waits.
    void write(std::span<const std::byte> data, uint64_t offset = 0);
    /// The same for the first `bytes`, which `make` writes in place, in order, and never reads.
    /// Parts begin at multiples of 16.
    void fill(uint64_t bytes, const Make& make);
    /// Copies from the device; waits.
    void read(std::span<std::byte> data, uint64_t offset = 0) const;

    template <class T> void writeAll(const std::vector<T>& data)
    {
        if (!data.empty()) write(std::as_bytes(std::span(data)));
    }

private:
    void writeParts(uint64_t bytes, uint64_t offset, const Make& make);

    Device* device_ = nullptr;
    uint64_t bytes_ = 0, allocated_ = 0;
    Handle<VkBuffer, &Api::DestroyBuffer> buffer_;
    Handle<VkDeviceMemory, &Api::FreeMemory> memory_;
    Handle<VkBufferView, &Api::DestroyBufferView> view_;
    std::byte* mapped_ = nullptr;
    bool cached_ = false;  // by the host, which reads `mapped_` slowly otherwise
};

/// Mapped host memory, cached where there is such, that copies go through: see Device::staging.
class Staging {
public:
    Staging(Device& device, uint64_t bytes);

    VkBuffer get() const { return buffer_.get(); }
    std::byte* mapped() const { return mapped_; }
    uint64_t bytes() const { return bytes_; }

private:
    uint64_t bytes_;
    Handle<VkBuffer, &Api::DestroyBuffer> buffer_;
    Handle<VkDeviceMemory, &Api::FreeMemory> memory_;
    std::byte* mapped_ = nullptr;
};

}  // namespace gpu
