// Directions of a guide's leaf, in every representation: samples against densities, what is learnt
// against a known density, and lessons of every kind of fault.
#include "core/guiding/guide_leaf.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <string>
#include <vector>

#include "core/base/pcg32.h"
#include "tests/support/methods/guide_kinds.h"
#include "tests/support/statistics/stats.h"

namespace {

using core::Pcg32;
using core::guiding::GuideOptions;
using core::guiding::LearningLeaf;
using core::guiding::Lesson;
using glm::dvec3;
using glm::vec2;
using glm::vec3;
using glm::vec4;
using std::numbers::pi;
using tests::nameOfKind;

constexpr double kUniformDensity = 1 / (4 * pi);

/// A direction from z and a turn about it, both in [0, 1).
dvec3 onSphere(double u, double v)
{
    const double z = 1 - 2 * u, across = std::sqrt(std::max(1 - z * z, 0.0));
    return {across * std::cos(2 * pi * v), across * std::sin(2 * pi * v), z};
}

vec2 numbers(Pcg32& random)
{
    const auto one = [&] { return static_cast<float>(random.bits() >> 8) * 0x1p-24f; };
    const float x = one();
    return {x, one()};
}

float radicalInverse(uint32_t i)
{
    uint32_t reversed = 0;
    for (int bit = 0; bit < 12; ++bit) reversed |= ((i >> bit) & 1u) << (11 - bit);
    return (float(reversed) + 0.5f) / 4096;
}

/// A mixture of two lobes, by the formula of the books.
struct Target {
    dvec3 means[2] = {glm::normalize(dvec3(0.3, 0.5, 0.8)), glm::normalize(dvec3(-0.9, 0.1, 0.4))};
    double kappas[2] = {40, 6};
    double masses[2] = {0.7, 0.3};

    double operator()(dvec3 w) const
    {
        double sum = 0;
        for (int k = 0; k < 2; ++k)
            sum += masses[k] * kappas[k] / (2 * pi * (1 - std::exp(-2 * kappas[k]))) *
                   std::exp(kappas[k] * (glm::dot(means[k], w) - 1));
        return sum;
    }
};

Lesson lessonAt(dvec3 w, double value)
{
    Lesson lesson;
    lesson.direction = vec3(w);
    lesson.value = static_cast<float>(value);
    lesson.pdf = lesson.bsdfPdf = static_cast<float>(kUniformDensity);
    return lesson;
}

/// What uniform directions teach of a target.
std::vector<Lesson> lessonsOf(const Target& target, size_t count, uint64_t seed)
{
    Pcg32 random(seed);
    std::vector<Lesson> lessons;
    for (size_t i = 0; i < count; ++i) {
        const double u = random();
        const dvec3 w = onSphere(u, random());
        lessons.push_back(lessonAt(w, target(w) / kUniformDensity));
    }
    return lessons;
}

/// Words of one leaf, as samplers read them, behind some that are not its own.
struct Words {
    core::guiding::GuideTables tables;
    shared::GuideLeaf leaf{0, 0, 0.5f, 0};

