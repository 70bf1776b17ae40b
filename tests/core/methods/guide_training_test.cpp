// When the guide learns and from how many paths: what waits for a lesson is bounded, whatever the
// size of the picture and the schedule.
#include "core/methods/guide_training.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace {

using core::GuidedParams, core::GuideSchedule, core::GuideTraining;

uint32_t strideOf(const GuideTraining& training, uint64_t samples)
{
    shared::PathSettings settings{};
    settings.guidedRules = training.rulesAfter(samples);
    return shared::recordStride(settings);
}

TEST(GuideTraining, WhatWaitsForALessonIsBounded)
{
    for (const uint32_t oneIn : {0u, 1u, 4u})
        for (const uint32_t side : {64u, 256u, 1024u, 2048u, 8192u}) {
            GuideTraining training;
            training.beginScene({}, {});
            GuidedParams params;
            params.use = core::GuideUse::always;
            params.schedule = GuideSchedule::doubling;
            params.training = 1023;
            params.recordOneIn = oneIn;
            training.begin(params, {side, side}, core::Start::anew);
            const uint64_t pixels = uint64_t(side) * side;
            uint64_t begin = 0;
            for (uint64_t end = 1; end <= 1023; begin = end, end = 2 * end + 1) {
                SCOPED_TRACE(std::to_string(side) + " pixels, samples to " + std::to_string(end));
                const uint32_t first = strideOf(training, begin);
                ASSERT_GE(first, std::max(oneIn, 1u));
                uint64_t paths = 0;
                for (uint64_t s = begin; s < end; ++s) paths += pixels / strideOf(training, s);
                if (first < 64) {
                    EXPECT_LE(paths, 1u << 21);
                }
                if (oneIn > 0 && first > oneIn) {
                    EXPECT_GT(2 * paths, 1u << 21) << "no fewer than that";
                }
            }
            EXPECT_EQ(strideOf(training, 1023), 0u);
        }
}

/// A view may pause after any sample: which paths are recorded up to the next lesson does not
/// depend on it.
TEST(GuideTraining, RulesChangeWithLessonsOnly)
{
    GuideTraining training;
    training.beginScene({}, {});
    GuidedParams params;
    params.use = core::GuideUse::always;
    params.schedule = GuideSchedule::doubling;
    training.begin(params, {256, 256}, core::Start::anew);
    uint64_t begin = 0;
    for (uint64_t end = 1; end <= 31; begin = end, end = 2 * end + 1)
        for (uint64_t s = begin; s < end; ++s)
            EXPECT_EQ(training.rulesAfter(s), training.rulesAfter(begin)) << s;
    EXPECT_EQ(strideOf(training, 0), 1u);
    EXPECT_EQ(strideOf(training, 15), 4u);
}

}  // namespace
