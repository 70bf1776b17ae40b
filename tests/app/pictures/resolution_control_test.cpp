// The choice of coarse pictures on a pretended machine, and the numbers of the curve of errors on
// images whose errors are known.
#include <cmath>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "app/pictures/error_point.h"
#include "app/pictures/resolution_control.h"
#include "core/image/metrics.h"

namespace {

using app::PreviewSize;
using app::ResolutionControl;

/// A machine: fixed seconds per picture, seconds per pixel and event.
struct Machine {
    double fixed = 0, perPixel = 0;
    double seconds(const PreviewSize& p) const
    {
        return fixed + perPixel * double(p.size.x) * p.size.y * (1 + 0.7 * p.depth);
    }
};

PreviewSize settle(ResolutionControl& control, const Machine& machine, double target,
                   uint32_t depth = 3)
{
    PreviewSize p;
    for (int i = 0; i < 12; ++i) {
        p = control.choose({1280, 720}, depth, target);
        control.observe(double(p.size.x) * p.size.y, p.depth, machine.seconds(p), true);
    }
    return p;
}

TEST(ResolutionControl, FindsTheFinestThatIsQuickEnough)
{
    for (const double perPixel : {1e-9, 1e-8, 1e-7, 3e-7, 1e-6}) {
        for (const double fixed : {0.0, 0.004}) {
            ResolutionControl control;
            const Machine machine{fixed, perPixel};
            const double target = 1.0 / 30;
            const PreviewSize p = settle(control, machine, target);
            const bool coarsest = p.scale <= 0.25f && p.depth == 1;
            if (!coarsest) {
                EXPECT_LE(machine.seconds(p), 1.05 * target) << perPixel;
            }
            if (p.scale >= 1 || machine.seconds(p) > target) continue;
            // Half the pixels more in each direction would have been too slow, or nearly
            PreviewSize finer = p;
            finer.size = glm::uvec2(glm::vec2(p.size) * 1.5f);
            EXPECT_GE(machine.seconds(finer), 0.7 * target) << perPixel;
        }
    }
}

TEST(ResolutionControl, KeepsTheShapeAndFewSizes)
{
    std::set<uint32_t> widths, depths;
    for (double perPixel = 1e-9; perPixel < 1e-4; perPixel *= 1.1) {
        ResolutionControl control;
        const PreviewSize p = settle(control, {0, perPixel}, 1.0 / 30);
        widths.insert(p.size.x);
        EXPECT_NEAR(double(p.size.x) / p.size.y, 1280.0 / 720, 0.02);
        EXPECT_NEAR(double(p.scale), p.size.x / 1280.0, 0.001);
        EXPECT_GE(p.scale, 0.25f) << "from there on the rate gives way";
        EXPECT_GE(p.depth, 1u);
        EXPECT_LE(p.depth, 3u);
        if (p.scale > 0.26f) {
            EXPECT_EQ(p.depth, 3u) << "resolution goes first";
        }
        depths.insert(p.depth);
    }
    EXPECT_EQ(widths.size(), 5u);
    EXPECT_EQ(depths.size(), 3u) << "depth goes at the smallest size";
    ResolutionControl control;
    EXPECT_EQ(control.choose({1, 1}, 0, 0.03).size, glm::uvec2(1, 1));
    EXPECT_EQ(control.choose({5, 3}, 0, 0.03).depth, 0u);
}

TEST(ResolutionControl, KeptSamplesKeepTheirDepthAndOnlySlowPicturesAreTiny)
{
    const double target = 1.0 / 30;
    bool eighth = false, tiny = false;
    for (double perPixel = 1e-9; perPixel < 1e-4; perPixel *= 1.1) {
        ResolutionControl control;
        const Machine machine{0, perPixel};
        PreviewSize p;
        for (int i = 0; i < 12; ++i) {
            p = control.choose({1280, 720}, 3, target, {.keepsDepth = true});
            control.observe(double(p.size.x) * p.size.y, p.depth, machine.seconds(p), true);
        }
        EXPECT_EQ(p.depth, 3u);
        EXPECT_GE(p.scale, 0.088f);
        const double ofEighth = machine.seconds({{160, 90}, 0.125f, 3});
        if (p.scale < 0.12f) {
            EXPECT_GT(ofEighth, 2.5 * 0.7 * target) << perPixel << ": it could be an eighth";
            tiny = true;
        } else {
            EXPECT_LE(ofEighth, 2.51 * target) << perPixel << ": too slow for an eighth";
            eighth |= p.scale < 0.13f && ofEighth > 1.2 * target;
        }
    }
    EXPECT_TRUE(eighth && tiny);
}

TEST(ResolutionControl, DoesNotFlickerWhereTwoSizesAreNearlyRight)
{
    std::mt19937 random(5);
    std::uniform_real_distribution<double> noise(0.85, 1.15);
    for (const double perPixel : {2e-8, 5e-8, 1e-7, 2e-7}) {
        ResolutionControl control;
        settle(control, {0, perPixel}, 1.0 / 30);
        std::set<uint32_t> widths;
        int changes = 0;
        uint32_t last = 0;
        for (int i = 0; i < 300; ++i) {
            const PreviewSize p = control.choose({1280, 720}, 3, 1.0 / 30);
            control.observe(double(p.size.x) * p.size.y, p.depth,
                            noise(random) * Machine{0, perPixel}.seconds(p), true);
            changes += last != 0 && p.size.x != last ? 1 : 0;
            last = p.size.x;
            widths.insert(last);
        }
        EXPECT_LE(widths.size(), 2u);
        EXPECT_LE(changes, 3) << perPixel;
    }
}

TEST(ResolutionControl, FollowsASceneThatBecomesHeavy)
{
    ResolutionControl control;
    settle(control, {0, 1e-8}, 1.0 / 30);
    const Machine heavy{0, 2e-7};
    for (int i = 0; i < 2; ++i) {  // one slow picture, then quick ones
        const PreviewSize p = control.choose({1280, 720}, 3, 1.0 / 30);
        control.observe(double(p.size.x) * p.size.y, p.depth, heavy.seconds(p), true);
        if (i == 1) {
            EXPECT_LE(heavy.seconds(p), 0.04);
        }
    }
    control.forget();
    EXPECT_EQ(control.predict(1000, 3), 0);
    EXPECT_EQ(control.choose({1280, 720}, 3, 1.0 / 30).scale, 0.25f);
}

TEST(ResolutionControl, FullPicturesTellUntilAPreviewHas)
{
    ResolutionControl control;
    control.observe(1e6, 3, 1, false);
    EXPECT_DOUBLE_EQ(control.predict(1e6, 3), 1);
    control.observe(1e4, 3, 0.002, true);
    EXPECT_DOUBLE_EQ(control.predict(1e6, 3), 0.2);
    control.observe(1e6, 3, 1, false);
    EXPECT_DOUBLE_EQ(control.predict(1e6, 3), 0.2);
    control.observe(0, 3, 1, true);
    EXPECT_DOUBLE_EQ(control.predict(1e6, 3), 0.2);
}

// --- points of the curve

core::Image greyImage(uint32_t width, uint32_t height, float value)
{
    core::Image image(width, height, 3);
    image.pixels.assign(image.pixels.size(), value);
    return image;
}

TEST(ErrorPoint, RmseIsThatOfTheMetrics)
{
    std::mt19937 random(3);
    std::normal_distribution<float> normal;
    core::Image a = greyImage(37, 21, 1), b = greyImage(37, 21, 0.5f);
    for (float& v : a.pixels) v += 0.3f * normal(random);
    EXPECT_NEAR(app::errorAgainst(a, b).rmse, core::imageErrors(a, b).rmse, 1e-12);
    a.pixels[30] = NAN;
    EXPECT_NEAR(app::errorAgainst(a, b).rmse, core::imageErrors(a, b).rmse, 1e-12);
}

TEST(ErrorPoint, TheStandardErrorIsThatOfIndependentTiles)
{
    // Independent normal errors: the RMSE of many images scatters as each of them says.
    std::mt19937 random(17);
    std::normal_distribution<float> normal;
    const core::Image reference = greyImage(64, 48, 0);
    double sum = 0, squares = 0, told = 0;
    constexpr int kImages = 400;
    for (int i = 0; i < kImages; ++i) {
        core::Image image = reference;
        for (float& v : image.pixels) v = normal(random);
        const app::ErrorEstimate e = app::errorAgainst(image, reference);
        sum += e.rmse;
        squares += e.rmse * e.rmse;
        told += e.rmseSe * e.rmseSe / kImages;
    }
    const double mean = sum / kImages,
                 variance = (squares / kImages - mean * mean) * kImages / (kImages - 1);
    EXPECT_NEAR(mean, 1, 4.21 * std::sqrt(variance / kImages) + 1.0 / (4 * 64 * 48 * 3));
    // A sample variance of 400 normal values has a relative standard error of sqrt(2/399).
    EXPECT_NEAR(variance / told, 1, 4.21 * std::sqrt(2.0 / 399));
}

TEST(ErrorPoint, CurvesStayShortAndKeepTheirShape)
{
    std::vector<app::ErrorPoint> curve;
    for (uint64_t n = 1; n <= 5000; ++n) {
        app::addPoint(curve, {.seconds = double(n), .samples = n});
        ASSERT_LE(curve.size(), 300u);
        ASSERT_EQ(curve.back().samples, n);
    }
    EXPECT_EQ(curve.front().samples, 1u);
    for (size_t i = 1; i < curve.size(); ++i) EXPECT_GT(curve[i].samples, curve[i - 1].samples);
    app::addPoint(curve, {.seconds = 6000, .samples = 5000, .rmse = 2});
    EXPECT_EQ(curve.back().rmse, 2);
    EXPECT_LT(curve[curve.size() - 2].samples, 5000u) << "the same samples make the same point";
}

}  // namespace
