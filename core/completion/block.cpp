// Requests for rows of a block of columns.
#include "core/completion/block.h"

#include <algorithm>

namespace core::many_lights {

void Block::begin(std::span<const uint32_t> columns)
{
    CHECK(columns.size() <= traced_.columns());
    columns_.assign(columns.begin(), columns.end());
    for (uint32_t c = 0; c < columns_.size(); ++c) {
        std::ranges::fill(traced_.column(c), 0);
        std::ranges::fill(residual_.column(c), 0);
        std::ranges::fill(residualBits_.column(c), 0);
    }
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
    const bool apart = std::ranges::any_of(residual, [](uint64_t word) { return word != 0; });
    requests_.clear();
    for (uint32_t c = 0; c < size(); ++c) {
        const auto matters = this->matters(c);
        const auto traced = traced_.column(c);
        for (size_t w = 0; w < words; ++w) traced[w] = rows[w] & matters[w];
        requests_.push_back({column(c), traced.data(), visible(c).data()});
        if (!apart) continue;
        const auto set = residual_.column(c);
        for (size_t w = 0; w < words; ++w) set[w] = residual[w] & matters[w] & ~traced[w];
        requests_.push_back({column(c), set.data(), residualBits_.column(c).data()});
    }
    tracer_.trace(requests_);
}

/// Marks rows as traced, takes those of the residual from there and writes those to ask for.
uint32_t Block::claim(size_t c, std::span<const uint64_t> rows, std::span<uint64_t> ask)
{
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

uint32_t Block::fetch(size_t c, std::span<const uint64_t> rows)
{
    ask_.resize(rows.size());
    const uint32_t count = claim(c, rows, ask_);
    return count > 0 ? tracer_.trace(column(c), ask_, visible(c)) : 0;
}

void Block::fetchRest(std::span<const size_t> which)
{
    const size_t words = visible_.wordsPerColumn();
    ask_.resize(words * which.size());
    requests_.clear();
    for (size_t k = 0; k < which.size(); ++k) {
        const std::span<uint64_t> ask{&ask_[words * k], words};
        if (claim(which[k], tracer_.all(), ask) > 0)
            requests_.push_back({column(which[k]), ask.data(), visible(which[k]).data()});
    }
    if (!requests_.empty()) tracer_.trace(requests_);
}

}  // namespace core::many_lights
