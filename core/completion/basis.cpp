// The basis of an octant and its comparison with a column, eight columns at a time.
#include "core/completion/basis.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

namespace core::many_lights {

namespace {

/// A word of each of eight columns.
using Lanes = uint64_t __attribute__((vector_size(64)));

/// Bit l is 1 where lane l is zero.
uint32_t zeroLanes(const Lanes& lanes)
{
#ifdef __AVX512F__
    const auto all = std::bit_cast<__m512i>(lanes);
    return _mm512_testn_epi64_mask(all, all);
#else
    uint32_t zero = 0;
    for (uint32_t l = 0; l < 8; ++l) zero |= (lanes[l] == 0 ? 1u : 0u) << l;
    return zero;
#endif
}

/// Which of eight columns agree with a key, or with its complement, in the rows of `mask` that both
/// know. Where there are no such rows, as for a column that is not there, it is neither.
struct Agreement {
    Agreement(const uint64_t* group, const ColumnKey& key, const uint64_t* mask, size_t words)
    {
        Lanes differ{}, same{};
        for (size_t w = 0; w < words; ++w, group += 16) {
            Lanes bits, known;
            std::memcpy(&bits, group, sizeof bits);
            std::memcpy(&known, group + 8, sizeof known);
            const Lanes both = known & (key.known[w] & mask[w]), unequal = (bits ^ key.bits[w]);
            differ |= unequal & both;
            same |= ~unequal & both;
        }
        neverDiffer = zeroLanes(differ);
        neverSame = zeroLanes(same);
    }
    uint32_t complement() const { return neverSame & ~neverDiffer; }
    uint32_t either() const { return neverSame ^ neverDiffer; }
    /// Those, too, that share no such row with the key.
    uint32_t possible() const { return neverSame | neverDiffer; }

    uint32_t neverDiffer, neverSame;
};

}  // namespace

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
                                          std::span<const uint64_t> known,
                                          const ColumnKey* key) const
{
    for (uint32_t first = 0; first < size_; first += kLanes) {
        auto rest = static_cast<uint32_t>(wordOfRows(std::min(size_ - first, kLanes), 0));
        if (key != nullptr)
            rest &= Agreement(group(first), *key, wholeKey_.data(), keyWords_).possible();
        for (; rest != 0; rest &= rest - 1) {
            Candidate candidate{first + static_cast<uint32_t>(std::countr_zero(rest)), false};
            if (isEqual(bits, known, candidate)) return candidate;
        }
    }
    return std::nullopt;
}

/// Whether a column of the basis, or its complement, is the same, and which of them.
bool Basis::isEqual(std::span<const uint64_t> bits, std::span<const uint64_t> known,
                    Candidate& candidate) const
{
    const auto ours = this->bits(candidate.index), here = this->known(candidate.index);
    uint64_t differ = 0, same = 0;
    uint32_t common = 0, all = 0;
    for (size_t w = 0; w < here.size(); ++w) {
        const uint64_t both = known[w] & here[w], unequal = bits[w] ^ ours[w];
        differ |= unequal & both;
        same |= ~unequal & both;
        common += static_cast<uint32_t>(std::popcount(both));
        all += static_cast<uint32_t>(std::popcount(known[w]));
    }
    candidate.complement = differ != 0;
    return (differ == 0 || same == 0) && common > all / 2;
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
    selected_.resize(words_);
    uint32_t count = 0;
    for (uint32_t w = 0; w < words_; ++w) {
        const uint64_t mask = selected_[w] = samples[w] | checks[w];
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
    keys_.assign(groupSize() * ((size_ + kLanes - 1) / kLanes), 0);
    for (uint32_t k = 0; k < size_; ++k) packLane(k);
}

/// Packs the selected bits into keyWords_ words, each `stride` behind the one before. The word that
/// is being filled stays in a register.
void Basis::pack(std::span<const uint64_t> words, uint64_t* key, size_t stride) const
{
    uint64_t filling = 0;
    for (const Part& part : parts_) {
        const uint64_t bits = extractBits(words[part.word], part.mask);
        filling |= bits << part.shift;
        const uint32_t end = part.shift + part.count;
        if (end < 64) continue;
        *key = filling;
        key += stride;
        filling = end > 64 ? bits >> (64 - part.shift) : 0;
    }
    if (unfinished_) *key = filling;
}

bool Basis::knowsSelected(std::span<const uint64_t> known) const
{
    uint64_t unknown = 0;
    for (size_t w = 0; w < selected_.size(); ++w) unknown |= selected_[w] & ~known[w];
    return unknown == 0;
}

void Basis::packLane(uint32_t k)
{
    constexpr size_t kStride = size_t(2) * kLanes;
    uint64_t* lane = keys_.data() + groupSize() * (k / kLanes) + k % kLanes;
    pack(bits(k), lane, kStride);
    lane += kLanes;
    if (knowsSelected(known(k)))  // as most columns do: packing takes longer
        for (uint32_t w = 0; w < keyWords_; ++w) lane[kStride * w] = wholeKey_[w];
    else
        pack(known(k), lane, kStride);
}

void Basis::makeKey(std::span<const uint64_t> bits, std::span<const uint64_t> known,
                    ColumnKey& key) const
{
    key.bits.resize(keyWords_);
    pack(bits, key.bits.data());
    if (knowsSelected(known)) {
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
        const Agreement lanes(group(first), key, wholeKey_.data(), keyWords_);
        for (uint32_t rest = lanes.either(); rest != 0; rest &= rest - 1) {
            const auto lane = static_cast<uint32_t>(std::countr_zero(rest));
            if (commonRows(key, first + lane) < fewest) continue;
            found.push_back({first + lane, (lanes.complement() >> lane & 1) != 0});
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
    for (uint32_t first = 0; first < size_; first += kLanes) {
        const Agreement lanes(group(first), key, sampleKey_.data(), keyWords_);
        if (lanes.either() != 0) return true;
    }
    return false;
}

std::optional<Basis::Nearest> Basis::nearest(const ColumnKey& key, uint32_t fewest) const
{
    std::optional<Nearest> best;
    for (uint32_t first = 0; first < size_; first += kLanes) {
        std::array<uint64_t, kLanes> differ{}, common{};
        const uint64_t* words = group(first);
        for (uint32_t w = 0; w < keyWords_; ++w, words += 2 * kLanes) {
            const uint64_t bits = key.bits[w], known = key.known[w];
            for (uint32_t l = 0; l < kLanes; ++l) {
                const uint64_t both = words[kLanes + l] & known;
                differ[l] += static_cast<uint64_t>(std::popcount((words[l] ^ bits) & both));
                common[l] += static_cast<uint64_t>(std::popcount(both));
            }
        }
        for (uint32_t l = 0; l < std::min(kLanes, size_ - first); ++l) {
            if (common[l] < fewest) continue;
            const auto count = static_cast<uint32_t>(common[l]);
            const auto wrong = static_cast<uint32_t>(differ[l]);
            const bool complement = 2 * wrong > count;
            const uint32_t least = complement ? count - wrong : wrong;
            if (!best || least < best->differ) best = {{first + l, complement}, least, count};
        }
    }
    return best;
}

}  // namespace core::many_lights
