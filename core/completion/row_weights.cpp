// Weights of rows and draws by them.
#include "core/completion/row_weights.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/base/check.h"
#include "core/completion/bits.h"

namespace core::many_lights {

namespace {

constexpr uint32_t kTogether = 16;  // sums that are compared at once

/// How many of these sums are not above u.
uint32_t countUpTo(float u, const float* sums)
{
#ifdef __AVX512F__
    const __m512 all = _mm512_loadu_ps(sums);
    return static_cast<uint32_t>(
        std::popcount(_mm512_cmp_ps_mask(all, _mm512_set1_ps(u), _CMP_LE_OQ)));
#else
    uint32_t count = 0;
    for (uint32_t i = 0; i < kTogether; ++i) count += static_cast<uint32_t>(sums[i] <= u);
    return count;
#endif
}

}  // namespace

RowWeights::RowWeights(uint32_t rows)
    : count_(rows), runs_((size_t(rows) + kRun - 1) / kRun), steps_(runs_ * kRun)
{
    raise(0, rows, 1.0 / rows);
}

std::span<const double> RowWeights::weights()
{
    weights_.resize(count_);
    double weight = 0;
    for (uint32_t i = 0; i < count_; ++i)
        weights_[i] = weight = (i % kRun == 0 ? 0 : weight) + step(i);
    return weights_;
}

void RowWeights::addRuns(std::span<const uint64_t> column, std::span<const uint64_t> known)
{
    findPieces(column, known);
    if (pieces_.empty()) return;
    const double share = 1.0 / static_cast<double>(length_.size());
    for (const Piece& piece : pieces_) raise(piece.begin, piece.end, share / length_[piece.run]);
    cumulated_.clear();
}

/// Divides the known rows where the column changes and at unknown rows; pieces of equal bits with
/// only unknown rows between them are one run.
void RowWeights::findPieces(std::span<const uint64_t> column, std::span<const uint64_t> known)
{
    pieces_.clear();
    length_.clear();
    uint64_t knownBefore = 0, bitBefore = 0;  // of the row before this word
    uint64_t bit = 0;                         // of the last piece
    bool open = false;                        // the last piece goes on
    const auto end = [&](uint32_t row) {
        pieces_.back().end = row;
        length_.back() += row - pieces_.back().begin;
        open = false;
    };
    for (uint32_t w = 0; w < known.size(); ++w) {
        const uint64_t rows = known[w], bits = column[w] & rows;
        uint64_t changes = (rows ^ (rows << 1 | knownBefore)) | (bits ^ (bits << 1 | bitBefore));
        knownBefore = rows >> 63;
        bitBefore = bits >> 63;
        for (; changes != 0; changes &= changes - 1) {
            const auto place = static_cast<uint32_t>(std::countr_zero(changes));
            const uint32_t row = 64 * w + place;
            if (open) end(row);
            if ((rows >> place & 1) == 0) continue;
            if (length_.empty() || bit != (bits >> place & 1)) length_.push_back(0);
            bit = bits >> place & 1;
            pieces_.push_back({row, row, static_cast<uint32_t>(length_.size() - 1)});
            open = true;
        }
    }
    if (open) end(std::min(count_, static_cast<uint32_t>(64 * known.size())));
}

/// Adds to the weights of begin <= i < end.
void RowWeights::raise(uint32_t begin, uint32_t end, double by)
{
    step(begin) += by;
    double* first = steps_.data();  // of each run
    const size_t behind = (size_t(end) + kRun - 1) / kRun;
    for (size_t r = begin / kRun + 1; r < behind; ++r) first[r] += by;
    if (end % kRun != 0) step(end) -= by;
}

/// Prefix sums of all weights, at once for all runs, because a single sum waits for each addition.
void RowWeights::cumulate()
{
    if (!cumulated_.empty()) return;
    cumulated_.resize(steps_.size());
    const size_t runs = runs_;
    rowOfRun_.assign(runs, 0);
    inRun_.assign(runs, 0);
    runSums_.assign((runs + kTogether - 1) / kTogether * kTogether,
                    std::numeric_limits<float>::infinity());
    for (size_t i = 0; i < kRun; ++i) {
        const double* step = &steps_[i * runs];
        for (size_t r = 0; r < runs; ++r)
            cumulated_[kRun * r + i] = static_cast<float>(inRun_[r] += rowOfRun_[r] += step[r]);
    }
    float before = 0;
    for (size_t r = 0; r < runs; ++r) {
        for (size_t i = 0; i < kRun; ++i) cumulated_[kRun * r + i] += before;
        before = runSums_[r] = cumulated_[kRun * r + kRun - 1];
    }
    total_ = double(before);
    below_ = std::nextafter(before, 0.0f);
    runSums_[runs - 1] = std::numeric_limits<float>::infinity();  // the last run has what is left
    CHECK(std::isfinite(total_));
}

/// A row by weight: the first up to which the weights sum to more than a uniform number. Counting
/// the smaller sums, first of runs and then in one of them, is faster than a binary search, which
/// waits for memory at every step.
uint32_t RowWeights::pick(Pcg32& random) const
{
    const float u = std::min(static_cast<float>(random() * total_), below_);
    uint32_t run = 0, row = 0;
    for (size_t first = 0; first < runSums_.size(); first += kTogether)
        run += countUpTo(u, &runSums_[first]);
    const float* sums = &cumulated_[size_t(kRun) * run];
    for (uint32_t first = 0; first < kRun; first += kTogether) row += countUpTo(u, sums + first);
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
                            std::span<uint64_t> drawn)
{
    const std::span<const double> weights = this->weights();
    std::vector<std::pair<double, uint32_t>> keys;
    forEachBit(eligible, [&](uint32_t i) {
        if (!getBit(drawn, i)) keys.emplace_back(-std::log(1 - random()) / weights[i], i);
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
