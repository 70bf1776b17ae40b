// The part that all ways of completion share.
#include "core/completion/octant.h"

#include <algorithm>
#include <cmath>

namespace core::many_lights {

namespace {

uint32_t share(double rate, uint32_t rows)
{
    return static_cast<uint32_t>(std::lround(rate * rows));
}

}  // namespace

Octant::Octant(Tracer& tracer, std::span<const uint32_t> columns, const CompletionParams& params,
               uint64_t seed, size_t together, CompletedSlice& out)
    : rows_(out.visible.rows()), columns_(columns), params_(params), out_(out), stats_(out.stats),
      tracer_(tracer), block_(tracer, out.visible, static_cast<uint32_t>(together)),
      weights_(rows_), random_(seed), rate_(double(params.rowRate))
{}

uint32_t Octant::sampleCount() const
{
    return std::max({share(rate_, rows_), params_.rowMinimum, 1u});
}

uint32_t Octant::checkCount() const
{
    if (params_.verificationRate <= 0) return 0;
    return std::max({share(double(params_.verificationRate), rows_), params_.rowMinimum, 1u});
}

bool Octant::isTraced(size_t c) const
{
    return std::ranges::equal(block_.traced(c), block_.matters(c));
}

void Octant::drawSamples(uint32_t count, std::span<const uint64_t> eligible,
                         std::span<uint64_t> drawn)
{
    if (params_.replacement)
        weights_.drawWithReplacement(count, eligible, random_, drawn);
    else
        weights_.draw(count, eligible, random_, drawn);
}

void Octant::fetchChecks(size_t c, uint32_t count, std::span<const uint64_t> eligible,
                         Words& checks)
{
    const auto matters = block_.matters(c), traced = block_.traced(c);
    left_.resize(checks.size());
    for (size_t w = 0; w < left_.size(); ++w) left_[w] = eligible[w] & matters[w] & ~traced[w];
    std::ranges::fill(checks, 0);
    drawUniform(count, left_, random_, checks);
    block_.fetch(c, checks);
}

void Octant::raiseRate()
{
    ++stats_.verificationFailures;
    rate_ = std::min(std::max(rate_, double(params_.rowCap)), rate_ + double(params_.rowIncrement));
}

void Octant::fetchAll(size_t c)
{
    block_.fetch(c, tracer_.all());
    noteFull(c);
    if (params_.adaptiveRows) weights_.addRuns(block_.visible(c), block_.matters(c));
}

void Octant::writePrediction(size_t c, std::span<const float> lit)
{
    const auto matters = block_.matters(c), traced = block_.traced(c);
    const auto visible = block_.visible(c);
    writeTraced(c);
    float* numbers =
        out_.coefficients.empty() ? nullptr : &out_.coefficients[size_t(block_.column(c)) * rows_];
    const bool clamped = params_.coefficients == Coefficients::clamped;
    for (uint32_t w = 0; w < visible.size(); ++w) {
        const uint64_t open = matters[w] & ~traced[w];
        const uint32_t first = 64 * w, count = std::min(64u, rows_ - first);
        uint64_t bright = 0;
        for (uint32_t b = 0; b < count; ++b) bright |= uint64_t(lit[first + b] > 0.5f) << b;
        visible[w] |= bright & open;
        if (numbers == nullptr) continue;
        for (uint32_t b = 0; b < count; ++b) {
            const float number = clamped ? std::clamp(lit[first + b], 0.0f, 1.0f) : lit[first + b];
            if (((open >> b) & 1) != 0) numbers[first + b] = number;
        }
    }
}

void Octant::writeTraced(size_t c)
{
    if (out_.coefficients.empty()) return;
    bitsToFloats(block_.visible(c), {&out_.coefficients[size_t(block_.column(c)) * rows_], rows_});
}

void Octant::noteFull(size_t c)
{
    ++stats_.full;
    stats_.authorRays += rows_;
    windowTraced_ += countBits(block_.traced(c));
}

void Octant::noteMatched(size_t c, uint32_t drawn)
{
    ++stats_.matched;
    stats_.authorRays += drawn;
    windowTraced_ += countBits(block_.traced(c));
}

void Octant::noteRepaired(size_t c)
{
    ++stats_.repaired;
    stats_.authorRays += countBits(block_.traced(c));
    windowTraced_ += countBits(block_.traced(c));
}

void Octant::finish(uint32_t basis)
{
    stats_.basis += basis;
    stats_.rated += static_cast<uint32_t>(columns_.size());
    stats_.rates += rate_ * double(columns_.size());
}

}  // namespace core::many_lights
