// Counting warnings.
#include "core/scene/scene.h"

#include <algorithm>

namespace core {

void Warnings::add(std::string code, std::string pointer, std::string message)
{
    constexpr uint64_t kKept = 10;
    auto entry = std::find_if(counts.begin(), counts.end(),
                              [&](const Count& count) { return count.code == code; });
    if (entry == counts.end()) entry = counts.insert(counts.end(), {code, 0});
    if (++entry->count <= kKept)
        listed.push_back({std::move(code), std::move(pointer), std::move(message)});
}

uint64_t Warnings::total() const
{
    uint64_t sum = 0;
    for (const Count& count : counts) sum += count.count;
    return sum;
}

}  // namespace core
