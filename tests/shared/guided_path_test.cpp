// What a guided vertex draws: the mixture of lobes and guide against its density by chi-square, its
// weights against those of the lobes alone, sharp lobes as likely as ever, and a roulette that
// never fails.
#include "shared/guided_path.h"

#include <array>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "core/guiding/guide.h"
#include "tests/support/methods/bsdf_cases.h"

namespace {

using namespace tests;

constexpr uint kDirections = 1u << 18;

/// A guide that has seen all light come from about one direction, at places whose normal is +z.
core::guiding::Guide guideTowards(vec3 light)
{
    core::guiding::PathRecords records;
    for (uint i = 0; i < 4096; ++i) {
        const vec2 u(float(i % 64) / 64, float(i / 64) / 64);
        shared::GuideRecord r{};
        r.position = vec3(u.x, u.y, 0);
        r.direction = shared::packOct(glm::normalize(light + 0.3f * shared::sampleSphere(u)));
        r.pdf = 1;
        r.bsdfPdf = 1;
        r.beta = 1;
        r.place = shared::guideRoot(vec3(0, 0, 1));
        records.records.push_back(r);
        records.ends.push_back({1, 1, 0});
    }
    core::guiding::Guide guide({.kind = shared::kGuideLobes});  // smooth: quadrature is easy
    guide.learn(std::span(&records, 1), 1);
    return guide;
}

/// A flat surface that faces +z, in a frame that is turned so that no axis is special.
shared::Vertex vertexOf(const BsdfInputs& inputs, vec3 wo)
{
    shared::Vertex v{};
    v.surface.normal = vec3(0, 0, 1);
    v.surface.frame = glm::mat3(vec3(0.8f, 0.6f, 0), vec3(-0.6f, 0.8f, 0), vec3(0, 0, 1));
    v.bsdf = shared::makeBsdf(inputs);
    v.wo = wo;
    v.lobes = shared::lobesAt(v.bsdf, wo);
    return v;
}

shared::VertexNumbers numbersOf(uint i)
{
    const shared::SampleStream stream =
        shared::makeStream(shared::kSamplerIndependent, 5, {3, 7}, i, shared::kPurposePath);
    return shared::drawVertexNumbers(stream, 0);
}

struct Surface {
    const char* name;
    BsdfInputs inputs;
};

std::vector<Surface> someSurfaces()
{
    BsdfInputs coated = plastic(0.6f);
    coated.clearcoat = 1;
    coated.clearcoatRoughness = 0.5f;
    BsdfInputs mirrorCoat = matte(vec3(0.7f));
    mirrorCoat.clearcoat = 1;
    return {{"lambert", matte(vec3(0.8f, 0.5f, 0.2f))},
            {"plastic", plastic(0.7f)},
            {"rough glass", glass(0.3f, Wall::outside)},
            {"coated", coated},
            {"mirror coat", mirrorCoat}};
}

constexpr int kCellRows = 12, kCellColumns = 16;  // in the cosine, all of [-1, 1], and the azimuth

size_t cellOfWay(vec3 wi)
{
    const double turn = std::atan2(double(wi.y), double(wi.x)) / (2 * kPi);
    const int row = std::min(int((double(wi.z) + 1) / 2 * kCellRows), kCellRows - 1);
    const int column = std::min(int((turn < 0 ? turn + 1 : turn) * kCellColumns), kCellColumns - 1);
    return size_t(row) * kCellColumns + size_t(column);
}

/// Integrals of the mixture's density without delta lobes over the cells, by midpoints.
std::vector<double> probabilities(const shared::Vertex& v, float share, shared::GuideLeaf leaf,
                                  const shared::GuideView& guide)
{
    constexpr int kFine = 24;
    std::vector<double> cells(size_t(kCellRows) * kCellColumns);
    const double area = 4 * kPi / (double(kCellRows) * kCellColumns * kFine * kFine);
    for (int i = 0; i < kCellRows * kFine; ++i) {
        for (int j = 0; j < kCellColumns * kFine; ++j) {
            const double z = 2 * (i + 0.5) / (kCellRows * kFine) - 1;
            const double phi = 2 * kPi * (j + 0.5) / (kCellColumns * kFine);
            const double s = std::sqrt(1 - z * z);
            const vec3 wi(float(s * std::cos(phi)), float(s * std::sin(phi)), float(z));
            vec3 f;
            float bsdf;
            shared::evalPdfLobes(v.bsdf, v.lobes, v.wo, wi, f, bsdf);
            // Where the surface scatters nothing, what the guide draws is dropped.
            if (!(bsdf > 0)) continue;
            const float guided =
                shared::pdfGuide(guide, leaf, shared::toWorld(v.surface.frame, wi));
            cells[cellOfWay(wi)] += area * double((1 - share) * bsdf + share * guided);
        }
    }
    return cells;
}

TEST(GuidedPath, MixturesFollowTheirDensity)
{
    const core::guiding::Guide guide = guideTowards(glm::normalize(vec3(1, 0.4f, 0.9f)));
    const auto tables = guide.tables();
    const shared::GuideView view = tables->view();
    for (const Surface& surface : someSurfaces()) {
        for (const float bsdfShare : {0.12f, 0.6f}) {
            shared::Vertex v = vertexOf(surface.inputs, directionAt(50));
            shared::GuideLeaf leaf = shared::guideAt(view, vec3(0.5f, 0.5f, 0), vec3(0, 0, 1));
            float sharp;
            const float share = shared::shareWithGuide(bsdfShare, v, sharp);
            ASSERT_GT(share, 0.1f) << surface.name;
            std::vector<double> expected = probabilities(v, share, leaf, view);
            std::vector<double> observed(expected.size() + 1);
            for (uint i = 0; i < kDirections; ++i) {
                BsdfSample s;
                float pdf;
                const bool drawn =
                    shared::sampleMixture(view, leaf, share, v, numbersOf(i), s, pdf);
                const bool counts = drawn && (s.flags & shared::kLobeDelta) == 0u;
                ++observed[counts ? cellOfWay(s.wi) : expected.size()];
                if (!counts) continue;
                vec3 f;
                float bsdf;
                shared::evalPdfLobes(v.bsdf, v.lobes, v.wo, s.wi, f, bsdf);
                const float mixture =
                    (1 - share) * bsdf +
                    share * shared::pdfGuide(view, leaf, shared::toWorld(v.surface.frame, s.wi));
                ASSERT_NEAR(pdf / mixture, 1, 0.02) << surface.name;
                ASSERT_NEAR(s.pdf / bsdf, 1, 0.02) << surface.name;
            }
            double all = 0;
            for (double& e : expected) all += e *= kDirections;
            expected.push_back(kDirections - all);  // delta lobes, and what was dropped
            const ChiSquare result = chiSquareTest(observed, expected);
            EXPECT_GT(result.p, kLevel) << surface.name << ", share " << bsdfShare;
        }
    }
}

/// The mean of the weights is the surface's albedo, whatever the guide believes.
TEST(GuidedPath, WeightsHaveTheMeanOfTheLobesAlone)
{
    const core::guiding::Guide guide = guideTowards(glm::normalize(vec3(-1, 0.2f, 0.5f)));
    const auto tables = guide.tables();
    const shared::GuideView view = tables->view();
    for (const Surface& surface : someSurfaces()) {
        const shared::GuideLeaf leaf = shared::guideAt(view, vec3(0.5f, 0.5f, 0), vec3(0, 0, 1));
        const auto moments = [&](float bsdfShare) {
            shared::Vertex v = vertexOf(surface.inputs, directionAt(50));
            float sharp;
            const float share = shared::shareWithGuide(bsdfShare, v, sharp);
            Moments m;
            for (uint i = 0; i < kDirections; ++i) {
                BsdfSample s;
                float pdf;
                // Other numbers for each share: the two means are compared as independent ones.
                const uint index = i + (bsdfShare < 1 ? kDirections : 0);
                const bool drawn =
                    shared::sampleMixture(view, leaf, share, v, numbersOf(index), s, pdf);
                m.add(drawn ? double(s.weight.y) : 0.0);
            }
            return m;
        };
        const Comparison c = welch(moments(1), moments(0.25f));
        EXPECT_LT(std::abs(c.z), kScore) << surface.name;
        EXPECT_LT(c.detectable, 0.05) << surface.name << " is underpowered";
    }
}

TEST(GuidedPath, SharpLobesKeepTheirProbability)
{
    shared::Vertex v = vertexOf(someSurfaces().back().inputs, directionAt(70));
    const float coat = v.lobes.coat;
    ASSERT_GT(coat, 0.1f);
    float sharp;
    const float share = shared::shareWithGuide(0.25f, v, sharp);
    EXPECT_NEAR(sharp, coat, 1e-6f);
    EXPECT_NEAR((1 - share) * v.lobes.coat, coat, 1e-6f);
    EXPECT_NEAR(v.lobes.coat + v.lobes.facet + v.lobes.diffuse, 1, 1e-5f);

    shared::Vertex mirror = vertexOf(metal(0.0f), directionAt(30));
    EXPECT_EQ(shared::shareWithGuide(0.25f, mirror, sharp), 0);
    EXPECT_EQ(sharp, 1);
}

TEST(GuidedPath, SurvivalIsAProbability)
{
    constexpr float kHuge = std::numeric_limits<float>::max();
    const float infinite = std::numeric_limits<float>::infinity();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const uint kind : {shared::kRouletteBoth, shared::kRouletteAlbedo, shared::kRouletteLight,
                            shared::kRouletteNone})
        for (const float albedo : {1e-30f, 0.3f, 1.0f, 40.0f})
            for (const float expected : {0.0f, 1e-38f, 1.0f, kHuge, infinite, nan})
                for (const float image : {0.0f, 1e-38f, 1.0f, kHuge, infinite, nan}) {
                    const float p = shared::guidedSurvival(kind, albedo, expected, image);
                    EXPECT_TRUE(p > 0 && p <= 1)
                        << kind << ' ' << albedo << ' ' << expected << ' ' << image << ": " << p;
                }
    EXPECT_FLOAT_EQ(shared::guidedSurvival(shared::kRouletteBoth, 0.25f, 0.8f, 1), 0.8f);
    EXPECT_FLOAT_EQ(shared::guidedSurvival(shared::kRouletteBoth, 0.25f, 0.1f, 1), 0.5f);
    EXPECT_FLOAT_EQ(shared::guidedSurvival(shared::kRouletteAlbedo, 0.25f, 0.8f, 1), 0.5f);
    EXPECT_EQ(shared::guidedSurvival(shared::kRouletteNone, 0.25f, 0.1f, 1), 1);
    EXPECT_EQ(shared::guidedSurvival(shared::kRouletteNone, 0.25f, 0.1f, 0), 1);
}

/// One path in so many of every tile, each pixel in its turn, each in a place of its own.
TEST(GuidedPath, RecordedPathsTakeTurns)
{
    for (const uint stride : {1u, 4u, 64u}) {
        std::array<int, 64> turns{};
        for (uint sample = 0; sample < 64; ++sample) {
            std::vector<uint> slots;
            for (uint lane = 0; lane < 128; ++lane)
                if (shared::isRecorded(lane % 64, sample, stride)) {
                    slots.push_back(shared::recordedSlot(lane, stride));
                    if (lane < 64) ++turns[lane];
                }
            ASSERT_EQ(slots.size(), 128 / stride);
            for (size_t i = 0; i < slots.size(); ++i) EXPECT_EQ(slots[i], i);
        }
        for (const int t : turns) EXPECT_EQ(t, int(64 / stride));
    }
    EXPECT_FALSE(shared::isRecorded(0, 0, 0));
}

}  // namespace
