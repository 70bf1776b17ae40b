// See slices.h.
#include "core/many_lights/slices.h"

#include <algorithm>
#include <array>
#include <limits>

#include "core/base/check.h"

namespace core::many_lights {

namespace {

constexpr int kDimensions = 6;
using Point = std::array<float, kDimensions>;

class Slicer {
public:
    Slicer(std::span<const Receiver> receivers, const SliceSettings& settings, Slices& out)
        : receivers_(receivers), settings_(settings), out_(out), right_(receivers.size())
    {
        CHECK(settings.threshold > 0);
    }

    /// The set [begin, end) of `order`; the work left is on a stack of its own, since coincident
    /// receivers make deep trees.
    void run(const std::stop_token& stop)
    {
        std::vector<IndexRange> waiting{{0, static_cast<uint32_t>(out_.order.size())}};
        while (!waiting.empty() && !stop.stop_requested()) {
            const IndexRange range = waiting.back();
            waiting.pop_back();
            const uint32_t middle = split(range);
            if (middle == range.end) {
                out_.ranges.push_back(range);
                continue;
            }
            waiting.push_back({middle, range.end});
            waiting.push_back({range.begin, middle});
        }
    }

private:
    float coordinate(uint32_t receiver, int dimension) const
    {
        const Receiver& r = receivers_[receiver];
        return dimension < 3 ? r.position[dimension]
                             : settings_.normalScale * r.normal[dimension - 3];
    }

    /// Splits a set in two: returns where the second begins, its end when it stays whole.
    uint32_t split(IndexRange range)
    {
        if (range.size() < settings_.threshold || range.size() < 2) return range.end;
        const auto [dimension, middle] = widest(range);
        uint32_t left = range.begin, right = 0;
        for (uint32_t i = range.begin; i < range.end; ++i) {
            const uint32_t receiver = out_.order[i];
            if (coordinate(receiver, dimension) <= middle)
                out_.order[left++] = receiver;
            else
                right_[right++] = receiver;
        }
        std::copy_n(right_.begin(), right, out_.order.begin() + left);
        const uint32_t smallest = std::max(settings_.smallest, 1u);
        if (left - range.begin >= smallest && right >= smallest) return left;
        if (range.size() <= 2 * settings_.threshold) return restore(range, left);
        restore(range, left);
        return range.begin + range.size() / 2;
    }

    /// Puts a set that was parted at `left` back into the receivers' order.
    uint32_t restore(IndexRange range, uint32_t left)
    {
        const auto first = out_.order.begin() + range.begin;
        std::inplace_merge(first, out_.order.begin() + left, out_.order.begin() + range.end);
        return range.end;
    }

    /// The dimension of the largest extent and the middle of that.
    std::pair<int, float> widest(IndexRange range) const
    {
        Point low, high;
        low.fill(std::numeric_limits<float>::max());
        high.fill(std::numeric_limits<float>::lowest());
        for (uint32_t i = range.begin; i < range.end; ++i) {
            for (int d = 0; d < kDimensions; ++d) {
                const float x = coordinate(out_.order[i], d);
                low[size_t(d)] = std::min(low[size_t(d)], x);
                high[size_t(d)] = std::max(high[size_t(d)], x);
            }
        }
        size_t best = 0;
        for (size_t d = 1; d < kDimensions; ++d)
            if (high[d] - low[d] > high[best] - low[best]) best = d;
        return {static_cast<int>(best), 0.5f * (low[best] + high[best])};
    }

    std::span<const Receiver> receivers_;
    const SliceSettings& settings_;
    Slices& out_;
    std::vector<uint32_t> right_;
};

}  // namespace

Slices makeSlices(std::span<const Receiver> receivers, const SliceSettings& settings,
                  const std::stop_token& stop)
{
    Slices slices;
    if (receivers.empty()) return slices;
    slices.order.resize(receivers.size());
    for (size_t i = 0; i < receivers.size(); ++i) slices.order[i] = static_cast<uint32_t>(i);
    Slicer(receivers, settings, slices).run(stop);
    return slices;
}

}  // namespace core::many_lights
