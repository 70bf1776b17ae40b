// Requests for rows of a block of columns.
#include "core/completion/block.h"

#include <algorithm>

namespace core::many_lights {

void Block::begin(std::span<const uint32_t> columns)
{
    CHECK(columns.size() <= traced_.columns());
    columns_.assign(columns.begin(), columns.end());
    matters_.clear();
    for (const uint32_t j : columns_) matters_.push_back(tracer_.matters(j));
    const auto clear = [this](BitMatrix& rows) {  // columns lie one after the other
        std::fill_n(rows.column(0).data(), size() * visible_.wordsPerColumn(), 0);
    };
    if (columns_.empty()) return;
    clear(traced_);
    if (!apart_) return;
    clear(residual_);
    clear(residualBits_);
    apart_ = false;
}

void Block::unionOfMatters(std::span<uint64_t> rows) const
{
    std::ranges::fill(rows, 0);
    for (size_t c = 0; c < size(); ++c) {
        const auto matters = this->matters(c);
        for (size_t w = 0; w < rows.size(); ++w) rows[w] |= matters[w];
    }
}

void Block::fetchAll(std::span<const uint64_t> rows, std::span<const uint64_t> residual)
{
    const size_t words = rows.size();
    apart_ = std::ranges::any_of(residual, [](uint64_t word) { return word != 0; });
    requests_.clear();
    for (uint32_t c = 0; c < size(); ++c) {
        const auto matters = this->matters(c);
        const auto traced = traced_.column(c);
        for (size_t w = 0; w < words; ++w) traced[w] = rows[w] & matters[w];
        requests_.push_back({column(c), traced.data(), visible(c).data()});
        if (!apart_) continue;
        const auto set = residual_.column(c);
        for (size_t w = 0; w < words; ++w) set[w] = residual[w] & matters[w] & ~traced[w];
        requests_.push_back({column(c), set.data(), residualBits_.column(c).data()});
    }
    tracer_.trace(requests_);
}

/// Marks rows as traced, takes those of the residual from there and writes those to ask for.
uint32_t Block::claim(size_t c, std::span<const uint64_t> rows, std::span<uint64_t> ask)
{
    if (!apart_) return claimPlain(c, rows.data(), ask);
    const auto matters = this->matters(c);
    const auto traced = traced_.column(index(c));
    const auto residual = residual_.column(index(c)), visible = this->visible(c);
    const auto bits = residualBits_.column(index(c));
    uint32_t count = 0;
    for (size_t w = 0; w < ask.size(); ++w) {
        const uint64_t fresh = rows[w] & matters[w] & ~traced[w];
        visible[w] |= bits[w] & residual[w] & fresh;
        ask[w] = fresh & ~residual[w];
        residual[w] &= ~fresh;
        traced[w] |= fresh;
        count += static_cast<uint32_t>(std::popcount(ask[w]));
    }
    return count;
}

/// Where there is no residual.
uint32_t Block::claimPlain(size_t c, const uint64_t* rows, std::span<uint64_t> ask)
{
    const uint64_t* matters = this->matters(c).data();
    uint64_t* __restrict traced = traced_.column(index(c)).data();
    uint64_t* __restrict to = ask.data();
    uint64_t count = 0;
    for (size_t w = 0, words = ask.size(); w < words; ++w) {
        const uint64_t fresh = rows[w] & matters[w] & ~traced[w];
        to[w] = fresh;
        traced[w] |= fresh;
        count += static_cast<uint64_t>(std::popcount(fresh));
    }
    return static_cast<uint32_t>(count);
}

uint32_t Block::fetch(size_t c, std::span<const uint64_t> rows)
{
    const uint32_t count = claim(c, rows, ask_);
    if (count > 0) tracer_.trace(column(c), ask_, visible(c), count);
    return count;
}

bool Block::fetchRow(size_t c, uint32_t row)
{
    const size_t w = row / 64;
    const uint64_t bit = uint64_t(1) << row % 64;
    traced_.column(index(c))[w] |= bit;
    uint64_t& apart = residual_.column(index(c))[w];
    if ((apart & bit) != 0) {
        visible(c)[w] |= residualBits(c)[w] & bit;
        apart &= ~bit;
    } else {
        std::ranges::fill(ask_, 0);
        ask_[w] = bit;
        tracer_.trace(column(c), ask_, visible(c), 1);
    }
    return (visible(c)[w] & bit) != 0;
}

void Block::fetchRest(std::span<const size_t> which)
{
    const size_t words = visible_.wordsPerColumn();
    askAll_.resize(words * which.size());
    requests_.clear();
    for (size_t k = 0; k < which.size(); ++k) {
        const std::span<uint64_t> ask{&askAll_[words * k], words};
        if (claim(which[k], tracer_.all(), ask) > 0)
            requests_.push_back({column(which[k]), ask.data(), visible(which[k]).data()});
    }
    if (!requests_.empty()) tracer_.trace(requests_);
}

}  // namespace core::many_lights
