// See visibility_sampling.h.
#include "core/completion/visibility_sampling.h"

namespace core::many_lights {

void VisibilitySampling::clear()
{
    starts_.clear();
    counts_.clear();
    words_.clear();
    segments_.clear();
}

uint32_t VisibilitySampling::add(uint32_t count, bool whole)
{
    const auto sequence = static_cast<uint32_t>(counts_.size());
    starts_.push_back(static_cast<uint32_t>(words_.size()));
    counts_.push_back(count);
    words_.resize(words_.size() + wordsFor(count));
    next_.clear();
    push(sequence, 0, count, 0, whole);
    segments_.insert(segments_.end(), next_.begin(), next_.end());
    return sequence;
}

void VisibilitySampling::push(uint32_t sequence, uint32_t begin, uint32_t end, uint32_t depth,
                              bool whole)
{
    const uint32_t count = end - begin;
    if (count == 0) return;
    const bool all = whole || count <= kWhole || depth >= kDeepest;
    const uint32_t samples = all ? count : count > 32 ? 16 : count > 16 ? 8 : 4;
    next_.push_back({sequence, begin, end, depth, samples});
}

void VisibilitySampling::resolve(const Segment& s)
{
    if (s.samples == s.end - s.begin) return;
    const std::span<uint64_t> words(&words_[starts_[s.sequence]], wordsFor(counts_[s.sequence]));
    uint32_t lit = 0;
    for (uint32_t i = 0; i < s.samples; ++i) lit += getBit(words, sampleOf(s, i)) ? 1u : 0u;
    if (lit == 0) return;
    if (lit == s.samples) {
        for (uint32_t at = s.begin; at < s.end; ++at) setBit(words, at);
        return;
    }
    for (uint32_t i = 0; i + 1 < s.samples; ++i)
        push(s.sequence, sampleOf(s, i) + 1, sampleOf(s, i + 1), s.depth + 1, false);
}

}  // namespace core::many_lights
