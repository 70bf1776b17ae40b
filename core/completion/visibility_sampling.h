// Visibility of one light from a sequence of receivers, from samples of it: where evenly spaced
// receivers agree, all between them are taken to agree; where they do not, the search goes on
// between them (N. Bus, N. Mustafa, V. Biri, "IlluminationCut", 2015). Guesses, therefore: a shadow
// narrower than the samples' distance is missed.
#pragma once

#include <span>
#include <vector>

#include "core/completion/bits.h"

namespace core::many_lights {

/// Works on many sequences together, so that the rays of each step fill packets.
class VisibilitySampling {
public:
    static constexpr uint32_t kWhole = 8;    // up to so many receivers all are asked
    static constexpr uint32_t kDeepest = 8;  // and from this depth on

    /// Forgets all sequences.
    void clear();

    /// Adds a sequence of `count` receivers; `whole`: all of them are asked. Returns its number.
    uint32_t add(uint32_t count, bool whole);

    /// Finds out. ask(sequence, receiver, word, bit) is to set `bit` of `*word` where the receiver
    /// sees the light, until answer() returns. Returns how often it asked.
    template <class Ask, class Answer> uint64_t run(Ask&& ask, Answer&& answer)
    {
        uint64_t asked = 0;
        while (!segments_.empty()) {
            for (const Segment& s : segments_)
                for (uint32_t i = 0; i < s.samples; ++i, ++asked) {
                    const uint32_t at = sampleOf(s, i);
                    ask(s.sequence, at, &words_[starts_[s.sequence] + at / 64],
                        uint64_t(1) << (at % 64));
                }
            answer();
            next_.clear();
            for (const Segment& s : segments_) resolve(s);
            segments_.swap(next_);
        }
        return asked;
    }

    /// A bit for each receiver of the sequence.
    std::span<const uint64_t> visible(uint32_t sequence) const
    {
        return {&words_[starts_[sequence]], wordsFor(counts_[sequence])};
    }

private:
    /// A part of a sequence; as many samples as receivers ask all of them.
    struct Segment {
        uint32_t sequence, begin, end, depth, samples;
    };

    static uint32_t sampleOf(const Segment& s, uint32_t i)
    {
        const uint32_t last = s.end - s.begin - 1;
        return s.samples > 1 ? s.begin + i * last / (s.samples - 1) : s.begin;
    }
    void push(uint32_t sequence, uint32_t begin, uint32_t end, uint32_t depth, bool whole);
    void resolve(const Segment& s);

    std::vector<uint32_t> starts_, counts_;
    Words words_;
    std::vector<Segment> segments_, next_;
};

}  // namespace core::many_lights
