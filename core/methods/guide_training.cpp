#include "core/methods/guide_training.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/check.h"
#include "core/base/time.h"
#include "core/guiding/lesson.h"
#include "core/guiding/pixel_estimates.h"
#include "core/image/metrics.h"

namespace core {

namespace {

// Recorded paths of a pass: learning from more than the second number would be felt as a hitch;
// with fewer than the first, guides are starved (a door left ajar, 192x108, 64 samples: twice the
// error with one path in four).
constexpr uint64_t kFewPaths = 1u << 14, kMostPaths = 1u << 17;
// Recorded paths of a pass while nobody else follows the guide: with half as many a pass costs
// less, but three times as many passes go by until they tell whether it pays. One in eight costs
// little.
constexpr uint64_t kTriedPaths = 1u << 13;
constexpr uint32_t kTriedStride = 8;
// And those of the first sample of a view that follows on others; where the guide has learnt from
// so many samples of these, also when all follow it: while the camera moves all samples are the
// first of their views, and learning from all paths of each takes longer than they do.
constexpr uint64_t kPathsOfMove = 1u << 12;
constexpr double kSamplesOfOthers = 16;
// Lessons after which directions are known and tested, and the guide can be tried.
constexpr uint32_t kLessonsBeforeTrial = 2;
// In a view that begins where the guide did not pay before, it is tried again after so many
// samples, or half way through a shorter training. Views may be shorter than that while the camera
// moves: the next one begins with a trial after so many samples in all, then twice as many.
constexpr uint64_t kTriedAgain = 8, kMostPatience = 512;
// How many times less error^2 times cost the paths must promise for the guide to pay. A guide that
// is not there yet gets better with every lesson: it is followed at once where it promises much,
// and has a number of samples to promise enough. What falls behind what rooms promise that gain by
// it is given up: recorded paths cost half as much again as plain ones. After three to eight
// samples of 20,000 pixels, of which every other one is recorded, rooms that gain and a glossy box
// (kitchen, sponza; four seeds, both devices) promise at least 1.06, 1.13, 1.17, 1.20, 1.25 and
// 1.25; others at most 1.01, 1.05, 1.02, 1.04, 1.06 and 1.09 (bathroom, white room), 1.11, 1.13,
// 1.11, 1.10, 1.11 and 1.12 (modern hall), 1.14, 1.15, 1.16, 1.18, 1.20 and 1.19 (staircase).
// Followed by all paths a guide learns from more of them and promises 1.4 to 1.6 soon, of which it
// keeps 1.5. With more pixels all promise more: the staircase (360x640) 1.2 to 1.3 after four to
// eight samples; with 240x426 it kept 1.2.
constexpr double kMuchGain = 1.6, kEnoughGain = 1.22, kLittleGain = 0.8;
// In smaller pictures that many recorded paths take more samples, up to twice as many.
constexpr uint64_t kSamplesOfProof = 8, kMostSamplesOfProof = 16;
constexpr std::array kHopes{kLittleGain, kLittleGain, kLittleGain, 1.0,        1.09,
                            1.14,        1.17,        1.2,         kEnoughGain};
// A trial that is not the first has so many lessons.
constexpr uint32_t kLessonsOfTrial = 6;
// While the camera moves nothing is known of pixels, and lessons are of single samples: a guide
// gets there more slowly, and learns all the time, which is in no cost. After twelve lessons rooms
// and a glossy box promise 1.15 to 1.6, a box of diffuse walls 1 to 1.1. What has been given up
// must promise more, so that it is not taken up again and again.
constexpr uint32_t kLessonsOfMovingTrial = 12;
constexpr double kMovingGain = 1.15, kGainOfReturn = 1.3;
constexpr double kLeastWeight = 0.02;  // of the samples before
constexpr uint32_t kMostStride = 64;   // a tile of the device has as many paths
// Recorded paths wait for their lesson, at some 370 bytes each; iterations of practical path
// guiding are as long as all that came before.
constexpr uint64_t kMostPathsOfLesson = 1u << 21;

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

/// Samples from lesson to lesson, steadily.
uint64_t stepAt(uint64_t samples)
{
    return std::max<uint64_t>(std::bit_floor(std::max<uint64_t>(samples, 1)) / 4, 1);
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

uint32_t guideKindOf(const GuidedParams& params)
{
    return params.training > 0 ? kindOf(params.guide) : 0;
}

uint32_t neeOf(const GuidedParams& params)
{
    return params.nee == GuidedNee::mixture ? shared::kNeeMixture : shared::kNeeBsdf;
}

guiding::GuideBox guideBox(const World& world)
{
    const glm::vec3 size = world.boundsHigh - world.boundsLow;
    return {world.boundsLow, std::max({size.x, size.y, size.z})};
}

void GuideTraining::beginScene(const guiding::PathCosts& costs, const guiding::GuideBox& box)
{
    costs_ = costs;
    box_ = box;
    makeGuide();
}

void GuideTraining::makeGuide()
{
    guide_ = guiding::Guide(optionsOf(params_, box_));
    trial_ = {};
    convergence_ = {};
    state_ = params_.use == GuideUse::always ? State::pays : State::looksOn;
    lessons_ = 0;
    rested_ = 0;
    patience_ = kTriedAgain;
    estimates_.clear();
    views_ = 0;
    allSamples_ = 0;
    viewSamples_ = 0;
    seconds_ = 0;
}

void GuideTraining::begin(const GuidedParams& params, glm::uvec2 size, Start start)
{
    const bool same = params_ == params;
    params_ = params;
    if (start == Start::anew || !same) makeGuide();
    if (allSamples_ > 0) ++views_;
    if (state_ == State::doesNotPay && rested_ >= patience_) tryAgain();
    pixels_ = uint64_t(size.x) * size.y;
    firstStride_ = firstStride(params_, pixels_);
    viewSamples_ = viewPaths_ = 0;
    isTried_ = false;
    discount_ = 0;
    convergence_.begin();
    estimates_.clear();
    pictures_.begin(params_);
}

uint32_t GuideTraining::seed() const
{
    return views_ == 0 ? params_.seed : shared::pcg4d({params_.seed, views_, 0, 0}).x;
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
    constexpr uint64_t kNever = std::numeric_limits<uint64_t>::max();
    if (samples >= trainingEnd()) return kNever;
    if (state_ == State::doesNotPay) {
        const uint64_t again = std::min(kTriedAgain, trainingEnd() / 2);
        const uint64_t next = std::max(samples + 1, again);
        return isTried_ || next >= trainingEnd() ? kNever : next;
    }
    if (params_.schedule == GuideSchedule::doubling) return 2 * std::bit_floor(samples + 1) - 1;
    const uint64_t step = stepAt(samples);
    return std::min<uint64_t>((samples / step + 1) * step, params_.training);
}

/// The samples of the view at which the lesson that `samples` belong to begins, where there is a
/// next one.
uint64_t GuideTraining::lastLesson(uint64_t samples) const
{
    if (params_.schedule == GuideSchedule::doubling) return std::bit_floor(samples + 1) - 1;
    const uint64_t step = stepAt(samples);
    return samples / step * step;
}

/// Recorded paths of a pixel between two lessons, of which the first is at `samples`.
double GuideTraining::recordsAfter(uint64_t samples) const
{
    const uint64_t next = nextLesson(samples);
    const uint32_t stride = strideAfter(samples);
    if (stride == 0 || next == std::numeric_limits<uint64_t>::max()) return 0;
    return double(next - samples) / stride;
}

/// Who follows the guide now, as kernels are told.
uint32_t GuideTraining::followers() const
{
    if (state_ == State::pays) return shared::kGuideForAll;
    return state_ == State::tries ? shared::kGuideForRecorded : shared::kGuideForNone;
}

uint32_t GuideTraining::rulesAfter(uint64_t samples) const
{
    // Without roulette the first paths, which know nothing, would be the longest.
    const bool knows = params_.roulette != GuidedRoulette::none || allSamples_ > 0;
    return shared::packGuidedRules(strideAfter(samples),
                                   knows ? uint32_t(params_.roulette) : shared::kRouletteAlbedo,
                                   neeOf(params_), followers());
}

/// One path in so many is recorded; 0: none any more.
uint32_t GuideTraining::strideAfter(uint64_t samples) const
{
    if (samples >= trainingEnd() || state_ == State::doesNotPay) return 0;
    const uint64_t first = lastLesson(samples);
    uint32_t stride = wantedStride(first);  // the same up to the next lesson, whatever the pieces
    const uint64_t passes = nextLesson(samples) - first;
    while (stride < kMostStride && passes * (pixels_ / stride) > kMostPathsOfLesson) stride *= 2;
    return std::min(stride, kMostStride);
}

/// The same, as far as passes alone decide. At first every path is wanted, later fewer do, for
/// recording and learning cost a fifth of a path.
uint32_t GuideTraining::wantedStride(uint64_t samples) const
{
    if (params_.recordOneIn > 0) return firstStride_;
    uint32_t stride = firstStride_;
    const bool moves = samples == 0 && allSamples_ >= kSamplesOfOthers;
    if (state_ != State::pays || moves) {
        const auto areMany = [&](uint64_t least) { return pixels_ / stride >= 2 * least; };
        const uint64_t least = samples == 0 && views_ > 0 ? kPathsOfMove : kTriedPaths;
        while (stride < kMostStride && areMany(least) &&
               (moves || stride < kTriedStride || areMany(kFewPaths)))
            stride *= 2;
        return stride;
    }
    for (const uint64_t from : {4u, 8u})
        if (samples >= from && pixels_ / stride >= 2 * kFewPaths) stride *= 2;
    return stride;
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
        if (state_ == State::doesNotPay) rested_ += has - had;
        if (has == pause && pictures_.takesNotes()) pictures_.note(film(), has == lesson);
        if (has == lesson) learn(has);
        if (discount_ > 0) pictures_.discount(film(), std::exchange(discount_, 0));
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
    const double taken = double(samples - viewSamples_);
    if (state_ == (samples <= 2 ? State::looksOn : State::tries))
        convergence_.note(samples, mean.pixels, mean.width, estimates_, strideAfter(viewSamples_),
                          kRelMseFloor);
    if (state_ == State::doesNotPay) {
        tryAgain();  // from the next sample on; nothing has been recorded
        viewSamples_ = samples;
    } else {
        for (const guiding::PathRecords& part : parts) viewPaths_ += part.ends.size();
        const std::vector<guiding::Lesson> lessons = guide_.lessonsOf(parts);
        tryOut(parts, lessons, allSamples_ / (allSamples_ + taken));
        allSamples_ += taken;
        guide_.learn(lessons, allSamples_, recordsAfter(samples) / recordsAfter(viewSamples_));
        viewSamples_ = samples;
        ++lessons_;
        decide();
    }
    estimates_ = guiding::pixelEstimates(mean.pixels, mean.width, mean.height);
    const bool isLast = nextLesson(samples) == std::numeric_limits<uint64_t>::max();
    for (guiding::PathRecords& part : parts) {
        if (isLast)
            part = {};  // with its memory
        else
            part.clear();
    }
    seconds_ += secondsSince(start);
}

/// What the guide would save, as far as is known.
double GuideTraining::gain() const
{
    return trial_.gain(costs_) * convergence_.factor();
}

/// From now on all paths follow the guide. Those before were noisier: the recorded paths say by how
/// much, which have little part in what is told to count less.
void GuideTraining::beginToPay()
{
    if (state_ == State::pays) return;
    state_ = State::pays;
    const double noise = trial_.guided().variance / trial_.plain().variance;
    discount_ = std::clamp(noise, kLeastWeight, 1.0);
}

/// Recorded paths follow the guide from now on.
void GuideTraining::beginTrial()
{
    state_ = State::tries;
    trial_ = {};
    lessonsOfTrial_ = 0;
}

void GuideTraining::tryAgain()
{
    beginTrial();
    rested_ = 0;
    patience_ = std::min(2 * patience_, kMostPatience);
}

/// How many samples the view has had, as far as they tell whether the guide pays.
uint64_t GuideTraining::proofOfView() const
{
    const uint64_t byPaths =
        std::max(viewPaths_ / kTriedPaths, viewSamples_ * kSamplesOfProof / kMostSamplesOfProof);
    return std::min({viewSamples_, byPaths, kSamplesOfProof});
}

/// Who follows the guide from the next sample on.
void GuideTraining::decide()
{
    if (params_.use == GuideUse::always) return;
    const bool isOver = viewSamples_ >= trainingEnd();
    if (state_ == State::looksOn) {
        if (isOver) state_ = State::pays;  // what little there is has a gate at every leaf
        if (lessons_ < kLessonsBeforeTrial || isOver) return;
        beginTrial();
    } else if (trial_.paths() > 0) {
        const bool isFirst = ++lessonsOfTrial_ == 1;
        const bool moves = viewSamples_ == 1, again = patience_ > kTriedAgain;
        const uint32_t lessons = moves && !again ? kLessonsOfMovingTrial : kLessonsOfTrial;
        const bool proves = !moves && !again;
        const uint64_t proof = proofOfView();
        const bool isLast =
            isOver || (proves ? proof == kSamplesOfProof : lessonsOfTrial_ >= lessons);
        double enough = kEnoughGain;
        if (moves)
            enough = again ? kGainOfReturn : kMovingGain;
        else if (again)
            enough = kMuchGain;
        const double least = isLast ? enough : proves ? kHopes[proof] : kLittleGain;
        const bool early = (isFirst || moves) && !isLast;
        if (gain() < least)
            state_ = State::doesNotPay;
        else if (gain() > (early ? kMuchGain : enough))
            beginToPay();
        isTried_ = state_ != State::tries;
    }
}

void GuideTraining::tryOut(std::span<const guiding::PathRecords> parts,
                           std::span<const guiding::Lesson> lessons, double decay)
{
    const guiding::TrialRules rules{params_.rouletteDepth, uint32_t(params_.roulette),
                                    state_ == State::looksOn, kRelMseFloor};
    trial_.add(parts, lessons, *guide_.tables(), rules, decay * decay);
}

std::string_view GuideTraining::stateName() const
{
    switch (state_) {
    case State::looksOn:
        return "looks on";
    case State::tries:
        return "is tried";
    case State::pays:
        return params_.use == GuideUse::always ? "always" : "pays";
    case State::doesNotPay:
        break;
    }
    return "does not pay here";
}

std::vector<StatsDetail> GuideTraining::details() const
{
    if (!isOn()) return {};
    const guiding::GuideFigures& figures = guide_.figures();
    return {{"guide_leaves", double(figures.leaves)},
            {"guide_bytes", double(figures.bytes)},
            {"guide_records", figures.records},
            {"guided_share", figures.guidedShare},
            {"guide_gain", gain()},
            {"guiding", std::string(stateName())},
            {"guide_seconds", seconds_}};
}

}  // namespace core
