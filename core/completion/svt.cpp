// Completion by nuclear norm.
#include "core/completion/svt.h"

#include <algorithm>

#include "core/completion/low_rank.h"

namespace core::many_lights {

SvtOctant::SvtOctant(Tracer& tracer, std::span<const uint32_t> columns,
                     const CompletionParams& params, uint64_t seed, CompletedSlice& out)
    : Octant(tracer, columns, params, seed, columns.size(), out)
{}

void SvtOctant::run(const std::stop_token& stop)
{
    block_.begin(columns_);
    const auto count = static_cast<uint32_t>(columns_.size());
    Matrix values(rows_, count);
    BitMatrix known(rows_, count);
    Words rows(tracer_.all().size());
    for (uint32_t c = 0; c < count; ++c) {
        std::ranges::fill(rows, 0);
        drawUniform(sampleCount(), block_.matters(c), random_, rows);
        block_.fetch(c, rows);
        const auto visible = block_.visible(c);
        forEachBit(block_.traced(c), [&](uint32_t i) {
            values(i, c) = getBit(visible, i) ? 1 : -1;
            known.set(i, c, true);
        });
    }
    SvtSettings settings;
    settings.iterations = params_.svtIterations;
    const LowRank low = completeLowRank(values, known, settings, random_, stop);
    std::vector<float> lit(rows_);
    for (uint32_t c = 0; c < count; ++c) {
        for (uint32_t i = 0; i < rows_; ++i)
            lit[i] = static_cast<float>(0.5 * (low.matrix(i, c) + 1));
        writePrediction(c, lit);
        if (isTraced(c))
            noteFull(c);
        else
            noteMatched(c, sampleCount());
    }
    finish(static_cast<uint32_t>(low.rank));
}

}  // namespace core::many_lights
