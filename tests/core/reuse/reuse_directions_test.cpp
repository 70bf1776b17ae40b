// The estimators over directions, in single precision and with colours: visible normals of GGX seen
// from two places, as when a camera moves past a glossy surface.
#include <cmath>

#include <gtest/gtest.h>

#include "core/reuse/history.h"
#include "shared/microfacet.h"
#include "shared/warp.h"
#include "tests/support/statistics/stats.h"

namespace core::reuse {
namespace {

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
    float alpha = kAlpha;

    float density(vec3 wo, vec3 wi) const
    {
        return wo.z + wi.z > 0 ? shared::reflectFacet(wo, wi, alpha, 1).pdf : 0;
    }
    float q(vec3 wi) const { return density(oldWo, wi); }
    float p(vec3 wi) const { return density(newWo, wi); }
    vec3 f(vec3 wi) const
    {
        if (!(wi.z > 0)) return vec3(0);
        const vec3 radiance(1 + wi.x, 1 + std::sin(9 * wi.y), wi.x < -0.6f ? 4 : 1);
        return radiance * (shared::reflectFacet(newWo, wi, alpha, 1).value * wi.z);
    }
    template <class Random> vec3 sampleFor(vec3 wo, Random& random) const
    {
        const glm::vec2 xi(uniform<float>(random), uniform<float>(random));
        const float radius = std::sqrt(xi.x), angle = 2 * shared::kPi * xi.y;
        const glm::vec2 disk(radius * std::cos(angle), radius * std::sin(angle));
        return shared::mirrorAbout(wo, shared::visibleNormal(wo, alpha, 1, disk));
    }
    template <class Random> vec3 sampleP(Random& random) const { return sampleFor(newWo, random); }
};
static_assert(Change<GlossyChange>);

struct Colours {
    std::array<tests::Moments, 3> channel;
    tests::Moments weight;

    void add(vec3 value, double weightSum)
    {
        for (int i = 0; i < 3; ++i)
            channel[static_cast<size_t>(i)].add(static_cast<double>(value[i]));
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

constexpr int kDirectionTrials = 100000;

Colours freshOnly(const GlossyChange& change)
{
    Colours found;
    Pcg32 random(1, 1);
    for (int i = 0; i < 4 * kDirectionTrials; ++i) {
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
        for (int i = 0; i < kDirectionTrials; ++i) {
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
    for (int i = 0; i < kDirectionTrials; ++i) {
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

/// How much of a lobe is new after the eye moved: the total variation of both densities, which
/// batches of candidates measure and 10^6 stratified samples gave independently. It decides how
/// long a history is worth keeping.
TEST(ReuseDirections, ResidualOfAMovedLobeIsTheExpectedOne)
{
    struct {
        float alpha, degrees;
        double totalVariation;
    } const expectations[] = {{0.02f, 0.5f, 0.1083}, {0.05f, 1, 0.0864}, {0.05f, 5, 0.3971},
                              {0.1f, 2, 0.0848},     {0.2f, 5, 0.0986},  {0.3f, 20, 0.2150},
                              {0.5f, 10, 0.0595},    {0.8f, 20, 0.1215}};
    for (const auto& e : expectations) {
        const GlossyChange change{direction(45), direction(45 + e.degrees), e.alpha};
        Pcg32 random(5);
        tests::Moments residual;
        for (int i = 0; i < 500000; ++i) {
            const vec3 z = change.sampleP(random);
            residual.add(1 -
                         static_cast<double>(shared::reuseAlpha(1.0f, change.q(z), change.p(z))));
        }
        EXPECT_NEAR(residual.mean(), e.totalVariation, 0.002) << e.alpha << ' ' << e.degrees;
    }
}

/// While nothing moves a history is the mean of its samples: K old and n new ones.
TEST(ReuseDirections, AtRestVarianceIsThatOfAllSamplesKept)
{
    const GlossyChange change{direction(45), direction(45)};
    constexpr uint32_t n = 2, K = 14;
    Pcg32 candidates(6, 1), selection(6, 2), resampling(6, 3);
    Colours first, last;
    for (int i = 0; i < kDirectionTrials; ++i) {
        History<vec3, float> history({n, 1, K, K});
        for (int t = 0; t < 40; ++t) {
            const float N = history.nominal();
            const float c = N / (N + n);
            const auto e = history.advance(change, c, candidates, selection, resampling);
            if (t == 0) first.add(e.value, e.weightSum);
            if (t == 39) last.add(e.value, e.weightSum);
        }
    }
    for (size_t i = 0; i < 3; ++i)
        EXPECT_NEAR(last.channel[i].variance() / first.channel[i].variance(), double(n) / (K + n),
                    0.05 * n / (K + n))
            << i;
    expectSameMeans(last, first, 0.02);
}

}  // namespace
}  // namespace core::reuse
