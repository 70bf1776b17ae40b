// Weights of rows and draws by them.
#include "core/many_lights/row_weights.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/many_lights/bits.h"

namespace core::many_lights {

void RowWeights::addRuns(std::span<const uint64_t> column, std::span<const uint64_t> known)
{
    rows_.clear();  // ends of runs are kept as indices into the list of known rows
    uint32_t runs = 0;
    bool last = false;
    forEachBit(known, [&](uint32_t i) {
        const bool lit = getBit(column, i);
        if (rows_.empty() || lit != last) ++runs;
        last = lit;
        rows_.push_back(i);
    });
    if (runs == 0) return;
    const double share = 1.0 / runs;
    for (size_t begin = 0; begin < rows_.size();) {
        const bool lit = getBit(column, rows_[begin]);
        size_t end = begin + 1;
        while (end < rows_.size() && getBit(column, rows_[end]) == lit) ++end;
        const double each = share / static_cast<double>(end - begin);
        for (; begin < end; ++begin) weights_[rows_[begin]] += each;
    }
}

double RowWeights::cumulate(std::span<const uint64_t> eligible)
{
    rows_.clear();
    cumulated_.clear();
    double sum = 0;
    forEachBit(eligible, [&](uint32_t i) {
        sum += weights_[i];
        rows_.push_back(i);
        cumulated_.push_back(sum);
    });
    CHECK(std::isfinite(sum));
    return sum;
}

uint32_t RowWeights::pick(double u) const
{
    const auto at = std::upper_bound(cumulated_.begin(), cumulated_.end(), u);
    return rows_[std::min<size_t>(static_cast<size_t>(at - cumulated_.begin()), rows_.size() - 1)];
}

void RowWeights::draw(uint32_t count, std::span<const uint64_t> eligible, Pcg32& random,
                      std::span<uint64_t> drawn)
{
    const double sum = cumulate(eligible);
    if (count >= rows_.size()) {
        std::copy(eligible.begin(), eligible.end(), drawn.begin());
        return;
    }
    // Rejection becomes slow when what has been drawn weighs most of the whole; what is left is
    // then drawn by keys. Successive draws have no memory, so that the distribution is the same.
    uint32_t left = count;
    for (uint32_t attempts = 4 * count + 16; left > 0 && attempts > 0; --attempts) {
        const uint32_t i = pick(random() * sum);
        if (getBit(drawn, i)) continue;
        setBit(drawn, i);
        --left;
    }
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
    const double sum = cumulate(eligible);
    if (rows_.empty()) return;
    for (uint32_t k = 0; k < count; ++k) setBit(drawn, pick(random() * sum));
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
