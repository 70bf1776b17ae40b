// The picture as a weighted mean of iterations, above a film that knows only their sum: iterations
// are told apart, weights do what they say, crossed ones leave no bias, and variance and weight are
// those of what is shown.
#include "core/methods/iteration_pictures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/pcg32.h"
#include "tests/support/statistics/image_mean.h"
#include "tests/support/statistics/stats.h"

namespace {

using tests::meanOf;

using core::Combine, core::CombineFrom, core::CombineOver, core::GuidedParams;

constexpr uint32_t kPictureWidth = 24, kPictureHeight = 16;

/// A film that gets log-normal samples of mean one, as a guided renderer would fill it.
class Renders {
public:
    Renders(const GuidedParams& params, uint64_t seed) : random_(seed)
    {
        film_.reset(kPictureWidth, kPictureHeight);
        pictures_.begin(params);
    }

    /// Samples with that sigma, of the present iteration.
    void render(uint64_t samples, double sigma)
    {
        const uint64_t end = film_.samples + samples;
        while (film_.samples < end) {
            const uint64_t stop = std::min(pictures_.nextPart(film_.samples), end);
            for (; film_.samples < stop; ++film_.samples)
                for (size_t i = 0; i < film_.sum.size(); ++i)
                    film_.add(i, {sample(sigma), sample(sigma), sample(sigma)}, film_.counters);
            if (stop == pictures_.nextPart(stop - 1)) pictures_.note(film_.estimate(false), false);
        }
    }
    void discount(double weight) { pictures_.discount(film_.estimate(false), weight); }
    void endIteration() { pictures_.note(film_.estimate(false), true); }

    const core::IterationPictures& pictures() const { return pictures_; }
    core::Film& film() { return film_; }
    core::Estimate picture() const { return pictures_.picture(film_.estimate(false)); }

