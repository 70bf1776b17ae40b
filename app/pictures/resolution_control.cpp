// instant-ngp scales its resolution by the root of time over target; here the sizes are few, so
// that buffers are used again, and the estimate follows slow pictures at once and quick ones by
// halves.
#include "app/pictures/resolution_control.h"

#include <algorithm>
#include <cmath>

namespace app {

namespace {

constexpr double kRoomForFiner = 0.7;  // of the target: a finer step has to leave the rest
constexpr float kSmallest = 0.25f, kSmallestLight = 0.088f;
// Where samples are kept. Sides are less than an eighth only where a picture of that size takes
// kPatience times as long as asked for: as quick, smaller ones show more error (staircase in
// 640x360 at a sixteenth: a tenth more), but a hand waits for the slow ones.
constexpr float kSmallKept = 0.125f, kSmallestKept = 0.088f;
constexpr double kPatience = 2.5;

/// Work of a path of at most `depth` events in units of its first ray: each event adds a ray and a
/// connection, and fewer paths reach each. It only has to be good enough for a first guess at
/// another depth.
double workOf(uint32_t depth)
{
    constexpr double kSurvival = 0.8;
    return 1 + 1.5 * (1 - std::pow(kSurvival, depth)) / (1 - kSurvival);
}

glm::uvec2 scaled(glm::uvec2 full, float scale)
{
    return glm::max(glm::uvec2(glm::round(glm::vec2(full) * scale)), glm::uvec2(1));
}

}  // namespace

void ResolutionControl::observe(double pixels, uint32_t depth, double seconds, bool preview)
{
    if (pixels <= 0 || seconds <= 0 || (fromPreview_ && !preview)) return;
    const double now = seconds / (pixels * workOf(depth));
    const bool follow = !fromPreview_ || now > secondsPerWork_;
    secondsPerWork_ = follow ? now : 0.5 * (now + secondsPerWork_);
    fromPreview_ = preview;
}

double ResolutionControl::predict(double pixels, uint32_t depth) const
{
    return secondsPerWork_ * pixels * workOf(depth);
}

std::vector<ResolutionControl::Step> ResolutionControl::steps(uint32_t depth, PreviewRules rules)
{
    std::vector<Step> steps;
    const float smallest = rules.keepsDepth  ? kSmallestKept
                           : rules.fineEdges ? kSmallestLight
                                             : kSmallest;
    for (int halves = 0; halves <= 7; ++halves) {
        const float scale = std::exp2(-0.5f * static_cast<float>(halves));
        if (scale >= 0.99f * smallest) steps.push_back({scale, depth});
    }
    if (!rules.keepsDepth)
        for (uint32_t d = depth; d > 1;) steps.push_back({smallest, --d});
    return steps;
}

PreviewSize ResolutionControl::choose(glm::uvec2 full, uint32_t depth, double targetSeconds,
                                      PreviewRules rules)
{
    const std::vector<Step> all = steps(depth, rules);
    const auto picture = [&](size_t i) {
        return PreviewSize{scaled(full, all[i].scale), all[i].scale, all[i].depth};
    };
    const auto expected = [&](size_t i) {
        const PreviewSize p = picture(i);
        return predict(double(p.size.x) * p.size.y, p.depth);
    };
    const auto most = [&](size_t i) {
        const bool small = rules.keepsDepth && all[i].scale < 1.01f * kSmallKept;
        return small ? kPatience * targetSeconds : targetSeconds;
    };
    size_t wanted = 4;  // a quarter
    last_ = std::min(last_, all.size() - 1);
    if (secondsPerWork_ > 0) {
        wanted = 0;
        while (wanted + 1 < all.size() && expected(wanted) > most(wanted)) ++wanted;
        if (depth == lastDepth_ && rules == lastRules_) {
            while (wanted < last_ && expected(wanted) > kRoomForFiner * most(wanted)) ++wanted;
        }
    }
    last_ = wanted;
    lastDepth_ = depth;
    lastRules_ = rules;
    return picture(wanted);
}

}  // namespace app
