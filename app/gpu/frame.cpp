// A uniform buffer and a buffer of counters.
#include "app/gpu/frame.h"

namespace gpu {

Frame::Frame(Device& device, const SharedLayouts& layouts)
    : uniforms_(device, "the frame's settings", sizeof(shared::FrameData)),
      counters_(device, "the counters", sizeof(shared::Counters)), set_(device, layouts.frame)
{
    set_.bind(shared::kBindFrame, uniforms_);
    set_.bind(shared::kBindCounters, counters_);
    clearCounters();
}

void Frame::write(const shared::FrameData& data)
{
    data_ = data;
    uniforms_.write(std::as_bytes(std::span(&data_, 1)));
}

void Frame::drainCounters(FrameCounts& counts)
{
    const shared::Counters found = counters();
    clearCounters();
    counts.film.nan += found.nan;
    counts.film.inf += found.inf;
    counts.film.negative += found.negative;
    counts.film.stackOverflow += found.cutRays;
    counts.rays += uint64_t(found.closestRays) + found.shadowRays;
    counts.reuse.scatters += found.scatters;
    counts.reuse.withHistory += found.withHistory;
    counts.reuse.weights += found.weightSum / double(shared::kCountedUnit);
    counts.reuse.paths += found.newPaths;
    counts.reuse.asked += found.asked;
    counts.reuse.leaked += found.leaked / double(shared::kCountedBias);
    counts.reuse.lost += found.lost / double(shared::kCountedBias);
    counts.reuse.shares += found.shareSum / double(shared::kCountedUnit);
    for (size_t i = 0; i < shared::kDeviationBins; ++i)
        counts.reuse.deviations[i] += found.deviations[i];
}

shared::Counters Frame::counters() const
{
    shared::Counters found;
    counters_.read(std::as_writable_bytes(std::span(&found, 1)));
    return found;
}

void Frame::setCounters(const shared::Counters& counters)
{
    counters_.write(std::as_bytes(std::span(&counters, 1)));
}

}  // namespace gpu
