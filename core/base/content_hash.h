// A quick hash that tells contents apart: of scenes, of keys and files of a cache. No protection
// against those who want two contents to be taken for one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

namespace core {

/// 64-bit hash of a sequence of byte strings: eight bytes at a time, multiplied and rotated, then
/// avalanched.
class ContentHash {
public:
    void add(std::span<const std::byte> bytes);

    /// A value without padding.
    template <class T> void addValue(const T& value)
    {
        static_assert(std::is_trivially_copyable_v<T>);
        add(std::as_bytes(std::span(&value, 1)));
    }

    uint64_t value() const;

private:
    uint64_t state_ = 0x9e3779b97f4a7c15u;
};

}  // namespace core
