// See dark_rows.h.
#include "core/many_lights/dark_rows.h"

#include <algorithm>
#include <bit>

#include "core/many_lights/shadow_packets.h"

namespace core::many_lights {

namespace {

constexpr uint32_t kLooks = 16;  // of every row
// What a row gets is no more than so many times what its looks see, and a little for what they
// miss.
constexpr double kMost = 8, kMissed = 0.125;
// A row that sees nothing is dark if so many of its looks should have met something: chance alone
// does that to one in e^4.
constexpr double kExpected = 4;

}  // namespace

void DarkRows::find(SlicePairs& pairs, RoughLight& rough, Pcg32& random)
{
    struct Open {
        uint32_t end;
        size_t size;  // of path_ before it
    };
    const std::span<const PixelNode> nodes = pairs.pixels.nodes();
    seen_.assign(pairs.rows.count(), 0);
    light_.assign(pairs.rows.count(), 0);
    path_.clear();
    ShadowPackets packets(*pairs.job->receivers.accel, pairs.rows);
    std::vector<Open> open;
    for (uint32_t i = 0; i < nodes.size(); ++i) {
        for (; !open.empty() && nodes[i].rows.begin >= open.back().end; open.pop_back())
            path_.resize(open.back().size);
        open.push_back({nodes[i].rows.end, path_.size()});
        for (uint32_t f = rough.firstFound(i); f != ~0u; f = rough.found()[f].next) {
            const double before = path_.empty() ? 0 : path_.back().sum;
            path_.push_back({f, before + rough.found()[f].light});
        }
        if (nodes[i].isLeaf() && !path_.empty())
            look(pairs, rough, nodes[i].rows.begin, packets, random);
    }
    packets.flush();
    lower(pairs, rough);
    darkest_.resize(nodes.size());
    for (size_t i = nodes.size(); i-- > 0;) {
        darkest_[i] = nodes[i].rows.begin;
        if (nodes[i].isLeaf()) continue;
        const uint32_t left = darkest_[i + 1], right = darkest_[nodes[i].right];
        darkest_[i] = seenBy(left) <= seenBy(right) ? left : right;
    }
}

template <class Packets>
void DarkRows::look(SlicePairs& pairs, const RoughLight& rough, uint32_t row, Packets& packets,
                    Pcg32& random)
{
    light_[row] = path_.back().sum;
    for (uint32_t k = 0; k < kLooks; ++k) {
        const double at = (k + random()) * light_[row] / kLooks;
        auto step = std::ranges::upper_bound(path_, at, {}, &Step::sum);
        if (step == path_.end()) --step;
        const Column& column = rough.found()[step->found].column;
        pairs.rows.weigh(column, pairs.job->gather, {row, row + 1}, pairs.weights);
        if (!(pairs.weights[row] > 0)) continue;
        packets.add(ShadowTarget(column), row, &seen_[row], uint64_t(1) << k);
        ++pairs.rays;
    }
}

void DarkRows::lower(const SlicePairs& pairs, RoughLight& rough) const
{
    const std::span<const PixelNode> nodes = pairs.pixels.nodes();
    for (uint32_t i = 0; i < nodes.size(); ++i) {
        if (!nodes[i].isLeaf()) continue;
        const uint32_t row = nodes[i].rows.begin;
        const bool sees = seen_[row] != 0;
        if (!sees && kLooks * rough.of(i) < kExpected * light_[row]) continue;
        const double most = (kMost * std::popcount(seen_[row]) + kMissed) / kLooks * light_[row];
        rough.of(i) = std::min(rough.of(i), most);
    }
}

double DarkRows::seenBy(uint32_t row) const
{
    return std::popcount(seen_[row]) * light_[row];
}

}  // namespace core::many_lights
