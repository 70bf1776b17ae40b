#include "core/methods/guide_training.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

#include "core/base/check.h"
#include "core/base/time.h"
#include "core/guiding/pixel_estimates.h"

namespace core {

namespace {

// Recorded paths of a pass: learning from more than the second number would be felt as a hitch;
// with fewer than the first, guides are starved (a door left ajar, 192x108, 64 samples: twice the
// error with one path in four).
constexpr uint64_t kFewPaths = 1u << 14, kMostPaths = 1u << 17;
constexpr uint32_t kMostStride = 64;  // a tile of the device has as many paths

uint32_t kindOf(GuideKind kind)
{
    constexpr std::array kKinds{shared::kGuideHistogram, shared::kGuideLobes, shared::kGuideTree};
    return kKinds[size_t(kind)];
}

guiding::GuideOptions optionsOf(const GuidedParams& params, const guiding::GuideBox& box)
{
    guiding::GuideOptions options;
    options.kind = kindOf(params.guide);
    options.leastShare = guiding::leastShareOf(options.kind);
    options.recordsPerLeaf = params.recordsPerLeaf;
    options.gate = params.gate;
    options.fixedShare = params.share;
    options.shareBy = params.shareBy;
    options.space = params.space;
    options.target = params.target;
    options.memory = params.memory;
    options.filter = params.filter;
    options.depth = params.depth;
    options.box = box;
    return options;
}

/// One path in so many, in the first samples of a view.
uint32_t firstStride(const GuidedParams& params, uint64_t pixels)
{
    if (params.recordOneIn > 0) return std::bit_floor(params.recordOneIn);
    uint32_t stride = 1;
    while (stride < kMostStride && pixels / stride > kMostPaths) stride *= 2;
    return stride;
}

}  // namespace

guiding::GuideBox guideBox(const World& world)
{
    const glm::vec3 size = world.boundsHigh - world.boundsLow;
    return {world.boundsLow, std::max({size.x, size.y, size.z})};
}

void GuideTraining::forget(const guiding::GuideBox& box)
{
    box_ = box;
    makeGuide();
}

void GuideTraining::makeGuide()
{
    guide_ = guiding::Guide(optionsOf(params_, box_));
    estimates_.clear();
    allSamples_ = 0;
    viewSamples_ = 0;
    seconds_ = 0;
}

void GuideTraining::begin(const GuidedParams& params, glm::uvec2 size, Start start)
{
    const bool same = params_ == params;
    params_ = params;
    if (start == Start::anew || !same) makeGuide();
    pixels_ = uint64_t(size.x) * size.y;
    firstStride_ = firstStride(params_, pixels_);
    viewSamples_ = 0;
    estimates_.clear();
    pictures_.begin(params_);
}

/// The samples of the view after which the guide learns for the last time.
uint64_t GuideTraining::trainingEnd() const
{
    if (params_.schedule == GuideSchedule::steady) return params_.training;
    return std::bit_floor(uint64_t(params_.training) + 1) - 1;
}

/// The samples of the view, more than `samples`, after which the guide learns next; the largest
/// number when it does not any more. After every sample at first, from eight on four times until
/// they have doubled: each time costs some milliseconds.
uint64_t GuideTraining::nextLesson(uint64_t samples) const
{
    if (samples >= trainingEnd()) return std::numeric_limits<uint64_t>::max();
    if (params_.schedule == GuideSchedule::doubling) return 2 * std::bit_floor(samples + 1) - 1;
    const uint64_t step = std::max<uint64_t>(std::bit_floor(std::max<uint64_t>(samples, 1)) / 4, 1);
    return std::min<uint64_t>((samples / step + 1) * step, params_.training);
}

/// Recorded paths of a pixel between two lessons, of which the first is at `samples`.
double GuideTraining::recordsAfter(uint64_t samples) const
{
    const uint64_t next = nextLesson(samples);
    const uint32_t stride = strideAfter(samples);
    if (stride == 0 || next == std::numeric_limits<uint64_t>::max()) return 0;
    return double(next - samples) / stride;
}

uint32_t GuideTraining::rulesAfter(uint64_t samples) const
{
    // Without roulette the first paths, which know nothing, would be the longest.
    const bool knows = params_.roulette != GuidedRoulette::none || allSamples_ > 0;
    return shared::packGuidedRules(
        strideAfter(samples), knows ? uint32_t(params_.roulette) : shared::kRouletteAlbedo,
        params_.nee == GuidedNee::mixture ? shared::kNeeMixture : shared::kNeeBsdf);
}

/// One path in so many is recorded; 0: none any more. At first every path is wanted, later fewer
/// do, for recording and learning cost a fifth of a path.
uint32_t GuideTraining::strideAfter(uint64_t samples) const
{
    if (samples >= trainingEnd()) return 0;
    if (params_.recordOneIn > 0) return firstStride_;
    uint32_t stride = firstStride_;
    for (const uint64_t from : {4u, 8u})
        if (samples >= from && pixels_ / stride >= 2 * kFewPaths) stride *= 2;
    return std::min(stride, kMostStride);
}

void GuideTraining::advance(const Budget& budget, const std::stop_token& stop,
                            const std::function<uint64_t()>& samples,
                            const std::function<void(const Budget&)>& render,
                            const std::function<void(uint64_t)>& learn,
                            const std::function<Estimate()>& film)
{
    const auto start = Clock::now();
    const uint64_t end = samples() + budget.samples;
    for (;;) {
        const uint64_t had = samples();
        const uint64_t lesson = nextLesson(had), pause = std::min(lesson, pictures_.nextPart(had));
        const auto most = static_cast<uint32_t>(std::min(pause, std::max(end, had)) - had);
        render({most, std::max(budget.seconds - secondsSince(start), 0.0)});
        const uint64_t has = samples();
        if (has == pause && pictures_.isOn()) pictures_.note(film(), has == lesson);
        if (has == lesson) learn(has);
        if (has == had || has >= end || stop.stop_requested() ||
            secondsSince(start) >= budget.seconds)
            return;
    }
}

void GuideTraining::learn(std::span<guiding::PathRecords> parts, uint64_t samples,
                          const Image& mean)
{
    CHECK(samples > viewSamples_);
    const auto start = Clock::now();
    allSamples_ += double(samples - viewSamples_);
    const double comes = recordsAfter(samples) / recordsAfter(viewSamples_);
    viewSamples_ = samples;
    guide_.learn(parts, allSamples_, comes);
    estimates_ = guiding::pixelEstimates(mean.pixels, mean.width, mean.height);
    for (guiding::PathRecords& part : parts) part.clear();
    seconds_ += secondsSince(start);
}

std::vector<StatsDetail> GuideTraining::details() const
{
    if (!isOn()) return {};
    const guiding::GuideFigures& figures = guide_.figures();
    return {{"guide_leaves", double(figures.leaves)},
            {"guide_bytes", double(figures.bytes)},
            {"guide_records", figures.records},
            {"guided_share", figures.guidedShare},
            {"guide_seconds", seconds_}};
}

}  // namespace core
