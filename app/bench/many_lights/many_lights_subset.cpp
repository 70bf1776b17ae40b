// See many_lights_subset.h.
#include "app/bench/many_lights/many_lights_subset.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "shared/rng.h"

namespace app::many_lights {

namespace {

using core::many_lights::FrameReceivers;

Subset subsetOf(const FrameReceivers& points, uint32_t perPixel, std::span<const uint8_t> slices)
{
    Subset subset;
    subset.perPixel = perPixel;
    subset.places.assign(points.direct.size(), 0);
    for (size_t s = 0; s < slices.size(); ++s) {
        if (slices[s] == 0) continue;
        const core::IndexRange range = points.slices.ranges[s];
        for (uint32_t i = range.begin; i < range.end; ++i)
            subset.places[points.receivers[points.slices.order[i]].place] = 1;
        subset.receivers += range.size();
        ++subset.slices;
    }
    if (subset.slices == slices.size()) std::ranges::fill(subset.places, uint8_t(1));
    for (size_t place = 0; place < subset.places.size(); ++place) {
        const auto pixel = static_cast<uint32_t>(place / perPixel);
        if (subset.places[place] != 0 && (subset.pixels.empty() || subset.pixels.back() != pixel))
            subset.pixels.push_back(pixel);
    }
    return subset;
}

}  // namespace

Subset randomSubset(const FrameReceivers& points, uint32_t perPixel, const SubsetSize& size,
                    uint32_t seed)
{
    const size_t count = points.slices.ranges.size();
    std::vector<uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::sort(order, {}, [seed](uint32_t s) {
        return std::pair(shared::hashUint(s ^ shared::hashUint(seed)), s);
    });
    const size_t most =
        size.share ? std::max<size_t>(1, size_t(std::llround(*size.share * double(count)))) : count;
    std::vector<uint8_t> chosen(count, 0);
    size_t receivers = 0;
    for (size_t i = 0; i < std::min(most, count); ++i) {
        if (!size.share && i > 0 && receivers >= size.receivers) break;
        chosen[order[i]] = 1;
        receivers += points.slices.ranges[order[i]].size();
    }
    return subsetOf(points, perPixel, chosen);
}

Subset subsetAround(const FrameReceivers& points, uint32_t perPixel, uint32_t width,
                    glm::uvec2 corner, glm::uvec2 size)
{
    std::vector<uint8_t> chosen(points.slices.ranges.size(), 0);
    for (size_t s = 0; s < chosen.size(); ++s) {
        const core::IndexRange range = points.slices.ranges[s];
        for (uint32_t i = range.begin; i < range.end && chosen[s] == 0; ++i) {
            const uint32_t pixel = points.receivers[points.slices.order[i]].place / perPixel;
            const glm::uvec2 at(pixel % width, pixel / width);
            if (glm::all(glm::greaterThanEqual(at, corner)) &&
                glm::all(glm::lessThan(at, corner + size)))
                chosen[s] = 1;
        }
    }
    return subsetOf(points, perPixel, chosen);
}

std::vector<uint8_t> slicesOf(const FrameReceivers& points, const Subset& subset)
{
    std::vector<uint8_t> marks(points.slices.ranges.size(), 0);
    for (size_t s = 0; s < marks.size(); ++s) {
        const core::IndexRange range = points.slices.ranges[s];
        for (uint32_t i = range.begin; i < range.end && marks[s] == 0; ++i)
            marks[s] = subset.places[points.receivers[points.slices.order[i]].place];
    }
    return marks;
}

std::vector<glm::vec3> valuesOf(std::span<const glm::vec3> radiance, const Subset& subset)
{
    std::vector<glm::vec3> values;
    values.reserve(subset.pixels.size());
    for (const uint32_t pixel : subset.pixels) {
        glm::vec3 sum(0);
        float count = 0;
        for (size_t p = size_t(pixel) * subset.perPixel; p < size_t(pixel + 1) * subset.perPixel;
             ++p) {
            if (subset.places[p] == 0) continue;
            sum += radiance[p];
            ++count;
        }
        values.push_back(sum / count);
    }
    return values;
}

}  // namespace app::many_lights
