// See content_hash.h.
#include "core/base/content_hash.h"

#include <bit>
#include <cstring>

namespace core {

void ContentHash::add(std::span<const std::byte> bytes)
{
    constexpr uint64_t kMultiplier = 0x9fb21c651e98df25u;  // odd, half of its bits set
    const auto mix = [&](uint64_t value) {
        state_ = std::rotl((state_ ^ value) * kMultiplier, 29);
    };
    size_t i = 0;
    for (; i + 8 <= bytes.size(); i += 8) {
        uint64_t value = 0;
        std::memcpy(&value, bytes.data() + i, 8);
        mix(value);
    }
    uint64_t rest = 0;
    if (i < bytes.size()) std::memcpy(&rest, bytes.data() + i, bytes.size() - i);
    mix(rest);
    mix(bytes.size());  // tells "ab" + "c" from "a" + "bc"
}

uint64_t ContentHash::value() const
{
    uint64_t x = state_;
    x = (x ^ (x >> 32)) * 0xd6e8feb86659fd93u;
    x = (x ^ (x >> 32)) * 0xd6e8feb86659fd93u;
    return x ^ (x >> 32);
}

}  // namespace core
