// The basis of an octant and its comparison with a column, eight columns at a time.
#include "core/completion/basis.h"

#include <algorithm>
#include <array>

namespace core::many_lights {

uint32_t Basis::push(std::span<const uint64_t> bits, std::span<const uint64_t> known)
{
    for (size_t w = 0; w < words_; ++w) bits_.push_back(bits[w] & known[w]);
    known_.insert(known_.end(), known.begin(), known.end());
    const uint32_t k = size_++;
    if (k % kLanes == 0) keys_.resize(keys_.size() + groupSize());
    if (keyWords_ > 0) packLane(k);
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
    parts_.clear();
    uint32_t count = 0;
    for (uint32_t w = 0; w < words_; ++w) {
        const uint64_t mask = samples[w] | checks[w];
        if (mask == 0) continue;
        const auto bits = static_cast<uint32_t>(std::popcount(mask));
        parts_.push_back({w, count % 64, bits, mask});
        count += bits;
    }
    keyWords_ = wordsFor(count);
    unfinished_ = count % 64 != 0;
    wholeKey_.resize(keyWords_);
    sampleKey_.resize(keyWords_);
    for (uint32_t w = 0; w < keyWords_; ++w) wholeKey_[w] = wordOfRows(count, w);
    pack(samples, sampleKey_.data());
    scratch_.resize(keyWords_);
    keys_.assign(groupSize() * ((size_ + kLanes - 1) / kLanes), 0);
    for (uint32_t k = 0; k < size_; ++k) packLane(k);
}

/// Packs the selected bits into keyWords_ words. The word that is being filled stays in a register.
void Basis::pack(std::span<const uint64_t> words, uint64_t* key) const
{
    uint64_t filling = 0;
    for (const Part& part : parts_) {
        const uint64_t bits = extractBits(words[part.word], part.mask);
        filling |= bits << part.shift;
        const uint32_t end = part.shift + part.count;
        if (end < 64) continue;
        *key++ = filling;
        filling = end > 64 ? bits >> (64 - part.shift) : 0;
    }
    if (unfinished_) *key = filling;
}

void Basis::packLane(uint32_t k)
{
    uint64_t* lane = keys_.data() + groupSize() * (k / kLanes) + k % kLanes;
    const auto write = [&](std::span<const uint64_t> words, uint64_t* to) {
        pack(words, scratch_.data());
        for (uint32_t w = 0; w < keyWords_; ++w) to[size_t(2) * kLanes * w] = scratch_[w];
    };
    write(bits(k), lane);
    write(known(k), lane + kLanes);
}

void Basis::makeKey(std::span<const uint64_t> bits, std::span<const uint64_t> known,
                    ColumnKey& key) const
{
    key.bits.resize(keyWords_);
    pack(bits, key.bits.data());
    uint64_t unknown = 0;
    for (const Part& part : parts_) unknown |= part.mask & ~known[part.word];
    if (unknown == 0) {
        key.known = wholeKey_;
    } else {
        key.known.resize(keyWords_);
        pack(known, key.known.data());
    }
}

void Basis::match(const ColumnKey& key, uint32_t fewest, std::vector<Candidate>& found) const
{
    found.clear();
    for (uint32_t first = 0; first < size_; first += kLanes) {
        const uint64_t* group = keys_.data() + groupSize() * (first / kLanes);
        std::array<uint64_t, kLanes> differ{}, same{};
        uint32_t hopeless = 0;
        for (uint32_t w = 0; w < keyWords_ && hopeless < kLanes; ++w, group += 2 * kLanes) {
            const uint64_t bits = key.bits[w], known = key.known[w];
            hopeless = 0;
            for (uint32_t l = 0; l < kLanes; ++l) {
                const uint64_t both = group[kLanes + l] & known, unequal = group[l] ^ bits;
                differ[l] |= unequal & both;
                same[l] |= ~unequal & both;
                hopeless +=
                    static_cast<uint32_t>(differ[l] != 0) & static_cast<uint32_t>(same[l] != 0);
            }
        }
        if (hopeless == kLanes) continue;
        for (uint32_t k = first; k < std::min(first + kLanes, size_); ++k) {
            const uint64_t d = differ[k - first], s = same[k - first];
            if ((d != 0 && s != 0) || commonRows(key, k) < fewest) continue;
            if (d == 0) found.push_back({k, false});
            if (s == 0) found.push_back({k, true});
        }
    }
}

/// Selected rows that a column of the basis and a key both know.
uint32_t Basis::commonRows(const ColumnKey& key, uint32_t k) const
{
    const uint64_t* known = keys_.data() + groupSize() * (k / kLanes) + kLanes + k % kLanes;
    uint32_t count = 0;
    for (uint32_t w = 0; w < keyWords_; ++w)
        count += static_cast<uint32_t>(std::popcount(known[size_t(2) * kLanes * w] & key.known[w]));
    return count;
}

bool Basis::matchesSamples(const ColumnKey& key) const
{
    for (uint32_t k = 0; k < size_; ++k) {
        const uint64_t* lane = keys_.data() + groupSize() * (k / kLanes) + k % kLanes;
        uint64_t differ = 0, same = 0;
        for (uint32_t w = 0; w < keyWords_; ++w, lane += 2 * kLanes) {
            const uint64_t both = lane[kLanes] & key.known[w] & sampleKey_[w];
            differ |= (lane[0] ^ key.bits[w]) & both;
            same |= ~(lane[0] ^ key.bits[w]) & both;
        }
        if ((differ == 0) != (same == 0)) return true;
    }
    return false;
}

std::optional<Basis::Nearest> Basis::nearest(const ColumnKey& key, uint32_t fewest) const
{
    std::optional<Nearest> best;
    for (uint32_t k = 0; k < size_; ++k) {
        const uint64_t* lane = keys_.data() + groupSize() * (k / kLanes) + k % kLanes;
        uint32_t differ = 0;
        for (uint32_t w = 0; w < keyWords_; ++w, lane += 2 * kLanes)
            differ += static_cast<uint32_t>(
                std::popcount((lane[0] ^ key.bits[w]) & lane[kLanes] & key.known[w]));
        const uint32_t common = commonRows(key, k);
        if (common < fewest) continue;
        const bool complement = 2 * differ > common;
        const Nearest here{{k, complement}, complement ? common - differ : differ, common};
        if (!best || here.differ < best->differ) best = here;
    }
    return best;
}

}  // namespace core::many_lights
