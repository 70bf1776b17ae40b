// The estimators over directions, in single precision and with colours: visible normals of GGX seen
// from two places, as when a camera moves past a glossy surface.
#include <cmath>

#include <gtest/gtest.h>

#include "core/reuse/history.h"
#include "shared/microfacet.h"
#include "shared/warp.h"
#include "stats.h"

namespace {

using namespace core::reuse;
using core::Pcg32;
using glm::vec3;

constexpr float kAlpha = 0.2f;

vec3 direction(float degrees)
{
    const float angle = glm::radians(degrees);
    return {std::sin(angle), 0, std::cos(angle)};
}

/// Below the horizon directions keep their density, as they are drawn, and have no light: then the
/// density integrates to one and the mean of the weights is known.
struct GlossyChange {
    using Point = vec3;
    using Real = float;
    using Value = vec3;

    vec3 oldWo, newWo;

    static float density(vec3 wo, vec3 wi)
    {
        return wo.z + wi.z > 0 ? shared::reflectFacet(wo, wi, kAlpha, 1).pdf : 0;
    }
    float q(vec3 wi) const { return density(oldWo, wi); }
    float p(vec3 wi) const { return density(newWo, wi); }
    vec3 f(vec3 wi) const
    {
        if (!(wi.z > 0)) return vec3(0);
        const vec3 radiance(1 + wi.x, 1 + std::sin(9 * wi.y), wi.x < -0.6f ? 4 : 1);
        return radiance * (shared::reflectFacet(newWo, wi, kAlpha, 1).value * wi.z);
    }
    template <class Random> vec3 sampleFor(vec3 wo, Random& random) const
    {
        const glm::vec2 xi(uniform<float>(random), uniform<float>(random));
        const float radius = std::sqrt(xi.x), angle = 2 * shared::kPi * xi.y;
        const glm::vec2 disk(radius * std::cos(angle), radius * std::sin(angle));
        return shared::mirrorAbout(wo, shared::visibleNormal(wo, kAlpha, 1, disk));
    }
    template <class Random> vec3 sampleP(Random& random) const { return sampleFor(newWo, random); }
};
static_assert(Change<GlossyChange>);

struct Colours {
    std::array<tests::Moments, 3> channel;
    tests::Moments weight;

    void add(vec3 value, double weightSum)
    {
        for (int i = 0; i < 3; ++i) channel[static_cast<size_t>(i)].add(value[i]);
        weight.add(weightSum);
    }
};

void expectSameMeans(const Colours& a, const Colours& b, double detectable)
{
    for (size_t i = 0; i < 3; ++i) {
        const tests::Comparison c = tests::welch(a.channel[i], b.channel[i]);
        EXPECT_LT(std::abs(c.z), tests::kScore) << i;
        EXPECT_LT(c.detectable, detectable) << "the test could not see a bias of this size";
    }
}

constexpr int kTrials = 100000;

Colours freshOnly(const GlossyChange& change)
{
    Colours found;
    Pcg32 random(1, 1);
    for (int i = 0; i < 4 * kTrials; ++i) {
        EstimateOf<GlossyChange> e;
        for (int j = 0; j < 4; ++j) trace(e, change, drawFresh(e, change, 4, random));
        found.add(e.value, e.weightSum);
    }
    return found;
}

TEST(ReuseDirections, MovedEyeSeesTheSameMeanWithLessVariance)
{
    for (const float step : {1.0f, 8.0f, 40.0f}) {
        const GlossyChange change{direction(45), direction(45 + step)};
        const Colours truth = freshOnly(change);
        Colours found, corrected;
        Pcg32 random(2, 1), candidates(2, 2), selection(2, 3), batch(2, 4);
        const vec3 beta(static_cast<float>(truth.channel[0].mean()),
                        static_cast<float>(truth.channel[1].mean()),
                        static_cast<float>(truth.channel[2].mean()));
        for (int i = 0; i < kTrials; ++i) {
            std::array<vec3, 8> old;
            for (vec3& x : old) x = change.sampleFor(change.oldWo, random);
            const float c = solveCFromCandidates(change, 8.0f, 4, 8, batch);
            const auto e =
                reweightingAugmentation(change, std::span<const vec3>(old), 8.0f, 4, 4,
                                        MinimumFraction<float>{c}, candidates, selection);
            ASSERT_EQ(e.faults, 0u);
            found.add(e.value, e.weightSum);
            corrected.add(e.corrected(beta), e.weightSum);
        }
        expectSameMeans(found, truth, 0.02);
        expectSameMeans(corrected, truth, 0.02);
        EXPECT_LT(std::abs(tests::againstExact(found.weight, 1).z), tests::kScore) << step;
        // One degree changes next to nothing: three times as many samples, a third of the variance.
        const double gain = truth.channel[0].variance() / corrected.channel[0].variance();
        if (step == 1.0f) {
            EXPECT_GT(gain, 2.6);
            EXPECT_LT(gain, 3.2);
        } else {
            EXPECT_GT(gain, 1) << step;
        }
    }
}

TEST(ReuseDirections, HistoryFollowsTheEye)
{
    Pcg32 candidates(3, 1), selection(3, 2), resampling(3, 3), batch(3, 4);
    constexpr int kFrames = 6;
    std::array<Colours, kFrames> found;
    std::array<GlossyChange, kFrames> frames;
    for (int t = 0; t < kFrames; ++t)
        frames[static_cast<size_t>(t)] = {
            direction(30 + 5 * static_cast<float>(std::max(t - 1, 0))),
            direction(30 + 5 * static_cast<float>(t))};
    for (int i = 0; i < kTrials; ++i) {
        History<vec3, float> history({2, 4, 12, 12});
        for (size_t t = 0; t < kFrames; ++t) {
            const float c = solveCFromCandidates(frames[t], history.nominal(), 2, 8, batch);
            const auto e = history.advance(frames[t], c, candidates, selection, resampling);
            found[t].add(e.value, e.weightSum);
        }
    }
    for (size_t t = 0; t < kFrames; ++t) {
        expectSameMeans(found[t], freshOnly(frames[t]), 0.04);
        EXPECT_LT(std::abs(tests::againstExact(found[t].weight, 1).z), tests::kScore) << t;
    }
    EXPECT_LT(found[5].channel[0].variance(), 0.5 * found[0].channel[0].variance());
}

}  // namespace
