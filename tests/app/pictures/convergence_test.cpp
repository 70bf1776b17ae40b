// Slopes and times to go: on curves of known law with the noise that Monte Carlo curves have, on
// curves whose noise is of another kind, and at the edges.
#include "app/pictures/convergence.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/statistics/stats.h"

namespace {

constexpr double kGrowth = 1.2;

std::vector<app::ErrorPoint> curve(double slope, int count, double first = 0.1, double scale = 1)
{
    std::vector<app::ErrorPoint> points;
    double seconds = first;
    for (int i = 0; i < count; ++i, seconds *= kGrowth) {
        app::ErrorPoint p;
        p.seconds = seconds;
        p.samples = static_cast<uint64_t>(seconds * 100) + 1;
        p.rmse = p.estimated = scale * std::pow(seconds, slope);
        points.push_back(p);
    }
    return points;
}

/// A picture of `pixels` independent pixels that gathers samples of variance one: the curve of its
/// error.
std::vector<app::ErrorPoint> simulated(std::mt19937_64& random, int pixels, int count)
{
    std::normal_distribution<double> normal;
    std::vector<double> sums(static_cast<size_t>(pixels), 0.0);
    std::vector<app::ErrorPoint> points;
    double samples = 0, next = 4;
    for (int i = 0; i < count; ++i, next = std::ceil(next * kGrowth)) {
        const double spread = std::sqrt(next - samples);
        samples = next;
        double squares = 0;
        for (double& sum : sums) {
            sum += spread * normal(random);
            squares += sum * sum / (samples * samples);
        }
        app::ErrorPoint p;
        p.seconds = samples * 0.01;
        p.samples = static_cast<uint64_t>(samples);
        p.rmse = std::sqrt(squares / pixels);
        points.push_back(p);
    }
    return points;
}

TEST(FitCurve, ExactLaws)
{
    for (const double slope : {-0.5, -1.0, -0.25, 0.1}) {
        const auto fit = app::fitCurve(curve(slope, 12), true);
        ASSERT_TRUE(fit);
        EXPECT_NEAR(fit->slope, slope, 1e-12);
        EXPECT_NEAR(fit->at1, 1, 1e-12);
        EXPECT_LT(fit->slopeSe, 1e-6);
        EXPECT_EQ(fit->points, 12);
    }
}

TEST(FitCurve, StatedIntervalHoldsForMonteCarloCurves)
{
    std::mt19937_64 random(11);
    std::vector<double> p;
    tests::Moments slopes;
    for (int i = 0; i < 1500; ++i) {
        const auto fit = app::fitCurve(simulated(random, 60, 13), true);
        ASSERT_TRUE(fit);
        p.push_back(tests::studentTwoSidedP((fit->slope + 0.5) / fit->slopeSe, fit->points - 2));
        slopes.add(fit->slope);
    }
    EXPECT_GT(tests::kolmogorovUniformP(p), tests::kLevel);
    const tests::Comparison mean = tests::againstExact(slopes, -0.5);
    EXPECT_LT(std::abs(mean.z), tests::kScore);
    EXPECT_LT(mean.detectable, 0.03);
}

TEST(FitCurve, StatedIntervalIsSafeForIndependentNoise)
{
    std::mt19937_64 random(12);
    std::normal_distribution<double> normal;
    int outside = 0;
    constexpr int kTrials = 2000;
    for (int i = 0; i < kTrials; ++i) {
        auto points = curve(-0.5, 12);
        for (auto& point : points) point.estimated *= std::exp(0.05 * normal(random));
        const auto fit = app::fitCurve(points, false);
        ASSERT_TRUE(fit);
        outside +=
            tests::studentTwoSidedP((fit->slope + 0.5) / fit->slopeSe, fit->points - 2) < 0.05;
    }
    // At most five per cent, with a margin of 4.21 standard deviations of the count.
    EXPECT_LT(outside, 0.05 * kTrials + tests::kScore * std::sqrt(0.05 * 0.95 * kTrials));
}

TEST(FitCurve, LooksAtTheEndOfTheCurve)
{
    auto points = curve(-0.5, 40);
    for (size_t i = 0; i < 20; ++i) points[i].rmse = 5;  // noise of a beginning that is long past
    const auto fit = app::fitCurve(points, true);
    ASSERT_TRUE(fit);
    EXPECT_NEAR(fit->slope, -0.5, 1e-9);
}

TEST(FitCurve, TooLittleIsNothing)
{
    EXPECT_FALSE(app::fitCurve({}, true));
    EXPECT_FALSE(app::fitCurve(curve(-0.5, 2), true));
    auto close = curve(-0.5, 3);
    close[1].seconds = close[0].seconds * 1.1;
    close[2].seconds = close[0].seconds * 1.4;
    EXPECT_FALSE(app::fitCurve(close, true));
    close[2].seconds = close[0].seconds * 1.6;
    EXPECT_TRUE(app::fitCurve(close, true));
    auto broken = curve(-0.5, 5);
    broken[0].rmse = std::nan("");
    broken[1].rmse = 0;
    broken[2].seconds = HUGE_VAL;
    EXPECT_FALSE(app::fitCurve(broken, true));
}

std::optional<double> secondsToError(const std::vector<app::ErrorPoint>& points, bool against,
                                     double target, double noise)
{
    const std::optional<app::Eta> eta = app::etaToError(points, against, target, noise);
    return eta ? std::optional(eta->seconds) : std::nullopt;
}

TEST(SecondsToError, FollowsTheLaw)
{
    const auto points = curve(-0.5, 12);
    const double now = points.back().seconds;
    // Half the error takes four times the time.
    EXPECT_NEAR(secondsToError(points, true, points.back().rmse / 2, 0).value(), 3 * now, 1e-9);
    EXPECT_EQ(secondsToError(points, true, points.back().rmse * 1.01, 0).value(), 0);
    EXPECT_FALSE(secondsToError(points, true, 0, 0));
    EXPECT_FALSE(secondsToError(curve(-0.5, 2), true, 1e-3, 0));
    // A curve that rises still has some end: along the flattest slope that is believed.
    const auto rising = curve(0.3, 12);
    EXPECT_NEAR(secondsToError(rising, true, rising.back().rmse / 2, 0).value(), 15 * now, 1e-9);
}

TEST(SecondsToError, KnowsTheReferencesNoise)
{
    constexpr double kNoise = 0.2;
    auto points = curve(-0.5, 14);
    for (auto& p : points) p.rmse = std::hypot(p.rmse, kNoise);
    EXPECT_FALSE(secondsToError(points, true, kNoise, kNoise));
    EXPECT_FALSE(secondsToError(points, true, 0.1, kNoise));
    const double now = points.back().seconds;
    const double until = secondsToError(points, true, std::hypot(0.5, kNoise), kNoise).value();
    EXPECT_NEAR(until + now, 4, 1e-9);  // the law reaches 0.5 at four seconds
}

TEST(SecondsToError, TheTruthIsInTheInterval)
{
    std::mt19937_64 random(13);
    int inside = 0;
    constexpr int kTrials = 1000;
    for (int i = 0; i < kTrials; ++i) {
        // What the law says from where the curve has got to is the truth: the interval is the
        // slope's.
        const auto points = simulated(random, 400, 13);
        const double target = points.back().rmse / 4;
        const auto eta = app::etaToError(points, true, target, 0);
        ASSERT_TRUE(eta);
        EXPECT_LE(eta->low, eta->seconds);
        EXPECT_GE(eta->high, eta->seconds);
        const double truth = 15 * points.back().seconds;
        inside += eta->low <= truth && truth <= eta->high;
    }
    // 68 per cent for a normal slope, 66 for Student's with eleven degrees of freedom; clamping can
    // only widen.
    const double expected = 1 - tests::studentTwoSidedP(1, 11);
    EXPECT_GT(inside,
              kTrials * expected - tests::kScore * std::sqrt(kTrials * expected * (1 - expected)));
    EXPECT_LT(inside,
              kTrials * expected + tests::kScore * std::sqrt(kTrials * expected * (1 - expected)));
}

TEST(ReferenceNoise, IsTheRootOfTheMeanVariance)
{
    app::Reference reference;
    EXPECT_EQ(app::referenceNoise(reference), 0);
    reference.variance = core::Image(2, 1, 3);
    reference.variance.pixels = {0.01f, 0.03f, 0.05f, 0.03f, 0.03f, NAN};
    EXPECT_NEAR(app::referenceNoise(reference), std::sqrt(0.03), 1e-7);
}

app::Picture picture(std::vector<app::ErrorPoint> points, uint32_t depth = 8)
{
    app::Picture made;
    made.params.method.as<core::PathParams>().maxDepth = depth;
    made.fullSize = {64, 32};
    made.samples = points.empty() ? 1 : points.back().samples;
    made.seconds = points.empty() ? 0.01 : points.back().seconds;
    made.curve = std::move(points);
    return made;
}

TEST(Convergence, KeepsCurvesOfPicturesPast)
{
    app::Convergence convergence;
    convergence.take(picture(curve(-0.5, 3)), "room");
    convergence.take(picture(curve(-0.5, 6)), "room");
    EXPECT_TRUE(convergence.past().empty()) << "the same picture goes on";
    EXPECT_EQ(convergence.present().points.size(), 6u);
    EXPECT_TRUE(convergence.present().against);
    EXPECT_EQ(convergence.present().label, "path, vulkan, depth 8");

    auto preview = picture(curve(-0.5, 1), 3);
    preview.preview = true;
    convergence.take(preview, "room");
    EXPECT_EQ(convergence.present().points.size(), 6u);

    convergence.take(picture(curve(-0.5, 2)), "room");  // fewer samples: it began anew
    ASSERT_EQ(convergence.past().size(), 1u);
    EXPECT_EQ(convergence.past()[0].points.size(), 6u);
    // Other parameters; the curve of two points is dropped
    convergence.take(picture(curve(-0.5, 9), 4), "room");
    EXPECT_EQ(convergence.past().size(), 1u);
    convergence.take(picture(curve(-0.5, 12, 0.2), 4),
                     "room");  // anew, and farther than the old one before anyone looked
    EXPECT_EQ(convergence.past().size(), 2u);
    for (int i = 0; i < 12; ++i)
        convergence.take(picture(curve(-0.5, 5), static_cast<uint32_t>(20 + i)), "room");
    EXPECT_EQ(convergence.past().size(), 8u);
    EXPECT_EQ(convergence.past().back().label, "path, vulkan, depth 30");
    convergence.clearPast();
    EXPECT_TRUE(convergence.past().empty());
    EXPECT_EQ(convergence.present().label, "path, vulkan, depth 31");
}

TEST(Convergence, LimitsDoNotEndACurve)
{
    app::Convergence convergence;
    convergence.take(picture(curve(-0.5, 6)), "room");
    auto further = picture(curve(-0.5, 8));
    further.params.sppLimit = 1000;
    convergence.take(further, "room");
    EXPECT_TRUE(convergence.past().empty());
    EXPECT_EQ(convergence.present().points.size(), 8u);
}

TEST(Convergence, EachSceneAndCameraHasItsCurves)
{
    app::Convergence convergence;
    auto near = picture(curve(-0.5, 6)), far = picture(curve(-0.5, 7));
    far.camera.position.z += 3;
    convergence.take(near, "room");
    convergence.take(far, "room");
    EXPECT_TRUE(convergence.past().empty()) << "a curve of another camera is no rival";
    EXPECT_EQ(convergence.present().points.size(), 7u);
    convergence.take(near, "room");  // back again, anew
    ASSERT_EQ(convergence.past().size(), 1u);
    EXPECT_EQ(convergence.past()[0].points.size(), 6u);
    convergence.take(near, "hall");
    EXPECT_TRUE(convergence.past().empty()) << "the same camera in another scene";
    convergence.take(far, "room");
    ASSERT_EQ(convergence.past().size(), 1u);
    EXPECT_EQ(convergence.past()[0].points.size(), 7u);
    convergence.clearPast();
    EXPECT_TRUE(convergence.past().empty());
    convergence.take(near, "room");
    EXPECT_EQ(convergence.past().size(), 2u) << "only those on show were to be forgotten";

    for (int i = 0; i < 100; ++i) {  // not without end
        far.camera.position.z += 1;
        convergence.take(far, "room");
    }
    convergence.take(near, "room");
    EXPECT_TRUE(convergence.past().empty()) << "what was seen a hundred views ago is forgotten";
}

TEST(Convergence, AReferenceThatWasDroppedCountsNoMore)
{
    app::Convergence convergence;
    auto points = curve(-0.5, 8);
    ASSERT_GT(points.back().rmse, 0);
    convergence.take(picture(points), "room");
    EXPECT_TRUE(convergence.present().against);
    points = curve(-0.5, 9);
    points.back().rmse = 0;
    points.back().estimated = 0.1;
    convergence.take(picture(points), "room");
    EXPECT_EQ(convergence.present().points.size(), 9u);
    EXPECT_FALSE(convergence.present().against);
}

}  // namespace
