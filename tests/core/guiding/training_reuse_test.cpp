// Records that teach twice, densities aimed at what they lack, and the share that is learnt by
// descent (T-24).
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/pcg32.h"
#include "core/guiding/guide_leaf.h"
#include "core/guiding/learnt_share.h"
#include "core/guiding/record_store.h"
#include "tests/support/statistics/stats.h"

namespace {

using core::Pcg32;
using core::guiding::DirectionTree;
using core::guiding::GuideMemory;
using core::guiding::GuideOptions;
using core::guiding::GuideTables;
using core::guiding::LearningLeaf;
using core::guiding::LearntShare;
using core::guiding::Lesson;
using core::guiding::Quadtree;
using core::guiding::RecordStore;

/// Numbers in [0, 1] instead of directions: of density 2x the old ones, 2(1 - x) the new ones.
struct Line {
    static double old(double x) { return 2 * x; }
    static double now(double x) { return 2 * (1 - x); }
    static double f(double x) { return 1 + x * x; }

    static std::vector<Lesson> lessons(Pcg32& random, size_t count, bool isOld)
    {
        std::vector<Lesson> all(count);
        for (Lesson& lesson : all) {
            const double root = std::sqrt(random()), x = isOld ? root : 1 - root;
            lesson.position.x = float(x);
            lesson.pdf = float(isOld ? old(x) : now(x));
            lesson.otherPdf = float(isOld ? now(x) : old(x));
            lesson.value = lesson.pdf > 0 ? float(f(x)) / lesson.pdf : 0;
        }
        return all;
    }
};

TEST(RecordStore, BothSetsAreSamplesOfOneDensity)
{
    constexpr size_t kOld = 8, kNew = 4, kTrials = 20000;
    Pcg32 random(3);
    tests::Moments left, right, alone;
    for (size_t t = 0; t < kTrials; ++t) {
        RecordStore store;
        store.keep(Line::lessons(random, kOld, true));
        const std::vector<Lesson> added = Line::lessons(random, kNew, false);
        const std::vector<Lesson> all = store.together(added);
        ASSERT_EQ(all.size(), kOld + kNew);
        double sums[2] = {}, own = 0;
        for (const Lesson& lesson : all) {
            const double x = double(lesson.position.x);
            const double pdf = (kOld * Line::old(x) + kNew * Line::now(x)) / double(kOld + kNew);
            ASSERT_NEAR(double(lesson.value) / (Line::f(x) / pdf), 1, 1e-4);
            sums[x < 0.5 ? 0 : 1] += double(lesson.value) / double(kOld + kNew);
        }
        for (const Lesson& lesson : added)
            if (lesson.position.x >= 0.5f) own += double(lesson.value) / double(kNew);
        left.add(sums[0]);
        right.add(sums[1]);
        alone.add(own);
    }
    const double lower = 0.5 + 0.125 / 3, upper = 0.5 + 0.875 / 3;
    EXPECT_LT(std::abs(left.mean() - lower), tests::kScore * std::sqrt(left.varianceOfMean()));
    EXPECT_LT(std::abs(right.mean() - upper), tests::kScore * std::sqrt(right.varianceOfMean()));
    EXPECT_LT(std::sqrt(right.varianceOfMean()), 0.005 * upper) << "underpowered";
    EXPECT_LT(right.varianceOfMean(), alone.varianceOfMean() / 4);
}

TEST(RecordStore, IsClippedWithItsLeaf)
{
    Pcg32 random(5);
    RecordStore store;
    store.keep(Line::lessons(random, 1000, true));
    RecordStore above = store;
    store.clip(0.5f, 0, false);
    above.clip(0.5f, 0, true);
    EXPECT_EQ(store.lessons().size() + above.lessons().size(), 1000u);
    for (const Lesson& lesson : store.lessons()) EXPECT_LT(lesson.position.x, 0.5f);
    for (const Lesson& lesson : above.lessons()) EXPECT_GE(lesson.position.x, 0.5f);
    EXPECT_NEAR(double(store.lessons().size()), 250, 70);
}

/// Directions that were drawn uniformly, with light about +z and, by `share`, about -z.
std::vector<Lesson> lightOf(double share, size_t count, uint64_t seed)
{
    Pcg32 random(seed);
    std::vector<Lesson> lessons(count);
    for (Lesson& lesson : lessons) {
        const double u = random();
        lesson.direction = shared::sampleSphere({float(u), float(random())});
        lesson.pdf = lesson.bsdfPdf = 0.25f * shared::kInvPi;
        const double z = double(lesson.direction.z);
        lesson.value =
            float((1 - share) * std::exp(20 * (z - 1)) + share * std::exp(20 * (-z - 1)));
    }
    return lessons;
}

/// What samplers read of a tree that is to draw what the last records lack: (p - c q)+ / R.
TEST(ResidualGuides, DrawWhatOldRecordsLack)
{
    GuideOptions options;
    options.kind = shared::kGuideTree;
    options.memory = GuideMemory::residual;
    LearningLeaf leaf(options.kind);
    leaf.learn(lightOf(0.2, 4000, 1), 1, options);
    leaf.aim(options, 0, 8000);  // nothing was drawn from a guide yet: all of it is aimed at
    const auto& tree = std::get<DirectionTree>(leaf.directions);
    const Quadtree q = tree.aimed();
    EXPECT_EQ(q.pdf({0.3, 0.4}), tree.density().pdf({0.3, 0.4}));

    leaf.learn(lightOf(0.8, 4000, 2), 1, options);
    leaf.aim(options, 4000, 8000);
    const Quadtree p = tree.density();
    const double c = core::guiding::bestC(q, p, 4000, 8000);
    const core::guiding::Residual wanted = core::guiding::residual(q, p, c);
    ASSERT_GT(c, 0.05);
    ASSERT_LT(wanted.mass, 0.95);
    GuideTables tables;
    tables.kind = options.kind;
    const shared::GuideLeaf where{0, leaf.write(tables, options), 0.5f, 0};
    double largest = 0;
    Pcg32 random(9);
    for (int i = 0; i < 2000; ++i) {
        const double u = random();
        const glm::vec3 wi = shared::sampleSphere({float(u), float(random())});
        const double expected = wanted.tree.pdf(glm::dvec2(shared::guideSquare(wi))) *
                                double(shared::guideJacobian(wi));
        const double is = double(shared::pdfGuide(tables.view(), where, wi));
        largest = std::max(largest, is);
        ASSERT_NEAR(is, expected, 2e-3 * expected + 1e-4);  // shares have 16 bits
    }
    EXPECT_GT(largest, 0.5);

    // With no lessons to come there is nothing to complete.
    leaf.aim(options, 4000, 0);
    EXPECT_EQ(tree.aimed().pdf({0.3, 0.4}), p.pdf({0.3, 0.4}));
}

TEST(LearntShare, DescendsAsTheFormulasSay)
{
    LearntShare share;
    EXPECT_EQ(share.share(), 0.5);
    const auto lesson = [&share] { share.learn(2, 0.8, 0.2, 0.5); };
    lesson();
    EXPECT_EQ(share.theta(), 0);  // a step takes two
    lesson();
    EXPECT_NEAR(share.theta(), 0.0100000, 1e-6);
    EXPECT_NEAR(share.share(), 0.5025000, 1e-6);
    lesson();
    lesson();
    EXPECT_NEAR(share.theta(), 0.0199992, 1e-5);
    EXPECT_NEAR(share.share(), 0.5049996, 1e-5);
    // Towards the density that brings light.
    for (int i = 0; i < 4000; ++i) share.learn(1, 0.1, 0.9, 0.5);
    EXPECT_LT(share.share(), 0.2);
}

}  // namespace
