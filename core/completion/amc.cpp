// Adaptive matrix completion.
#include "core/completion/amc.h"

#include <algorithm>
#include <cmath>

namespace core::many_lights {

namespace {

constexpr double kAgreement = 1e-3;  // sum of deviations in the sampled rows
constexpr double kSingular = 1e-5;   // singular values that count as zero
constexpr uint32_t kMargin = 10;     // sampled rows beyond the number of known columns

}  // namespace

AmcOctant::AmcOctant(Tracer& tracer, std::span<const uint32_t> columns,
                     const CompletionParams& params, uint64_t seed, CompletedSlice& out)
    : LinearOctant(tracer, columns, params, seed, out), sampledRows_(tracer.all().size())
{
    if (params.seedConstant) append(tracer.all());
}

void AmcOctant::append(std::span<const uint64_t> column)
{
    std::vector<float>& signs = basis_.emplace_back(rows_, -1.0f);
    forEachBit(column, [&](uint32_t i) { signs[i] = 1; });
    drawn_ = 0;
}

/// The rows stay the same as long as the basis does.
uint32_t AmcOctant::chooseRows(std::span<const uint64_t>, Words& rows)
{
    if (drawn_ == 0) {
        drawn_ = sampleCount();
        if (params_.guard) drawn_ = std::max(drawn_, basisSize() + kMargin);
        std::ranges::fill(sampledRows_, 0);
        if (params_.guard)  // counts distinct rows
            weights_.draw(drawn_, tracer_.all(), random_, sampledRows_);
        else
            drawSamples(drawn_, tracer_.all(), sampledRows_);
        numbers_.clear();
        forEachBit(sampledRows_, [&](uint32_t i) { numbers_.push_back(i); });
        sampled_ = Matrix(numbers_.size(), basis_.size());
        for (size_t k = 0; k < basis_.size(); ++k)
            for (size_t i = 0; i < numbers_.size(); ++i)
                sampled_(i, k) = double(basis_[k][numbers_[i]]);
        inverse_ = pseudoInverse(sampled_, kSingular);
    }
    rows = sampledRows_;
    return drawn_;
}

bool AmcOctant::predict(std::span<const uint64_t> column, std::span<const uint64_t> matters,
                        const Words&)
{
    Matrix x(numbers_.size(), 1);
    for (size_t i = 0; i < numbers_.size(); ++i)
        x(i, 0) = getBit(column, numbers_[i]) && getBit(matters, numbers_[i]) ? 1 : -1;
    const Matrix factors = product(inverse_, x), fit = product(sampled_, factors);
    double deviation = 0;
    for (size_t i = 0; i < numbers_.size(); ++i) deviation += std::abs(fit(i, 0) - x(i, 0));
    if (!(deviation <= kAgreement)) return false;

    std::ranges::fill(predicted_, 0.5f);
    for (size_t k = 0; k < basis_.size(); ++k) {
        const auto factor = static_cast<float>(0.5 * factors(k, 0));
        for (uint32_t i = 0; i < rows_; ++i) predicted_[i] += factor * basis_[k][i];
    }
    return true;
}

}  // namespace core::many_lights
