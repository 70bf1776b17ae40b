// See whole_pairs.h.
#include "core/many_lights/whole_pairs.h"

#include <algorithm>
#include <bit>

#include "core/many_lights/sphere_bound.h"

namespace core::many_lights {

namespace {

using glm::vec3;

constexpr float kAgreeing = 20;  // times what other pairs may err: those whose samples agree
constexpr uint32_t kFirst = 4;   // samples: where these differ, no more are asked
constexpr int kFewest = 4;       // samples that face each other
constexpr float kShared = 0.1f;  // of what a pair may err: lights that one stands for
constexpr size_t kBatch = 256;   // pairs tried together
constexpr size_t kSteps = 4096;  // between looks at whether to stop

}  // namespace

bool mayFace(const PixelNode& p, const LightNode& l, LightKind kind)
{
    constexpr float kFlat = 0.99998f, kRim = 1e-4f;
    if (kind == LightKind::directional) return true;
    const vec3 away = 0.5f * ((l.low + l.high) - (p.low + p.high));
    const vec3 half = 0.5f * ((l.high - l.low) + (p.high - p.low));
    const float rim = kRim * (glm::length(away) + glm::length(half));
    const auto above = [&](const vec3& normal, float side) {
        return side * glm::dot(normal, away) + glm::dot(glm::abs(normal), half) >= rim;
    };
    if (p.query.normal != vec3(0) && p.query.cosHalf >= kFlat && !above(p.query.normal, 1))
        return false;
    return kind != LightKind::surface || l.cosHalf < kFlat || above(l.axis, -1);
}

Agreement agreementOf(uint64_t asked, uint64_t visible, bool fewSuffice)
{
    if (!fewSuffice && std::popcount(asked) < kFewest) return Agreement::none;
    if (visible == asked) return Agreement::visible;
    return visible == 0 ? Agreement::hidden : Agreement::none;
}

bool WholePairs::run(SlicePairs& pairs, const NodeLights& lights, std::span<const float> thresholds,
                     const DarkRows& dark, AcceptedPairs& accepted, Pcg32& random,
                     const std::stop_token& stop)
{
    pairs_ = &pairs;
    lights_ = &lights;
    thresholds_ = thresholds;
    findOutermost(dark);
    tried_.clear();
    tried_.reserve(kBatch);  // words of answers must stay where they are
    packets_.emplace(*pairs.job->receivers.accel, pairs.rows);
    size_t steps = 0;
    for (pairs.pushRoots(); !pairs.waiting.empty() || !tried_.empty();) {
        if (pairs.waiting.empty() || tried_.size() >= kBatch) {
            finishTried(accepted);
            continue;
        }
        const Pair pair = pairs.waiting.back();
        pairs.waiting.pop_back();
        if (++steps % kSteps == 0 && stop.stop_requested()) return false;
        step(pair, accepted, random);
    }
    packets_.reset();
    accepted.finish(pairs);
    return !stop.stop_requested();
}

/// Twice, the darkest row takes a place: a line of points under an edge is at no corner.
void WholePairs::findOutermost(const DarkRows& dark)
{
    outermostRows(pairs_->pixels, pairs_->rows, outermost_);
    for (uint32_t i = 0; i < outermost_.size(); ++i)
        if (!pairs_->pixels.nodes()[i].isLeaf())
            outermost_[i][4] = outermost_[i][6] = dark.darkest(i);
}

void WholePairs::step(const Pair& pair, AcceptedPairs& accepted, Pcg32& random)
{
    const PixelNode& p = pairs_->pixels.nodes()[pair.pixels];
    const LightNode& l = pairs_->tree->nodes[pair.lights];
    if (!mayFace(p, l, pair.kind)) return;
    const bool isLarge = uint64_t(p.rows.size()) * l.count > kSamples;
    if (l.isLeaf() && !isLarge) {
        accepted.add(*pairs_, pair);
        return;
    }
    const float allowed = thresholds_[pair.pixels];
    const float response = pairs_->responseOf(p, pair);
    float most = response * sphereBound(l, pair.kind, p.query.position, p.radius(),
                                        pairs_->job->gather.clampDistance);
    if (!(most <= kAgreeing * allowed)) most = response * pairs_->bound(p, pair);
    if (!(most > 0)) return;
    if (isLarge && most <= kAgreeing * allowed)
        add(pair, most, random);
    else if (l.isLeaf() || most <= allowed)
        accepted.add(*pairs_, pair);
    else
        split(pair);
}

void WholePairs::split(const Pair& pair)
{
    const PixelNode& p = pairs_->pixels.nodes()[pair.pixels];
    const LightNode& l = pairs_->tree->nodes[pair.lights];
    if (p.isLeaf() || pair.kind == LightKind::directional ||
        sphereRadius(l, pair.kind) >= p.radius())
        pairs_->splitLights(pair);
    else
        pairs_->splitPixels(pair);
}

void WholePairs::add(const Pair& pair, float most, Pcg32& random)
{
    Tried& tried = tried_.emplace_back(Tried{pair, most, kFirst, 0, 0, {}});
    samplePair(pairs_->pixels.nodes()[pair.pixels], outermost_[pair.pixels],
               pairs_->tree->nodes[pair.lights], pair.lights, *lights_, random, tried.samples);
    ask(tried, 0, kFirst);
}

void WholePairs::ask(Tried& tried, uint32_t begin, uint32_t end)
{
    const SliceJob& job = *pairs_->job;
    for (uint32_t k = begin; k < end; ++k) {
        const auto [row, light] = tried.samples[k];
        const Column column = columnOf(job.lights->lights[light], 1, light, job.receivers.frame);
        pairs_->rows.weigh(column, job.gather, {row, row + 1}, pairs_->weights);
        if (!(pairs_->weights[row] > 0)) continue;
        tried.asked |= uint64_t(1) << k;
        packets_->add(ShadowTarget(column), row, &tried.visible, uint64_t(1) << k);
        ++pairs_->rays;
    }
}

void WholePairs::finishTried(AcceptedPairs& accepted)
{
    packets_->flush();
    for (Tried& t : tried_) {
        if (t.visible != 0 && t.visible != t.asked) continue;
        ask(t, kFirst, kSamples);
        t.count = kSamples;
    }
    packets_->flush();
    for (const Tried& t : tried_) {
        // Much of what a bound allows for is behind a horizon, as the samples tell.
        const float facing =
            static_cast<float>(std::popcount(t.asked)) / static_cast<float>(t.count);
        const bool isSmall = t.most * facing <= thresholds_[t.pair.pixels];
        switch (agreementOf(t.asked, t.visible, isSmall)) {
        case Agreement::visible:
            shade(t.pair);
            break;
        case Agreement::hidden:
            break;
        case Agreement::none:
            if (isSmall || pairs_->tree->nodes[t.pair.lights].isLeaf())
                accepted.add(*pairs_, t.pair);
            else
                split(t.pair);
            break;
        }
    }
    tried_.clear();
}

/// Light of a pair of which everything sees everything.
void WholePairs::shade(const Pair& pair)
{
    const PixelNode& p = pairs_->pixels.nodes()[pair.pixels];
    const float allowed = kShared * thresholds_[pair.pixels];
    const float response = pairs_->responseOf(p, pair);
    const uint32_t end = pair.lights + 2 * pairs_->tree->nodes[pair.lights].count - 1;
    for (uint32_t i = pair.lights; i < end;) {
        const LightNode& l = pairs_->tree->nodes[i];
        const bool isSmall =
            l.isLeaf() || response * sphereBound(l, pair.kind, p.query.position, p.radius(),
                                                 pairs_->job->gather.clampDistance) <=
                              allowed;
        if (!isSmall) {
            ++i;
            continue;
        }
        const Column column = pairs_->representative(l);
        pairs_->entries += p.rows.size();
        pairs_->rows.weigh(column, pairs_->job->gather, p.rows, pairs_->weights);
        pairs_->rows.add(column, *pairs_->job->lights, p.rows, pairs_->weights);
        i += 2 * l.count - 1;
    }
}

}  // namespace core::many_lights
