// T30: FLIP against a second, direct computation in double (two-dimensional kernels, no
// separation), against values of the authors' program for the same pairs, and against properties
// that it has by construction.
#include "core/image/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "core/image/metrics.h"
#include "tests/support/statistics/image_mean.h"

namespace core {
namespace {

using std::numbers::pi;
using tests::meanOf;

using Color = std::array<double, 3>;

Image coloured(glm::vec3 color, uint32_t width = 8, uint32_t height = 8)
{
    Image image(width, height, 3);
    for (size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = color[int(i % 3)];
    return image;
}

/// Structure and noise of values in 1/256, so that single and double precision start from the same
/// numbers.
Image pattern(uint32_t width, uint32_t height, uint32_t seed, uint32_t noise)
{
    std::mt19937 random(seed);
    Image image(width, height, 3);
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x) {
            const uint32_t base[3] = {x * 200 / width, y * 180 / height, (x / 6 + y / 5) % 2 * 160};
            for (uint32_t c = 0; c < 3; ++c)
                image.at(x, y)[c] = float(base[c] + 20 + (noise ? random() % noise : 0)) / 256.0f;
        }
    return image;
}

// --- the direct path: everything from the 2020 paper, in the order of the paper

Color toXyzRelative(Color rgb)
{
    // Rows of the matrix of linear sRGB over those of its white.
    static const double m[3][3] = {
        {10135552. / 24577794, 8788810. / 24577794, 4435075. / 24577794},
        {2613072. / 12288897, 8788810. / 12288897, 887015. / 12288897},
        {1425312. / 73733382, 8788810. / 73733382, 70074185. / 73733382}};
    Color result{};
    for (size_t i = 0; i < 3; ++i)
        result[i] = (m[i][0] * rgb[0] + m[i][1] * rgb[1] + m[i][2] * rgb[2]) /
                    (m[i][0] + m[i][1] + m[i][2]);
    return result;
}

/// Linear RGB with the given relative XYZ, by Cramer's rule.
Color fromXyzRelative(Color t)
{
    const Color columns[3] = {toXyzRelative({1, 0, 0}), toXyzRelative({0, 1, 0}),
                              toXyzRelative({0, 0, 1})};
    const auto determinant = [](const Color& a, const Color& b, const Color& c) {
        return a[0] * (b[1] * c[2] - b[2] * c[1]) - b[0] * (a[1] * c[2] - a[2] * c[1]) +
               c[0] * (a[1] * b[2] - a[2] * b[1]);
    };
    const double all = determinant(columns[0], columns[1], columns[2]);
    return {determinant(t, columns[1], columns[2]) / all,
            determinant(columns[0], t, columns[2]) / all,
            determinant(columns[0], columns[1], t) / all};
}

Color huntLab(Color rgb)
{
    Color f = toXyzRelative(rgb);
    for (double& t : f) t = t > 216.0 / 24389 ? std::pow(t, 1.0 / 3) : t * 841 / 108 + 4.0 / 29;
    const double lightness = 116 * f[1] - 16;
    return {lightness, lightness * 5 * (f[0] - f[1]), lightness * 2 * (f[1] - f[2])};
}

double hyabDistance(Color a, Color b)
{
    return std::abs(a[0] - b[0]) +
           std::sqrt((a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

double colorTerm(Color a, Color b)
{
    const double largest = std::pow(hyabDistance(huntLab({0, 1, 0}), huntLab({0, 0, 1})), 0.7);
    const double error = std::pow(hyabDistance(huntLab(a), huntLab(b)), 0.7);
    return error < 0.4 * largest ? 0.95 / (0.4 * largest) * error
                                 : 0.95 + (error - 0.4 * largest) / (0.6 * largest) * 0.05;
}

struct DirectFlip {
    int width, height;
    double ppd;

    /// sum over offsets of weight(dx, dy) * value there, the edge going on beyond the edge.
    double filter(const std::vector<double>& values, int x, int y, int radius,
                  const std::function<double(int, int)>& weight) const
    {
        double sum = 0;
        for (int dy = -radius; dy <= radius; ++dy)
            for (int dx = -radius; dx <= radius; ++dx)
                sum += weight(dx, dy) * values[size_t(std::clamp(y + dy, 0, height - 1) * width +
                                                      std::clamp(x + dx, 0, width - 1))];
        return sum;
    }

    /// A table of weights over the square, for repeated use.
    static std::vector<double> table(int radius, const std::function<double(int, int)>& weight)
    {
        std::vector<double> values;
        for (int dy = -radius; dy <= radius; ++dy)
            for (int dx = -radius; dx <= radius; ++dx) values.push_back(weight(dx, dy));
        return values;
    }

    std::vector<Color> filterColors(const std::vector<Color>& rgb) const
    {
        const int radius = int(std::ceil(3 * std::sqrt(0.04 / (2 * pi * pi)) * ppd));
        const double parameters[3][4] = {
            {1, 0.0047, 0, 1e-5}, {1, 0.0053, 0, 1e-5}, {34.1, 0.04, 13.5, 0.025}};
        std::vector<Color> result(rgb.size());
        for (size_t channel = 0; channel < 3; ++channel) {
            const double* p = parameters[channel];
            std::vector<double> weights = table(radius, [&](int dx, int dy) {
                const double z = (dx * dx + dy * dy) / (ppd * ppd);
                return p[0] * std::sqrt(pi / p[1]) * std::exp(-pi * pi * z / p[1]) +
                       p[2] * std::sqrt(pi / p[3]) * std::exp(-pi * pi * z / p[3]);
            });
            double total = 0;
            for (const double w : weights) total += w;
            std::vector<double> values;
            for (const Color& c : rgb) {
                const Color t = toXyzRelative(c);
                values.push_back(channel == 0   ? 116 * t[1] - 16
                                 : channel == 1 ? 500 * (t[0] - t[1])
                                                : 200 * (t[1] - t[2]));
            }
            const int side = 2 * radius + 1;
            for (int i = 0; i < width * height; ++i)
                result[size_t(i)][channel] =
                    filter(values, i % width, i / width, radius, [&](int dx, int dy) {
                        return weights[size_t((dy + radius) * side + dx + radius)] / total;
                    });
        }
        for (Color& c : result) {
            const double y = (c[0] + 16) / 116;
            c = fromXyzRelative({y + c[1] / 500, y, y - c[2] / 200});
            for (double& v : c) v = std::clamp(v, 0.0, 1.0);
        }
        return result;
    }

    /// Length of the gradient of `order` 1 (edges) or 2 (points) of the luminance.
    std::vector<double> features(const std::vector<Color>& rgb, int order) const
    {
        const double sigma = 0.041 * ppd;
        const int radius = int(std::ceil(3 * sigma)), side = 2 * radius + 1;
        std::vector<double> weights = table(radius, [&](int dx, int dy) {
            const double g = std::exp(-(dx * dx + dy * dy) / (2 * sigma * sigma));
            return order == 1 ? -dx * g : (dx * dx / (sigma * sigma) - 1) * g;
        });
        double positive = 0, negative = 0;
        for (const double w : weights) (w > 0 ? positive : negative) += std::abs(w);
        for (double& w : weights) w /= w > 0 ? positive : negative;
        std::vector<double> luminance, result;
        for (const Color& c : rgb) luminance.push_back(toXyzRelative(c)[1]);
        for (int i = 0; i < width * height; ++i) {
            const double across =
                filter(luminance, i % width, i / width, radius, [&](int dx, int dy) {
                    return weights[size_t((dy + radius) * side + dx + radius)];
                });
            const double down =
                filter(luminance, i % width, i / width, radius, [&](int dx, int dy) {
                    return weights[size_t((dx + radius) * side + dy + radius)];
                });
            result.push_back(std::sqrt(across * across + down * down));
        }
        return result;
    }

    std::vector<double> operator()(const std::vector<Color>& a, const std::vector<Color>& b) const
    {
        const std::vector<Color> seenA = filterColors(a), seenB = filterColors(b);
        const std::vector<double> edgesA = features(a, 1), edgesB = features(b, 1);
        const std::vector<double> pointsA = features(a, 2), pointsB = features(b, 2);
        std::vector<double> errors;
        for (size_t i = 0; i < a.size(); ++i) {
            const double feature =
                std::max(std::abs(edgesA[i] - edgesB[i]), std::abs(pointsA[i] - pointsB[i]));
            errors.push_back(
                std::pow(colorTerm(seenA[i], seenB[i]), 1 - std::sqrt(feature / std::sqrt(2.0))));
        }
        return errors;
    }
};

std::vector<Color> colorsOf(const Image& image, const std::function<double(double)>& curve)
{
    std::vector<Color> colors;
    for (size_t i = 0; i < image.pixels.size(); i += 3)
        colors.push_back({curve(double(image.pixels[i])), curve(double(image.pixels[i + 1])),
                          curve(double(image.pixels[i + 2]))});
    return colors;
}

double identity(double x)
{
    return x;
}

// --- tests

TEST(Flip, agreesWithDirectComputation)
{
    const Image reference = pattern(40, 30, 1, 0), image = pattern(40, 30, 2, 40);
    for (const double ppd : {kFlipPixelsPerDegree, 25.0}) {
        const Image map = flipLdr(image, reference, ppd);
        const std::vector<double> direct =
            DirectFlip{40, 30, ppd}(colorsOf(image, identity), colorsOf(reference, identity));
        for (size_t i = 0; i < direct.size(); ++i)
            ASSERT_NEAR(double(map.pixels[i]), direct[i], 1e-7) << i;
        EXPECT_GT(meanOf(map), 0.02);
    }
}

TEST(Flip, hdrAgreesWithDirectComputation)
{
    Image reference = pattern(24, 20, 3, 0), image = pattern(24, 20, 4, 60);
    // Six stops of range, with a bright spot.
    for (float& v : reference.pixels) v = v * v * 4;
    for (float& v : image.pixels) v = v * v * 4;
    for (int c = 0; c < 3; ++c) reference.at(7, 7)[c] = 32;
    std::vector<double> luminances;
    for (const Color& c : colorsOf(reference, identity)) luminances.push_back(toXyzRelative(c)[1]);
    std::sort(luminances.begin(), luminances.end());
    // The luminance that the curve shows at 0.85: found by bisection here.
    const auto aces = [](double x) {
        return std::clamp(x * 0.6 * (2.51 * 0.6 * x + 0.03) /
                              (x * 0.6 * (2.43 * 0.6 * x + 0.59) + 0.14),
                          0.0, 1.0);
    };
    double low = 0, high = 100;
    for (int i = 0; i < 200; ++i)
        (aces(0.5 * (low + high)) < 0.85 ? low : high) = 0.5 * (low + high);
    const size_t half = luminances.size() / 2;
    const double start = std::log2(low / luminances.back());
    const double stop = std::log2(low / (0.5 * (luminances[half - 1] + luminances[half])));
    const int count = int(std::ceil(stop - start));
    ASSERT_GE(count, 3);
    std::vector<double> largest(luminances.size(), 0.0);
    for (int i = 0; i < count; ++i) {
        const double scale = std::exp2(start + (stop - start) * i / (count - 1));
        const auto show = [&](double x) { return aces(scale * x); };
        const std::vector<double> errors = DirectFlip{24, 20, kFlipPixelsPerDegree}(
            colorsOf(image, show), colorsOf(reference, show));
        for (size_t p = 0; p < errors.size(); ++p) largest[p] = std::max(largest[p], errors[p]);
    }
    const FlipResult result = flipHdr(image, reference);
    EXPECT_NEAR(result.exposures.start, start, 1e-9);
    EXPECT_NEAR(result.exposures.stop, stop, 1e-9);
    EXPECT_EQ(result.exposures.count, count);
    double mean = 0;
    for (size_t p = 0; p < largest.size(); ++p) {
        ASSERT_NEAR(double(result.map.pixels[p]), largest[p], 1e-7) << p;
        mean += largest[p] / double(largest.size());
    }
    EXPECT_NEAR(result.mean, mean, 1e-9);
}

TEST(Flip, valuesOfTheAuthorsProgram)
{
    // Uniform pairs, linear RGB; twelve digits of the authors' Python program (2020, default
    // viewer).
    const auto flip = [](glm::vec3 a, glm::vec3 b) {
        return meanOf(flipLdr(coloured(a), coloured(b)));
    };
    EXPECT_NEAR(flip({0, 0, 0}, {1, 1, 1}), 0.967379762046, 1e-6);
    EXPECT_NEAR(flip({0, 1, 0}, {0, 0, 1}), 1.0, 1e-6);
    EXPECT_NEAR(flip({0.5f, 0.5f, 0.5f}, {0.6f, 0.5f, 0.4f}), 0.280887534870, 1e-6);
    EXPECT_NEAR(flip({0.2f, 0.2f, 0.2f}, {0.21f, 0.2f, 0.2f}), 0.050462753936, 1e-6);
}

TEST(Flip, structuredPairOfTheAuthorsProgram)
{
    const int width = 48, height = 40;
    Image reference(48, 40, 3), image(48, 40, 3), brightReference = reference, bright = reference;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double r[3] = {x / (width - 1.0), y / (height - 1.0),
                                 (x / 6 + y / 5) % 2 * 0.8 + 0.1};
            const bool inside = (x - 20) * (x - 20) + (y - 15) * (y - 15) < 60;
            const double t[3] = {inside ? 0.9 * r[0] + 0.05 : r[0],
                                 r[1] * (0.9 + 0.1 * ((x * 7 + y * 13) % 11) / 10),
                                 x > 30 ? r[2] * 0.7 : r[2]};
            for (int c = 0; c < 3; ++c) {
                reference.at(uint32_t(x), uint32_t(y))[c] = float(r[c]);
                image.at(uint32_t(x), uint32_t(y))[c] = float(t[c]);
                brightReference.at(uint32_t(x), uint32_t(y))[c] = float(20 * r[c] * r[c]);
                bright.at(uint32_t(x), uint32_t(y))[c] = float(20 * t[c] * t[c]);
            }
        }
    const Image map = flipLdr(image, reference);
    EXPECT_NEAR(meanOf(map), 0.208046687065, 1e-6);
    EXPECT_NEAR(double(*map.at(20, 15)), 0.138107168184, 1e-6);
    EXPECT_NEAR(meanOf(flipLdr(image, reference, 30)), 0.206705607412, 1e-6);
    EXPECT_NEAR(flipHdr(bright, brightReference).mean, 0.184865874908, 1e-6);
}

TEST(Flip, equalImagesDoNotDiffer)
{
    const Image image = pattern(31, 17, 5, 50);
    for (const float v : flipLdr(image, image).pixels) EXPECT_EQ(v, 0.0f);
    const FlipResult hdr = flipHdr(image, image);
    EXPECT_EQ(hdr.mean, 0);
}

TEST(Flip, symmetricAndWithinZeroAndOne)
{
    const Image a = pattern(33, 21, 6, 200), b = pattern(33, 21, 7, 230);
    const Image ab = flipLdr(a, b), ba = flipLdr(b, a);
    for (size_t i = 0; i < ab.pixels.size(); ++i) {
        EXPECT_EQ(ab.pixels[i], ba.pixels[i]);
        EXPECT_GE(ab.pixels[i], 0.0f);
        EXPECT_LE(ab.pixels[i], 1.0f);
    }
}

TEST(Flip, mirroredImagesGiveTheMirroredMap)
{
    const auto mirrored = [](const Image& image) {
        Image result = image;
        for (uint32_t y = 0; y < image.height; ++y)
            for (uint32_t x = 0; x < image.width; ++x)
                for (uint32_t c = 0; c < image.channels; ++c)
                    result.at(x, y)[c] = image.at(image.width - 1 - x, image.height - 1 - y)[c];
        return result;
    };
    const Image a = pattern(26, 19, 8, 100), b = pattern(26, 19, 9, 100);
    const Image expected = mirrored(flipLdr(a, b));
    const Image map = flipLdr(mirrored(a), mirrored(b));
    for (size_t i = 0; i < map.pixels.size(); ++i)
        EXPECT_NEAR(map.pixels[i], expected.pixels[i], 1e-6f);
}

TEST(Flip, hdrDoesNotDependOnTheUnit)
{
    Image a = pattern(26, 19, 10, 100), b = pattern(26, 19, 11, 100);
    const double mean = flipHdr(a, b).mean;
    EXPECT_GT(mean, 0.01);
    for (float& v : a.pixels) v *= 1024;
    for (float& v : b.pixels) v *= 1024;
    EXPECT_NEAR(flipHdr(a, b).mean, mean, 1e-9);
}

TEST(Flip, seesWhatNoiseHides)
{
    // More noise, more error; a difference in the dark counts although it is small in absolute
    // terms.
    const Image reference = pattern(40, 30, 12, 0);
    double before = 0;
    for (const uint32_t noise : {4u, 16u, 60u}) {
        const double mean = flipHdr(pattern(40, 30, 13, noise), reference).mean;
        EXPECT_GT(mean, before);
        before = mean;
    }
    Image dark = coloured(glm::vec3(0.01f), 40, 30), lit = dark;
    for (uint32_t x = 0; x < 8; ++x)
        for (uint32_t y = 0; y < 8; ++y)
            for (int c = 0; c < 3; ++c) dark.at(x, y)[c] = lit.at(x, y)[c] = 50;
    *lit.at(30, 20) = 0.02f;
    EXPECT_GT(*flipHdr(lit, dark).map.at(30, 20), 0.1f);
}

TEST(Flip, blackImagesHaveAnAnswer)
{
    const Image black = coloured(glm::vec3(0)), grey = coloured(glm::vec3(0.5f));
    EXPECT_EQ(flipHdr(black, black).mean, 0);
    const FlipResult lit = flipHdr(grey, black);
    EXPECT_EQ(lit.exposures.start, 0);
    EXPECT_EQ(lit.exposures.stop, 0);
    EXPECT_GT(lit.mean, 0.5);
    EXPECT_GT(flipHdr(black, grey).mean, 0.5);
    // Median zero: a third of the pixels is lit.
    Image mostlyBlack = coloured(glm::vec3(0), 9, 9);
    for (uint32_t y = 0; y < 3; ++y)
        for (uint32_t x = 0; x < 9; ++x)
            for (int c = 0; c < 3; ++c) mostlyBlack.at(x, y)[c] = float(1 + x);
    const FlipExposures range = flipExposures(mostlyBlack);
    EXPECT_NEAR(range.stop - range.start, std::log2(9.0 / 5.0), 1e-6);
    EXPECT_EQ(range.count, 2);
    EXPECT_EQ(flipHdr(mostlyBlack, mostlyBlack).mean, 0);
}

TEST(Flip, oddPixels)
{
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float inf = std::numeric_limits<float>::infinity();
    const Image reference = pattern(30, 30, 14, 20);
    Image image = reference;
    *image.at(3, 3) = nan;
    image.at(20, 25)[2] = inf;
    const FlipResult result = flipHdr(image, reference);
    EXPECT_EQ(*result.map.at(3, 3), 1.0f);
    EXPECT_EQ(*result.map.at(20, 25), 1.0f);
    EXPECT_EQ(*result.map.at(28, 5), 0.0f);
    for (const float v : result.map.pixels) ASSERT_TRUE(v >= 0 && v <= 1);
    Image huge = reference;
    huge.at(1, 1)[0] = 3e38f;
    const FlipResult range = flipHdr(reference, huge);
    EXPECT_LE(range.exposures.count, 40);
    EXPECT_TRUE(range.mean >= 0 && range.mean <= 1);
    EXPECT_EQ(flipHdr(coloured({-1, -2, 0}), coloured({0, 0, 0})).mean, 0);
}

TEST(Flip, stopsWhenItIsTold)
{
    const Image reference = pattern(30, 30, 14, 20);
    std::stop_source stop;
    stop.request_stop();
    EXPECT_EQ(
        flipHdr(reference, pattern(30, 30, 14, 21), kFlipPixelsPerDegree, stop.get_token()).mean, 0)
        << "no exposure was looked at";
}

}  // namespace
}  // namespace core
