// See accepted_pairs.h.
#include "core/many_lights/accepted_pairs.h"

#include <algorithm>

#include "core/many_lights/shadow_packets.h"

namespace core::many_lights {

namespace {

constexpr size_t kBatch = 4096;  // receivers

}  // namespace

void AcceptedPairs::add(SlicePairs& pairs, const Pair& pair)
{
    const LightNode& l = pairs.tree->nodes[pair.lights];
    Accepted a{pairs.pixels.nodes()[pair.pixels].rows, pairs.representative(l), 0, 0, 0};
    pairs.entries += a.rows.size();
    pairs.rows.weigh(a.column, pairs.job->gather, a.rows, pairs.weights);
    a.begin = static_cast<uint32_t>(lit_.size());
    for (uint32_t row = a.rows.begin; row < a.rows.end; ++row)
        if (pairs.weights[row] > 0) lit_.push_back({row, pairs.weights[row]});
    a.end = static_cast<uint32_t>(lit_.size());
    if (a.begin == a.end) return;
    a.sequence = sampling_.add(a.end - a.begin, l.isLeaf());
    accepted_.push_back(a);
    if (lit_.size() >= kBatch) finish(pairs);
}

void AcceptedPairs::finish(SlicePairs& pairs)
{
    ShadowPackets packets(*pairs.job->receivers.accel, pairs.rows);
    pairs.rays += sampling_.run(
        [&](uint32_t sequence, uint32_t i, uint64_t* word, uint64_t bit) {
            const Accepted& a = accepted_[sequence];
            packets.add(ShadowTarget(a.column), lit_[a.begin + i].row, word, bit);
        },
        [&] { packets.flush(); });
    std::vector<float>& weights = pairs.weights;
    for (const Accepted& a : accepted_) {
        const std::span<const uint64_t> visible = sampling_.visible(a.sequence);
        std::fill(weights.begin() + a.rows.begin, weights.begin() + a.rows.end, 0.0f);
        for (uint32_t i = a.begin; i < a.end; ++i)
            if (getBit(visible, i - a.begin)) weights[lit_[i].row] = lit_[i].weight;
        pairs.rows.add(a.column, *pairs.job->lights, a.rows, weights);
    }
    forget();
}

void AcceptedPairs::forget()
{
    accepted_.clear();
    lit_.clear();
    sampling_.clear();
}

}  // namespace core::many_lights
