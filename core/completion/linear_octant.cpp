// Completion by linear combinations: the loop over columns.
#include "core/completion/linear_octant.h"

#include <algorithm>
#include <cmath>

namespace core::many_lights {

LinearOctant::LinearOctant(Tracer& tracer, std::span<const uint32_t> columns,
                           const CompletionParams& params, uint64_t seed, CompletedSlice& out)
    : Octant(tracer, columns, params, seed, 1, out), predicted_(out.visible.rows()),
      samples_(tracer.all().size()), checks_(tracer.all().size())
{}

void LinearOctant::run()
{
    for (size_t at = 0; at < columns_.size(); ++at) {
        block_.begin(columns_.subspan(at, 1));
        if (basisSize() == 0 || !sampled())
            traceFully();
        else if (isTraced(0))
            finishTraced();
        else if (!predict(block_.visible(0), block_.matters(0), samples_))
            traceFully();
        else if (verified())
            take();
        else
            traceFully();
    }
    finish(basisSize());
}

/// A column of which all rows that matter happen to be sampled.
void LinearOctant::finishTraced()
{
    noteFull(0);
    writeTraced(0);
}

/// Samples the column; false where that is not worth while, or tells too little of it.
bool LinearOctant::sampled()
{
    std::ranges::fill(samples_, 0);
    drawn_ = chooseRows(block_.matters(0), samples_);
    if (countBits(samples_) == 0) return false;
    block_.fetch(0, samples_);
    return isTraced(0) || countBits(block_.traced(0)) >= fewestRows();
}

bool LinearOctant::verified()
{
    if (checkCount() == 0) return true;
    fetchChecks(0, checkCount(), tracer_.all(), checks_);
    const auto visible = block_.visible(0);
    bool right = true;
    forEachBit(checks_,
               [&](uint32_t i) { right = right && (predicted_[i] > 0.5f) == getBit(visible, i); });
    if (!right) raiseRate();
    return right;
}

void LinearOctant::take()
{
    writePrediction(0, predicted_);
    noteMatched(0, drawn_);
    addResidual();
}

/// Samples the error of the prediction, whose rows decide nothing else.
void LinearOctant::addResidual()
{
    if (params_.residualRate <= 0) return;
    const auto matters = block_.matters(0), traced = block_.traced(0);
    Words left(samples_.size()), rows(samples_.size()), truth(samples_.size());
    for (size_t w = 0; w < left.size(); ++w) left[w] = matters[w] & ~traced[w];
    const auto count = static_cast<uint32_t>(std::ceil(double(params_.residualRate) * rows_));
    const double probability = drawUniform(count, left, random_, rows);
    const uint32_t j = block_.column(0);
    tracer_.trace(j, rows, truth);
    forEachBit(rows, [&](uint32_t i) {
        const float predicted = !out_.coefficients.empty()
                                    ? out_.coefficients[size_t(j) * rows_ + i]
                                    : static_cast<float>(getBit(block_.visible(0), i));
        const float error = static_cast<float>(getBit(truth, i)) - predicted;
        if (error != 0) out_.residual.push_back({i, j, error / static_cast<float>(probability)});
    });
}

void LinearOctant::traceFully()
{
    fetchAll(0);
    writeTraced(0);
    append(block_.visible(0));
}

}  // namespace core::many_lights