    Words(LearningLeaf learning, const GuideOptions& options)
    {
        tables.kind = options.kind;
        tables.nodes.resize(5);
        tables.directions.resize(3);
        learning.aim(options, 0, 0);
        leaf.firstWord = learning.write(tables, options);
    }
    vec4& word(uint32_t i) { return tables.directions.at(leaf.firstWord + i); }
    double pdf(dvec3 w) const { return double(shared::pdfGuide(tables.view(), leaf, vec3(w))); }
    bool draw(vec2 u, vec3& w, float& pdf) const
    {
        if (!shared::sampleGuide(tables.view(), leaf, u, w, pdf)) return false;
        if (pdf == shared::kAsPdfGuide) pdf = shared::pdfGuide(tables.view(), leaf, w);
        return pdf > 0;
    }
};

GuideOptions optionsOf(uint32_t kind)
{
    GuideOptions options;
    options.kind = kind;
    return options;
}

class GuideDirections : public testing::TestWithParam<uint32_t> {
protected:
    LearningLeaf learnt(std::span<const Lesson> lessons) const
    {
        LearningLeaf leaf(GetParam());
        leaf.learn(lessons, 1, GuideOptions{.kind = GetParam()});
        return leaf;
    }
    Words words(const LearningLeaf& leaf) const { return {leaf, optionsOf(GetParam())}; }
    Words trained() const { return words(learnt(lessonsOf(Target{}, 4000, 1))); }
};

constexpr size_t kSphereRows = 16, kSphereColumns = 32, kInside = 48;

/// The mass in each of kSphereRows x kSphereColumns cells of equal area.
template <class Pdf> std::vector<double> massesOf(const Pdf& pdf)
{
    std::vector<double> masses(kSphereRows * kSphereColumns);
    constexpr double area = 4 * pi / double(kSphereRows * kSphereColumns * kInside * kInside);
    for (size_t i = 0; i < kSphereRows * kInside; ++i)
        for (size_t j = 0; j < kSphereColumns * kInside; ++j) {
            const dvec3 w = onSphere((double(i) + 0.5) / double(kSphereRows * kInside),
                                     (double(j) + 0.5) / double(kSphereColumns * kInside));
            masses[i / kInside * kSphereColumns + j / kInside] += area * pdf(w);
        }
    return masses;
}

size_t cellOfDirection(vec3 w)
{
    const double u = (1 - double(w.z)) / 2;
    const double v = std::atan2(double(w.y), double(w.x)) / (2 * pi);
    const auto row = std::min(size_t(std::max(u, 0.0) * double(kSphereRows)), kSphereRows - 1);
    const auto column =
        std::min(size_t((v < 0 ? v + 1 : v) * double(kSphereColumns)), kSphereColumns - 1);
    return row * kSphereColumns + column;
}

double sumOf(std::span<const double> values)
{
    double sum = 0;
    for (const double v : values) sum += v;
    return sum;
}

void expectSamples(const Words& words)
{
    constexpr size_t kSamples = 200000;
    std::vector<double> expected = massesOf([&](dvec3 w) { return words.pdf(w); });
    EXPECT_NEAR(sumOf(expected), 1, 2e-3);
    for (double& e : expected) e *= double(kSamples);
    std::vector<double> observed(expected.size());
    Pcg32 random(7);
    size_t other = 0;
    for (size_t i = 0; i < kSamples; ++i) {
        vec3 w;
        float pdf = 0;
        ASSERT_TRUE(words.draw(numbers(random), w, pdf));
        EXPECT_NEAR(glm::length(w), 1, 1e-5);
        observed[cellOfDirection(w)] += 1;
        other += std::abs(double(pdf) - words.pdf(dvec3(w))) > 1e-4 * double(pdf) ? 1u : 0u;
    }
    EXPECT_LT(other, kSamples / 1000) << "rounding may only cross the rims of cells";
    const tests::ChiSquare r = tests::chiSquareTest(observed, expected);
    EXPECT_GT(r.p, tests::kLevel) << r.statistic << " for " << r.degreesOfFreedom;
}

TEST_P(GuideDirections, SamplesFollowTheDensity)
{
    expectSamples(trained());
}

TEST_P(GuideDirections, OneLessonIsEnough)
{
    const std::vector<Lesson> one{lessonAt(glm::normalize(dvec3(0.2, -0.3, -0.9)), 1e-20)};
    expectSamples(words(learnt(one)));
}

TEST_P(GuideDirections, StrataSurvive)
{
    constexpr uint32_t kCount = 4096;
    const Words guide = trained();
    Pcg32 random(3);
    tests::Moments independent;
    double strata = 0;
    for (uint32_t i = 0; i < kCount; ++i) {
        vec3 w;
        float pdf = 0;
        const vec2 hammersley((float(i) + 0.5f) / float(kCount), radicalInverse(i));
        ASSERT_TRUE(guide.draw(hammersley, w, pdf));
        strata += double(w.x) / double(kCount);
        ASSERT_TRUE(guide.draw(numbers(random), w, pdf));
        independent.add(double(w.x));
    }
    double mean = 0;
    constexpr size_t kFine = 400;
    for (size_t i = 0; i < kFine * kFine; ++i) {
        const dvec3 w =
            onSphere((double(i % kFine) + 0.5) / kFine, (double(i / kFine) + 0.5) / kFine);
        mean += w.x * guide.pdf(w) * 4 * pi / double(kFine * kFine);
    }
    EXPECT_LT(std::abs(strata - mean), 0.3 * std::sqrt(independent.varianceOfMean()));
}

TEST_P(GuideDirections, ApproachesAKnownDensity)
{
    const Target target;
    const std::vector<double> wanted = massesOf(target);
    const auto distance = [&](const std::vector<double>& masses) {
        double sum = 0;
        for (size_t i = 0; i < masses.size(); ++i) sum += std::abs(masses[i] - wanted[i]);
        return sum;
    };
    LearningLeaf leaf(GetParam());
    for (uint64_t k = 0; k < 4; ++k)
        leaf.learn(lessonsOf(target, 1000, k), 1, GuideOptions{.kind = GetParam()});
    const Words guide = words(leaf);
    EXPECT_LT(distance(massesOf([&](dvec3 w) { return guide.pdf(w); })), 0.45);
    EXPECT_GT(distance(massesOf([](dvec3) { return kUniformDensity; })), 1.2);
}

TEST_P(GuideDirections, KnowsNothingWithoutLight)
{
    std::vector<Lesson> dark = lessonsOf(Target{}, 100, 1);
    for (Lesson& lesson : dark) lesson.value = 0;
    const Words guide = words(learnt(dark));
    vec3 w;
    float pdf = 0;
    EXPECT_FALSE(guide.draw({0.3f, 0.6f}, w, pdf));
    EXPECT_EQ(guide.pdf({0, 0, 1}), 0);
}

TEST_P(GuideDirections, SurvivesAnything)
{
    Pcg32 random(11);
    for (uint64_t round = 0; round < 60; ++round) {
        LearningLeaf leaf(GetParam());
        for (int iteration = 0; iteration < 3; ++iteration) {
            std::vector<Lesson> lessons = lessonsOf(Target{}, size_t(random() * 40), round);
            for (Lesson& lesson : lessons) {
                if (random() < 0.3) lesson.value = 0;
                if (random() < 0.3) lesson.direction = {0, 0, random() < 0.5 ? 1 : -1};
                lesson.value *= float(std::pow(10.0, round % 2 == 0 ? 0 : 40 * random() - 20));
            }
            leaf.learn(lessons, 1, GuideOptions{.kind = GetParam()});
            if (random() < 0.5) leaf.halve();
        }
        const Words guide = words(leaf);
        for (const vec4& word : guide.tables.directions)
            for (int k = 0; k < 4; ++k) ASSERT_TRUE(std::isfinite(word[k]));
        for (int i = 0; i < 200; ++i) {
            vec3 w;
            float pdf = 0;
            if (!guide.draw(numbers(random), w, pdf)) continue;
            ASSERT_TRUE(std::isfinite(pdf) && pdf > 0);
            ASSERT_NEAR(glm::length(w), 1, 1e-5);
        }
    }
}

/// Half of what a leaf knows weighs half as much against what comes.
TEST_P(GuideDirections, ChildrenInheritHalf)
{
    Target there;
    there.masses[0] = 1;
    there.masses[1] = 0;
    const std::vector<Lesson> lessons = lessonsOf(there, 2000, 1);
    std::vector<Lesson> mirrored = lessons;
    for (Lesson& lesson : mirrored) lesson.direction = -lesson.direction;
    LearningLeaf whole = learnt(lessons), child = whole;
    child.halve();
    EXPECT_EQ(child.visits, whole.visits / 2);
    EXPECT_NEAR(words(child).pdf(there.means[0]), words(whole).pdf(there.means[0]), 1e-5);
    for (LearningLeaf* leaf : {&whole, &child})
        leaf->learn(mirrored, 1, GuideOptions{.kind = GetParam()});
    const auto upper = [&](const LearningLeaf& leaf) {
        const Words guide = words(leaf);
        return sumOf(massesOf(
            [&](dvec3 w) { return glm::dot(w, there.means[0]) > 0 ? guide.pdf(w) : 0.0; }));
    };
    // A lobe that takes some of both becomes wide, and loses a little across the equator.
    // A tree is cut where light was before: new light falls into large cells, across it, too.
    const double tolerance = GetParam() == shared::kGuideTree ? 0.2 : 0.1;
    EXPECT_NEAR(upper(whole), 1.0 / 2, tolerance);
    EXPECT_NEAR(upper(child), 1.0 / 3, tolerance);
    EXPECT_GT(upper(whole) - upper(child), 0.12);
}

/// Second moments are learnt as their root: where values are as often k times as large, their
/// density is k times as high, whatever values are elsewhere.
TEST_P(GuideDirections, LearnTheRootOfSecondMoments)
{
    if (GetParam() == shared::kGuideLobes) return;  // they take the product, as is documented
    GuideOptions options = optionsOf(GetParam());
    options.target = core::guiding::GuideTarget::secondMoment;
    // Above, every second value is zero and the others are twice as large: the mean is the same,
    // the second moment twice, the density the root of two times as high.
    std::vector<Lesson> lessons;
    Pcg32 random(4);
    for (int i = 0; i < 200000; ++i) {
        const double u = random();
        const dvec3 w = onSphere(u, random());
        const bool counts = w.z < 0 || random() < 0.5;
        lessons.push_back(lessonAt(w, counts ? (w.z < 0 ? 1 : 2) : 0));
    }
    LearningLeaf leaf(GetParam());
    leaf.learn(lessons, 1, options);
    const Words guide(leaf, options);
    const auto ratio = [](const Words& words) {  // of the caps, away from cells on the equator
        const auto masses = massesOf([&](dvec3 w) { return words.pdf(w); });
        const size_t cap = masses.size() / 4;
        return sumOf(std::span(masses).first(cap)) / sumOf(std::span(masses).last(cap));
    };
    EXPECT_NEAR(ratio(guide), std::sqrt(2.0), 0.02);
    options.target = core::guiding::GuideTarget::product;
    LearningLeaf plain(GetParam());
    plain.learn(lessons, 1, options);
    EXPECT_NEAR(ratio(Words(plain, options)), 1, 0.02);
}

/// What arrives is learnt instead of what is scattered on.
TEST_P(GuideDirections, LearnRadiance)
{
    GuideOptions options = optionsOf(GetParam());
    options.target = core::guiding::GuideTarget::radiance;
    std::vector<Lesson> lessons = lessonsOf(Target{}, 4000, 1);
    for (Lesson& lesson : lessons) {
        lesson.arriving = lesson.value;
        lesson.value = 1;
    }
    LearningLeaf leaf(GetParam());
    leaf.learn(lessons, 1, options);
    const Words radiance(leaf, options), wanted = words(learnt(lessonsOf(Target{}, 4000, 1)));
    for (const dvec3 w : {dvec3(0.3, 0.5, 0.8), dvec3(-0.9, 0.1, 0.4), dvec3(0, 0, -1)})
        EXPECT_EQ(radiance.pdf(glm::normalize(w)), wanted.pdf(glm::normalize(w)));
}

/// Without memory a leaf knows the last lessons alone.
TEST_P(GuideDirections, ForgetWhenTheyAreTold)
{
    GuideOptions options = optionsOf(GetParam());
    options.memory = core::guiding::GuideMemory::reset;
    Target there;
    there.masses[0] = 1;
    there.masses[1] = 0;
    std::vector<Lesson> lessons = lessonsOf(there, 4000, 1);
    LearningLeaf leaf(GetParam());
    leaf.learn(lessons, 1, options);
    for (Lesson& lesson : lessons) lesson.direction = -lesson.direction;
    leaf.learn(lessons, 1, options);
    leaf.learn(lessons, 1, options);  // a tree is cut by what it learnt before
    const Words guide(leaf, options);
    EXPECT_LT(guide.pdf(there.means[0]), 0.05);
    EXPECT_GT(guide.pdf(-there.means[0]), 0.5);
}

INSTANTIATE_TEST_SUITE_P(Kinds, GuideDirections,
                         testing::Values(shared::kGuideHistogram, shared::kGuideLobes,
                                         shared::kGuideTree),
                         nameOfKind);

/// Light from one direction: cells become small there until the tree is as deep as it may be, and
/// samples still follow the density.
TEST(DirectionTrees, AreCutWhereLightIs)
{
    GuideOptions options = optionsOf(shared::kGuideTree);
    options.memory = core::guiding::GuideMemory::reset;  // else the first cells keep their light
    const dvec3 lamp = glm::normalize(dvec3(0.3, -0.2, 0.7));
    const std::vector<Lesson> lessons(10, lessonAt(lamp, 1));
    LearningLeaf leaf(options.kind);
    double before = 0;
    for (int k = 0; k < 24; ++k) {
        leaf.learn(lessons, 1, options);
        const double pdf = Words(leaf, options).pdf(lamp);
        EXPECT_GE(pdf, 0.99 * before);
        before = pdf;
    }
    const auto& tree = std::get<core::guiding::DirectionTree>(leaf.directions);
    EXPECT_EQ(tree.aimed().depth(), 1u);  // until it is aimed
    EXPECT_EQ(tree.density().depth(), core::guiding::Quadtree::kMaxDepth);
    const Words guide(leaf, options);
    Pcg32 random(2);
    for (int i = 0; i < 1000; ++i) {
        vec3 w;
        float pdf = 0;
        ASSERT_TRUE(guide.draw(numbers(random), w, pdf));
        ASSERT_LT(glm::distance(dvec3(w), lamp), 1e-5);
        ASSERT_TRUE(std::isfinite(pdf) && pdf > 1e9f);
    }
}

/// Lessons at a corner of four cells, or at the rim of the square, which meets itself: with the
/// filter each cell around has a quarter of the light, without it one has all (T-28).
TEST(DirectionTrees, FilterSpreadsOverCellsAround)
{
    for (const bool spread : {false, true})
        for (const vec2 corner : {vec2(5, 7) / 16.0f, vec2(11, 0) / 16.0f}) {
            GuideOptions options = optionsOf(shared::kGuideTree);
            if (spread) options.filter = core::guiding::GuideFilter::spread;
            std::vector<Lesson> lessons;
            Pcg32 random(8);
            const vec3 wi = shared::octDecode((corner + 1e-4f) * 2.0f - 1.0f);
            for (int i = 0; i < 20000; ++i) {
                lessons.push_back(lessonAt(dvec3(wi), 1));
                lessons.back().position = vec3(float(random()), float(random()), 0);
            }
            LearningLeaf leaf(options.kind);
            leaf.learn(lessons, 1, options);
            const Words guide(leaf, options);
            const float half = 0.5f / 16;
            for (const vec2 side :
                 {vec2(half, half), vec2(-half, half), vec2(half, -half), vec2(-half, -half)}) {
                vec2 p = corner + side;
                if (p.y < 0) p = vec2(1 - p.x, -p.y);
                const vec3 w = shared::octDecode(p * 2.0f - 1.0f);
                const double mass = guide.pdf(dvec3(w)) / (256 * double(shared::guideJacobian(w)));
                const bool own = side.x > 0 && side.y > 0;
                EXPECT_NEAR(mass, spread ? 0.25 : (own ? 1 : 0), spread ? 0.02 : 1e-4);
            }
        }
}

/// One bright path among a thousand does not take the lobes away from the rest.
TEST(GuideLobes, AFireflyOwnsNoMixture)
{
    const Target target;
    std::vector<Lesson> lessons = lessonsOf(target, 1000, 5);
    lessons.push_back(lessonAt({0, 0, -1}, 1e6));
    LearningLeaf leaf(shared::kGuideLobes);
    leaf.learn(lessons, 1, GuideOptions{.kind = shared::kGuideLobes});
    const Words guide(leaf, optionsOf(shared::kGuideLobes));
    EXPECT_GT(guide.pdf(target.means[0]), 0.2 * target(target.means[0]));
}

/// 1 - cos by share of the mass, and the peak, against double precision from the whole sphere to a
/// hundredth of a radian.
TEST(GuideLobes, FormulasHoldAtAllWidths)
{
    for (const double kappa : {1e-4, 1e-3, 0.01, 0.02, 0.03, 0.1, 1.0, 10.0, 100.0, 1e3, 1e4}) {
        const auto k = static_cast<float>(kappa);
        const double whole = -std::expm1(-2 * double(k));
        EXPECT_NEAR(double(shared::peakOfLobe(k)), double(k) / (2 * pi * whole),
                    1e-5 * double(k) / whole);
        for (const float x : {1e-6f, 0.01f, 0.3f, 0.5f, 0.9f, 0.999f, 1.0f}) {
            const double height = std::min(-std::log1p(-double(x) * whole) / double(k), 2.0);
            const double largest = -std::log(5e-8) / double(k);  // fp32 has no more
            const double tolerance = 2e-5 * height + (x > 0.9f ? 1e-4 / kappa : 0);
            EXPECT_NEAR(double(shared::heightOfLobe(k, x)), std::min(height, largest), tolerance)
                << kappa << " " << x;
        }
    }
    EXPECT_NEAR(shared::peakOfLobe(0), kUniformDensity, 1e-5);
    EXPECT_NEAR(shared::heightOfLobe(0, 0.25f), 0.5, 1e-5);
}

/// One lobe of any width.
TEST(GuideLobes, SamplesFollowTheDensityAtAllWidths)
{
    for (const float kappa : {0.0f, 1e-3f, 0.1f, 1.0f, 30.0f, 1e3f, 1e4f}) {
        const vec3 mean = glm::normalize(vec3(-0.4f, 0.7f, -0.2f));
        Words guide(LearningLeaf(shared::kGuideLobes), optionsOf(shared::kGuideLobes));
        for (int k = 0; k < 3; ++k) guide.word(shared::kLobeX + 2 * uint32_t(k) + 1)[2] = mean[k];
        guide.word(shared::kLobeWidth + 1)[2] = kappa / 2;
        guide.word(shared::kLobePeak + 1)[2] = shared::peakOfLobe(kappa);
        guide.word(shared::kLobeMass + 1)[2] = 1;
        expectSamples(guide);
    }
}

}  // namespace