    float sample(double sigma)
    {
        const double radius = std::sqrt(-2 * std::log(1 - random_()));
        const double normal = radius * std::cos(2 * M_PI * random_());
        return float(std::exp(sigma * normal - sigma * sigma / 2));
    }

private:
    core::Pcg32 random_;
    core::Film film_;
    core::IterationPictures pictures_;
};

GuidedParams combinedBy(Combine by, CombineOver over = CombineOver::picture,
                        CombineFrom from = CombineFrom::own, uint32_t last = 0)
{
    GuidedParams params;
    params.combine = by;
    params.combineOver = over;
    params.combineFrom = from;
    params.combineLast = last;
    return params;
}

/// Mean squared distance from the one that all samples have in the mean.
double errorOfPicture(const core::Image& image)
{
    double sum = 0;
    for (const float x : image.pixels) sum += (double(x) - 1) * (double(x) - 1);
    return sum / double(image.pixels.size());
}

TEST(IterationPictures, AreTheFilmUnlessTheyAreAskedFor)
{
    Renders renders({}, 1);
    EXPECT_FALSE(renders.pictures().isOn());
    renders.render(3, 1);
    renders.endIteration();
    renders.render(2, 1);
    EXPECT_EQ(renders.picture().mean.pixels, renders.film().estimate(false).mean.pixels);
    EXPECT_EQ(renders.pictures().nextPart(3), std::numeric_limits<uint64_t>::max());
    // With equal noise all samples together are what weights by samples give.
    Renders all(combinedBy(Combine::samples, CombineOver::picture, CombineFrom::own, 9), 1);
    all.render(3, 1);
    all.endIteration();
    all.render(2, 1);
    const core::Estimate film = all.film().estimate(false), picture = all.picture();
    for (size_t i = 0; i < film.mean.pixels.size(); ++i) {
        EXPECT_NEAR(picture.mean.pixels[i], film.mean.pixels[i], 1e-5f * film.mean.pixels[i]);
        EXPECT_NEAR(picture.weight.pixels[i / 3], 5, 1e-4);
    }
}

/// The iteration that is to be replaced stays until the next one has as many samples.
TEST(IterationPictures, ShowTheLastOnes)
{
    Renders renders(combinedBy(Combine::samples, CombineOver::picture, CombineFrom::own, 1), 2);
    Renders alone({}, 2);
    renders.render(4, 2);
    renders.endIteration();
    const core::Image first = renders.picture().mean;
    EXPECT_NEAR(first.pixels[7], renders.film().mean().pixels[7], 1e-5);
    renders.render(2, 0.1);
    EXPECT_NEAR(renders.picture().weight.pixels[0], 6, 1e-4);
    renders.render(6, 0.1);
    const core::Estimate last = renders.picture();
    EXPECT_EQ(last.samples, 12u);
    EXPECT_NEAR(last.weight.pixels[0], 8, 1e-4);
    EXPECT_NEAR(errorOfPicture(last.mean), 0.01 / 8, 0.001);
    EXPECT_NEAR(meanOf(last.variance), 0.01 / 8, 0.0003);
    EXPECT_GT(errorOfPicture(renders.film().mean()), 0.1);
}

/// Four noisy samples with the weight of one quiet one each, and of the best weight.
TEST(IterationPictures, CountWhatWasNoisierLess)
{
    constexpr double kNoisy = 1.2, kQuiet = 0.3;
    const double noisy = std::exp(kNoisy * kNoisy) - 1, quiet = std::exp(kQuiet * kQuiet) - 1;
    for (const double weight : {1.0, quiet / noisy}) {
        Renders renders(combinedBy(Combine::trial), 4);
        renders.render(4, kNoisy);
        EXPECT_FALSE(renders.pictures().isOn());
        const core::Image before = renders.film().mean();
        renders.discount(weight);
        EXPECT_TRUE(renders.pictures().isOn());
        const core::Image same = renders.picture().mean;
        for (size_t i = 0; i < same.pixels.size(); ++i)
            EXPECT_NEAR(same.pixels[i], before.pixels[i], 1e-5f * before.pixels[i]);
        renders.render(12, kQuiet);
        const core::Estimate picture = renders.picture();
        const double weights = 4 * weight + 12, squares = 4 * weight * weight;
        const double variance = (squares * noisy + 12 * quiet) / (weights * weights);
        EXPECT_EQ(picture.samples, 16u);
        EXPECT_NEAR(picture.weight.pixels[5], weights * weights / (squares + 12), 1e-3);
        EXPECT_NEAR(errorOfPicture(picture.mean), variance, 0.2 * variance) << weight;
        EXPECT_NEAR(meanOf(picture.variance), variance, 0.2 * variance) << weight;
    }
}

struct Way {
    GuidedParams params;
    double least, most;  // of the error's square beside that of weights by samples
};

/// Of 8, 16 and 32 samples with a noise of 2, 1 and a half: what is gained, and that it is told.
TEST(IterationPictures, FavourTheQuietOnes)
{
    const auto render = [](const GuidedParams& params, uint64_t seed) {
        Renders renders(params, seed);
        double sigma = 1.5;
        for (const uint64_t samples : {1u, 2u, 4u, 8u, 16u}) {
            renders.render(samples, sigma);
            renders.endIteration();
            sigma /= 1.5;
        }
        renders.render(32, sigma);
        return renders.picture();
    };
    double bySamples = 0;
    for (uint64_t seed = 1; seed <= 8; ++seed)
        bySamples += errorOfPicture(render(combinedBy(Combine::samples, CombineOver::picture,
                                                      CombineFrom::own, 60),
                                           seed)
                                        .mean) /
                     8;
    for (const Way& way :
         {Way{combinedBy(Combine::inverseVariance), 0.1, 0.7},
          Way{combinedBy(Combine::ess), 0.1, 1},
          Way{combinedBy(Combine::inverseVariance, CombineOver::pixel, CombineFrom::crossed), 0.1,
              0.9},
          Way{combinedBy(Combine::ess, CombineOver::tile), 0.1, 1}}) {
        tests::Moments means;
        double error = 0, told = 0;
        for (uint64_t seed = 1; seed <= 8; ++seed) {
            const core::Estimate e = render(way.params, seed);
            error += errorOfPicture(e.mean) / 8;
            told += meanOf(e.variance) / 8;
            means.add(meanOf(e.mean));
        }
        const std::string name(core::enumName(way.params.combine));
        EXPECT_GT(error, way.least * bySamples) << name;
        EXPECT_LT(error, way.most * bySamples) << name;
        EXPECT_NEAR(told / error, 1, 0.3) << name;
        const bool isCrossed = way.params.combineFrom == CombineFrom::crossed;
        EXPECT_NEAR(means.mean(), 1, isCrossed ? 0.01 : 0.02) << name;
    }
}

/// Weights of each pixel from its own samples darken; from the other half they do not.
TEST(IterationPictures, CrossedWeightsLeaveNoBias)
{
    for (const CombineFrom from : {CombineFrom::own, CombineFrom::crossed}) {
        tests::Moments means;
        for (uint64_t seed = 1; seed <= 60; ++seed) {
            Renders renders(combinedBy(Combine::inverseVariance, CombineOver::pixel, from), seed);
            renders.render(8, 1.2);
            renders.endIteration();
            renders.render(16, 1.2);
            means.add(meanOf(renders.picture().mean));
        }
        const double error = std::sqrt(means.varianceOfMean());
        EXPECT_LT(error, 0.005);
        if (from == CombineFrom::own)
            EXPECT_LT(means.mean(), 0.95);
        else
            EXPECT_LT(std::abs(means.mean() - 1), tests::kScore * error);
    }
}

TEST(IterationPictures, HalvesAreEqual)
{
    const GuidedParams params = combinedBy(Combine::ess, CombineOver::pixel, CombineFrom::crossed);
    core::IterationPictures pictures;
    pictures.begin(params);
    std::vector<uint64_t> parts;
    for (uint64_t at = 0; at < 60;) parts.push_back(at = pictures.nextPart(at));
    EXPECT_EQ(parts, (std::vector<uint64_t>{1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64}));
}

/// Pixels that are ahead of others in a step that was cut short.
TEST(IterationPictures, KnowHowFarEachPixelIs)
{
    Renders renders(combinedBy(Combine::inverseVariance), 3);
    renders.render(4, 1);
    renders.endIteration();
    renders.render(4, 1);
    core::FilmCounters dropped;
    for (int k = 0; k < 4; ++k) renders.film().add(5, {1, 1, 1}, dropped);
    const core::Estimate e = renders.picture();
    EXPECT_GT(e.weight.pixels[5], e.weight.pixels[6]);
    EXPECT_LE(e.weight.pixels[5], 12.001f);
    for (const float v : e.mean.pixels) EXPECT_TRUE(v >= 0 && std::isfinite(v));
}

}  // namespace
