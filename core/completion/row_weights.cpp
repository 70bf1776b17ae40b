// Weights of rows and draws by them.
#include "core/completion/row_weights.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/check.h"
#include "core/completion/bits.h"

namespace core::many_lights {

namespace {

/// Finds the rows of a mask by their numbers, which ascend from call to call.
class RowCursor {
public:
    explicit RowCursor(std::span<const uint64_t> mask) : mask_(mask) {}

    uint32_t rowOf(uint32_t number)
    {
        for (;; before_ += static_cast<uint32_t>(std::popcount(mask_[word_++])))
            if (number < before_ + static_cast<uint32_t>(std::popcount(mask_[word_]))) break;
        return 64 * word_ + placeOfBit(mask_[word_], number - before_);
    }

private:
    std::span<const uint64_t> mask_;
    uint32_t word_ = 0, before_ = 0;  // rows of the words before
};

}  // namespace

RowWeights::RowWeights(uint32_t rows)
    : count_(rows), weights_((size_t(rows) + kRun - 1) / kRun * kRun)
{
    std::fill_n(weights_.begin(), rows, 1.0 / rows);
}

void RowWeights::addRuns(std::span<const uint64_t> column, std::span<const uint64_t> known)
{
    // Known rows side by side: bits of the column, of which every change ends a run.
    const uint32_t count = countBits(known);
    if (count == 0) return;
    packed_.assign(known.size() + 1, 0);
    packBits(column, known, packed_.data());
    ends_.clear();
    uint64_t carry = packed_[0] & 1;  // the bit before this word
    for (uint32_t w = 0; w < wordsFor(count); ++w) {
        uint64_t changes = (packed_[w] ^ (packed_[w] << 1 | carry)) & wordOfRows(count, w);
        carry = packed_[w] >> 63;
        for (; changes != 0; changes &= changes - 1)
            ends_.push_back(64 * w + static_cast<uint32_t>(std::countr_zero(changes)));
    }
    ends_.push_back(count);
    const double share = 1.0 / static_cast<double>(ends_.size());
    uint32_t begin = 0;
    if (count == rows()) {
        for (const uint32_t end : ends_) {
            const double each = share / (end - begin);
            for (; begin < end; ++begin) weights_[begin] += each;
        }
    } else {
        shareOfRow_.resize(64 * known.size());
        double* out = shareOfRow_.data();
        RowCursor cursor(known);
        for (const uint32_t end : ends_) {
            double* const to = shareOfRow_.data() + cursor.rowOf(end - 1) + 1;
            std::fill(out, to, share / (end - begin));
            begin = end;
            out = to;
        }
        addWhere(known);
    }
    cumulated_.clear();
}

/// Adds what the known rows have of their runs.
void RowWeights::addWhere(std::span<const uint64_t> known)
{
    for (size_t w = 0; w < known.size(); ++w) {
        const size_t count = std::min<size_t>(64, count_ - 64 * w);
        const uint64_t word = known[w];
        double* __restrict weights = weights_.data() + 64 * w;
        const double* share = shareOfRow_.data() + 64 * w;
        if (word == 0) continue;
        for (size_t i = 0; i < count; ++i) weights[i] += (word >> i & 1) != 0 ? share[i] : 0.0;
    }
}

/// Prefix sums of all weights, at once for all runs, because a single sum waits for each addition.
void RowWeights::cumulate()
{
    if (!cumulated_.empty()) return;
    cumulated_.resize(weights_.size());
    const size_t runs = weights_.size() / kRun;
    inRun_.assign(runs, 0);
    runSums_.resize(runs);
    for (size_t i = 0; i < kRun; ++i)
        for (size_t r = 0; r < runs; ++r)
            cumulated_[kRun * r + i] = static_cast<float>(inRun_[r] += weights_[kRun * r + i]);
    float before = 0;
    for (size_t r = 0; r < runs; ++r) {
        for (size_t i = 0; i < kRun; ++i) cumulated_[kRun * r + i] += before;
        before = runSums_[r] = cumulated_[kRun * r + kRun - 1];
    }
    total_ = double(before);
    below_ = std::nextafter(before, 0.0f);
    runSums_.pop_back();  // what is not below any other sum is in the last run
    CHECK(std::isfinite(total_));
}

/// A row by weight: the first up to which the weights sum to more than a uniform number. Counting
/// the smaller sums, first of runs and then in one of them, is faster than a binary search, which
/// waits for memory at every step.
uint32_t RowWeights::pick(Pcg32& random) const
{
    const float u = std::min(static_cast<float>(random() * total_), below_);
    uint32_t run = 0, row = 0;
    for (const float sum : runSums_) run += static_cast<uint32_t>(sum <= u);
    const float* sums = &cumulated_[size_t(kRun) * run];
    for (uint32_t i = 0; i < kRun; ++i) row += static_cast<uint32_t>(sums[i] <= u);
    return std::min(kRun * run + row, count_ - 1);
}

/// Calls take(i) for rows drawn by weight, with replacement, until it has returned true `count`
/// times or often enough false. Returns how many are missing.
template <class Take>
uint32_t RowWeights::drawUntil(uint32_t count, uint32_t attempts, Pcg32& random, Take&& take)
{
    cumulate();
    for (; count > 0 && attempts > 0; --attempts)
        if (take(pick(random))) --count;
    return count;
}

void RowWeights::draw(uint32_t count, std::span<const uint64_t> eligible, Pcg32& random,
                      std::span<uint64_t> drawn)
{
    const uint32_t available = countBits(eligible);
    if (count >= available) {
        std::copy(eligible.begin(), eligible.end(), drawn.begin());
        return;
    }
    // Rows that are not eligible or have been drawn are rejected. That becomes slow when the others
    // weigh little; what is left is then drawn by keys. Successive draws have no memory, so that
    // the distribution is the same.
    const uint32_t left = drawUntil(count, 4 * count + 16, random, [&](uint32_t i) {
        const bool fresh = getBit(eligible, i) && !getBit(drawn, i);
        if (fresh) setBit(drawn, i);
        return fresh;
    });
    if (left > 0) drawByKeys(left, eligible, random, drawn);
}

/// Adds the rows of the least -ln(u) / w (P. Efraimidis, P. Spirakis, "Weighted Random Sampling
/// with a Reservoir", 2006) to what has been drawn.
void RowWeights::drawByKeys(uint32_t count, std::span<const uint64_t> eligible, Pcg32& random,
                            std::span<uint64_t> drawn) const
{
    std::vector<std::pair<double, uint32_t>> keys;
    forEachBit(eligible, [&](uint32_t i) {
        if (!getBit(drawn, i)) keys.emplace_back(-std::log(1 - random()) / weights_[i], i);
    });
    std::nth_element(keys.begin(), keys.begin() + count, keys.end());
    for (uint32_t k = 0; k < count; ++k) setBit(drawn, keys[k].second);
}

void RowWeights::drawWithReplacement(uint32_t count, std::span<const uint64_t> eligible,
                                     Pcg32& random, std::span<uint64_t> drawn)
{
    if (countBits(eligible) == 0) return;
    drawUntil(count, 16 * count + 64, random, [&](uint32_t i) {
        if (!getBit(eligible, i)) return false;
        setBit(drawn, i);
        return true;
    });
}

double drawUniform(uint32_t count, std::span<const uint64_t> eligible, Pcg32& random,
                   std::span<uint64_t> drawn)
{
    const uint32_t available = countBits(eligible);
    if (count >= available) {
        std::copy(eligible.begin(), eligible.end(), drawn.begin());
        return 1;
    }
    const double probability = double(count) / double(available);
    const auto range = static_cast<uint32_t>(64 * eligible.size());
    uint32_t left = count;
    if (2 * available > range && 2 * count < available) {  // most attempts succeed
        while (left > 0) {
            const uint32_t i = drawBelow(range, random);
            if (!getBit(eligible, i) || getBit(drawn, i)) continue;
            setBit(drawn, i);
            --left;
        }
        return probability;
    }
    // D. Knuth, "The Art of Computer Programming" 2, algorithm S: one pass over the rows.
    uint32_t rest = available;
    forEachBit(eligible, [&](uint32_t i) {
        if (drawBelow(rest--, random) >= left) return;
        setBit(drawn, i);
        --left;
    });
    return probability;
}

}  // namespace core::many_lights
