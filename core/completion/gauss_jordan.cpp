// Gauss-Jordan elimination over GF(2), a column at a time.
#include "core/completion/gauss_jordan.h"

#include <algorithm>

namespace core::many_lights {

void EchelonBasis::add(uint32_t k, std::span<uint64_t> to) const
{
    for (size_t w = 0; w < words_; ++w) to[w] ^= columns_[k * words_ + w];
}

bool EchelonBasis::insert(std::span<const uint64_t> column)
{
    Words rest(column.begin(), column.end());
    for (uint32_t k = 0; k < size(); ++k)
        if (getBit(column, pivots_[k])) add(k, rest);
    const auto first = std::ranges::find_if(rest, [](uint64_t word) { return word != 0; });
    if (first == rest.end()) return false;
    const auto pivot = static_cast<uint32_t>(64 * (first - rest.begin())) +
                       static_cast<uint32_t>(std::countr_zero(*first));
    for (uint32_t k = 0; k < size(); ++k)
        if (getBit(this->column(k), pivot))
            for (size_t w = 0; w < words_; ++w) columns_[k * words_ + w] ^= rest[w];
    columns_.insert(columns_.end(), rest.begin(), rest.end());
    pivots_.push_back(pivot);
    setBit(pivotRows_, pivot);
    return true;
}

void EchelonBasis::combine(std::span<const uint64_t> column, std::span<const uint64_t> rows,
                           std::span<uint64_t> sum) const
{
    std::ranges::fill(sum, 0);
    for (uint32_t k = 0; k < size(); ++k)
        if (getBit(rows, pivots_[k]) && getBit(column, pivots_[k])) add(k, sum);
}

GaussJordanOctant::GaussJordanOctant(Tracer& tracer, std::span<const uint32_t> columns,
                                     const CompletionParams& params, uint64_t seed,
                                     CompletedSlice& out)
    : LinearOctant(tracer, columns, params, seed, out), basis_(out.visible.rows()),
      others_(tracer.all().size()), chosen_(tracer.all().size())
{
    if (params.seedConstant) basis_.insert(tracer.all());
}

/// Half of the rows are pivots (with the guard as many as there are), the others are drawn by
/// weight among the rest.
uint32_t GaussJordanOctant::chooseRows(std::span<const uint64_t> matters, Words& rows)
{
    const uint32_t r = basis_.size();
    const uint32_t count = params_.guard ? std::max(sampleCount(), 2 * r) : sampleCount();
    const uint32_t leading = std::min(r, std::max(1u, count / 2));
    drawUniform(leading, basis_.pivotRows(), random_, rows);
    for (size_t w = 0; w < rows.size(); ++w) others_[w] = matters[w] & ~basis_.pivotRows()[w];
    std::ranges::fill(chosen_, 0);
    drawSamples(count - leading, others_, chosen_);
    for (size_t w = 0; w < rows.size(); ++w) rows[w] |= chosen_[w];
    return count;
}

bool GaussJordanOctant::predict(std::span<const uint64_t> column, std::span<const uint64_t> matters,
                                const Words& samples)
{
    basis_.combine(column, samples, chosen_);
    uint64_t wrong = 0;
    for (size_t w = 0; w < samples.size(); ++w)
        wrong |= (chosen_[w] ^ column[w]) & samples[w] & matters[w];
    if (wrong != 0) return false;
    bitsToFloats(chosen_, predicted_);
    return true;
}

}  // namespace core::many_lights
