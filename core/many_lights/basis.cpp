// The basis of an octant and its comparison with a column, eight columns at a time.
#include "core/many_lights/basis.h"

#include <algorithm>
#include <array>

namespace core::many_lights {

uint32_t Basis::push(std::span<const uint64_t> bits, std::span<const uint64_t> known)
{
    for (size_t w = 0; w < words_; ++w) bits_.push_back(bits[w] & known[w]);
    known_.insert(known_.end(), known.begin(), known.end());
    const uint32_t k = size_++;
    if (k % kLanes == 0) keys_.resize(keys_.size() + size_t(2) * kLanes * keyWords());
    packLane(k);
    return k;
}

std::optional<Candidate> Basis::findEqual(std::span<const uint64_t> bits,
                                          std::span<const uint64_t> known) const
{
    const uint32_t half = countBits(known) / 2;
    for (uint32_t k = 0; k < size_; ++k) {
        uint64_t differ = 0, same = 0;
        uint32_t common = 0;
        for (size_t w = 0; w < words_ && (differ == 0 || same == 0); ++w) {
            const uint64_t both = known[w] & known_[k * words_ + w];
            const uint64_t unequal = bits[w] ^ bits_[k * words_ + w];
            differ |= unequal & both;
            same |= ~unequal & both;
            common += static_cast<uint32_t>(std::popcount(both));
        }
        if ((differ == 0 || same == 0) && common > half) return Candidate{k, differ != 0};
    }
    return std::nullopt;
}

void Basis::fill(Candidate candidate, std::span<const uint64_t> bits,
                 std::span<const uint64_t> rows)
{
    const size_t at = size_t(candidate.index) * words_;
    for (size_t w = 0; w < words_; ++w) {
        const uint64_t fresh = rows[w] & ~known_[at + w];
        bits_[at + w] |= (candidate.complement ? ~bits[w] : bits[w]) & fresh;
        known_[at + w] |= fresh;
    }
}

void Basis::select(std::span<const uint64_t> samples, std::span<const uint64_t> checks)
{
    samples_.assign(samples.begin(), samples.end());
    checks_.assign(checks.begin(), checks.end());
    sampleWords_ = wordsFor(countBits(samples_));
    checkWords_ = wordsFor(countBits(checks_));
    const uint32_t groups = (size_ + kLanes - 1) / kLanes;
    keys_.assign(size_t(2) * kLanes * keyWords() * groups, 0);
    for (uint32_t k = 0; k < size_; ++k) packLane(k);
}

void Basis::packLane(uint32_t k)
{
    if (keyWords() == 0) return;
    Words packed(2 * size_t(keyWords()));
    const auto pack = [&](std::span<const uint64_t> words, uint64_t* to) {
        packBits(words, samples_, to);
        packBits(words, checks_, to + sampleWords_);
    };
    pack(bits(k), packed.data());
    pack(known(k), packed.data() + keyWords());
    uint64_t* group = &keys_[size_t(2) * kLanes * keyWords() * (k / kLanes)];
    for (uint32_t w = 0; w < keyWords(); ++w) {
        group[2 * kLanes * w + k % kLanes] = packed[w];
        group[2 * kLanes * w + kLanes + k % kLanes] = packed[keyWords() + w];
    }
}

void Basis::makeKey(std::span<const uint64_t> bits, std::span<const uint64_t> known,
                    ColumnKey& key) const
{
    key.bits.assign(keyWords(), 0);
    key.known.assign(keyWords(), 0);
    packBits(bits, samples_, key.bits.data());
    packBits(bits, checks_, key.bits.data() + sampleWords_);
    packBits(known, samples_, key.known.data());
    packBits(known, checks_, key.known.data() + sampleWords_);
}

bool Basis::match(const ColumnKey& key, uint32_t fewest, std::vector<Candidate>& found) const
{
    using Lanes = std::array<uint64_t, kLanes>;
    found.clear();
    bool onSamples = false;
    for (uint32_t first = 0; first < size_; first += kLanes) {
        const uint64_t* group = keys(first / kLanes);
        Lanes differ{}, same{}, common{};
        uint64_t hopeless = 0;
        const auto compare = [&](uint32_t begin, uint32_t end) {
            for (uint32_t w = begin; w < end && hopeless == 0; ++w) {
                const uint64_t* bits = group + size_t(2) * kLanes * w;
                const uint64_t x = key.bits[w], known = key.known[w];
                hopeless = ~uint64_t(0);
                for (uint32_t l = 0; l < kLanes; ++l) {
                    const uint64_t both = bits[kLanes + l] & known;
                    const uint64_t unequal = bits[l] ^ x;
                    differ[l] |= unequal & both;
                    same[l] |= ~unequal & both;
                    common[l] += static_cast<uint64_t>(std::popcount(both));
                    hopeless &= (differ[l] != 0 && same[l] != 0) ? ~uint64_t(0) : 0;
                }
            }
        };
        const uint32_t lanes = std::min(kLanes, size_ - first);
        for (uint32_t l = lanes; l < kLanes; ++l) differ[l] = same[l] = 1;
        compare(0, sampleWords_);
        if (hopeless != 0) continue;
        for (uint32_t l = 0; l < lanes; ++l)
            onSamples |= common[l] > 0 && (differ[l] == 0 || same[l] == 0);
        compare(sampleWords_, keyWords());
        if (hopeless != 0) continue;
        for (uint32_t l = 0; l < lanes; ++l) {
            if (common[l] < fewest) continue;
            if (differ[l] == 0) found.push_back({first + l, false});
            if (same[l] == 0) found.push_back({first + l, true});
        }
    }
    return onSamples;
}

std::optional<Basis::Nearest> Basis::nearest(const ColumnKey& key, uint32_t fewest) const
{
    std::optional<Nearest> best;
    for (uint32_t k = 0; k < size_; ++k) {
        const uint64_t* lane = keys(k / kLanes) + k % kLanes;
        uint32_t differ = 0, common = 0;
        for (uint32_t w = 0; w < keyWords(); ++w) {
            const uint64_t both = lane[(2 * w + 1) * kLanes] & key.known[w];
            differ +=
                static_cast<uint32_t>(std::popcount((lane[2 * w * kLanes] ^ key.bits[w]) & both));
            common += static_cast<uint32_t>(std::popcount(both));
        }
        if (common < fewest) continue;
        const bool complement = 2 * differ > common;
        const Nearest here{{k, complement}, complement ? common - differ : differ, common};
        if (!best || here.differ < best->differ) best = here;
    }
    return best;
}

}  // namespace core::many_lights
