// Sums in double, kept per row or tile and added in order: the numbers do not depend on the
// threads.
//   Welch, "The Generalization of Student's Problem", 1947; Satterthwaite 1946 for the degrees of
//   freedom; Wallace, "Bounds on Normal Approximations to Student's and the Chi-Square
//   Distributions", 1959.
#include "core/image/metrics.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/constants.hpp>

#include "core/base/check.h"
#include "core/base/parallel.h"

namespace core {

namespace {

constexpr double kScore = 4.21, kPowerScore = 2.33;  // family-wise 1 % over 400 tests; 99 % power

glm::dvec3 colorAt(const Image& image, size_t pixel)
{
    const float* p = &image.pixels[pixel * image.channels];
    return {p[0], p[1], p[2]};
}

bool isFinite(glm::dvec3 v)
{
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

void checkPair(const Image& a, const Image& b)
{
    CHECK(a.width == b.width && a.height == b.height && a.channels >= 3 && b.channels >= 3);
}

/// Sums over pixels, kept per block of rows so that the order of addition is fixed.
struct ErrorSums {
    double squares = 0, relativeSquares = 0;
    glm::dvec3 image{0}, reference{0};
    uint64_t pixels = 0;

    void add(glm::dvec3 a, glm::dvec3 r)
    {
        const glm::dvec3 d = a - r, square = d * d;
        squares += square.x + square.y + square.z;
        const glm::dvec3 relative = square / (r * r + kRelMseFloor);
        relativeSquares += relative.x + relative.y + relative.z;
        image += a;
        reference += r;
        ++pixels;
    }
    void add(const ErrorSums& other)
    {
        squares += other.squares;
        relativeSquares += other.relativeSquares;
        image += other.image;
        reference += other.reference;
        pixels += other.pixels;
    }
};

/// Sums of one estimate over a set of pixels.
struct RegionSums {
    glm::dvec3 mean{0}, variance{0}, varianceSquared{0};

    void add(glm::dvec3 m, glm::dvec3 v)
    {
        mean += m;
        variance += v;
        varianceSquared += v * v;
    }
    void add(const RegionSums& other)
    {
        mean += other.mean;
        variance += other.variance;
        varianceSquared += other.varianceSquared;
    }
};

struct PairSums {
    RegionSums a, b;
    uint64_t pixels = 0;

    void add(const PairSums& other)
    {
        a.add(other.a);
        b.add(other.b);
        pixels += other.pixels;
    }
};

/// Welch and Satterthwaite: degrees of freedom of a sum of variances, each estimated from n
/// samples.
double degreesOfFreedom(const PairSums& sums, uint64_t samplesA, uint64_t samplesB, int channel)
{
    const auto part = [&](const RegionSums& region, uint64_t samples) {
        return samples > 1 ? region.varianceSquared[channel] / double(samples - 1) : 0.0;
    };
    const double variance = sums.a.variance[channel] + sums.b.variance[channel];
    const double spread = part(sums.a, samplesA) + part(sums.b, samplesB);
    return spread > 0 ? variance * variance / spread : std::numeric_limits<double>::infinity();
}

/// Normal score of the same tail as Student's t, good to 1 % of its probability above ten degrees
/// of freedom.
double normalScore(double t, double degrees)
{
    if (!std::isfinite(degrees)) return t;
    const double size =
        (8 * degrees + 1) / (8 * degrees + 3) * std::sqrt(degrees * std::log1p(t * t / degrees));
    return std::copysign(size, t);
}

WelchScore scoreOf(const PairSums& sums, uint64_t samplesA, uint64_t samplesB, int channel)
{
    WelchScore score;
    const double difference = sums.a.mean[channel] - sums.b.mean[channel];
    const double variance = sums.a.variance[channel] + sums.b.variance[channel];
    if (variance > 0) {
        score.degreesOfFreedom = degreesOfFreedom(sums, samplesA, samplesB, channel);
        const double t = difference / std::sqrt(variance);
        score.z = std::clamp(normalScore(t, score.degreesOfFreedom), -kCertain, kCertain);
    } else if (difference != 0) {
        score.z = std::copysign(kCertain, difference);
    }
    score.p = twoSidedP(score.z);
    return score;
}

PairSums sumTile(const MeanAndVariance& a, const MeanAndVariance& b, const Tile& tile)
{
    PairSums sums;
    for (uint32_t y = tile.y0; y < tile.y1; ++y)
        for (uint32_t x = tile.x0; x < tile.x1; ++x) {
            const size_t pixel = size_t(y) * a.mean.width + x;
            const glm::dvec3 meanA = colorAt(a.mean, pixel), varianceA = colorAt(a.variance, pixel);
            const glm::dvec3 meanB = colorAt(b.mean, pixel), varianceB = colorAt(b.variance, pixel);
            if (!isFinite(meanA + varianceA + meanB + varianceB)) continue;
            sums.a.add(meanA, varianceA);
            sums.b.add(meanB, varianceB);
            ++sums.pixels;
        }
    return sums;
}

bool hasContent(const PairSums& sums)
{
    return sums.a.variance + sums.b.variance != glm::dvec3(0) || sums.a.mean != sums.b.mean;
}

/// Fills in the results over all tiles.
void summarize(WelchResult& result)
{
    std::vector<double> green;
    double smallest = 1;
    for (const WelchTile& tile : result.tiles) {
        for (const WelchScore& score : tile.channels) {
            if (std::abs(score.z) > std::abs(result.largestTileZ)) result.largestTileZ = score.z;
            smallest = std::min(smallest, score.p);
        }
        const WelchScore& middle = tile.channels[1];
        if (middle.degreesOfFreedom == 0 && middle.z == 0) continue;  // black: no information
        green.push_back(middle.p);
        const size_t bin = std::min(size_t(green.back() * 20), size_t(19));
        ++result.histogram[bin];
    }
    const double count = 3 * double(result.tiles.size());
    if (count > 0) result.smallestP = -std::expm1(count * std::log1p(-smallest));
    result.uniformP = kolmogorovUniformP(std::move(green));
}

}  // namespace

ImageErrors imageErrors(const Image& image, const Image& reference)
{
    checkPair(image, reference);
    const size_t rows = image.height, width = image.width;
    std::vector<ErrorSums> perRow(rows);
    parallelFor(rows, 16, [&](size_t begin, size_t end) {
        for (size_t y = begin; y < end; ++y)
            for (size_t x = 0; x < width; ++x) {
                const glm::dvec3 a = colorAt(image, y * width + x);
                const glm::dvec3 r = colorAt(reference, y * width + x);
                if (isFinite(a) && isFinite(r)) perRow[y].add(a, r);
            }
    });
    ErrorSums sums;
    for (const ErrorSums& row : perRow) sums.add(row);
    ImageErrors errors;
    errors.nonFinitePixels = rows * width - sums.pixels;
    if (sums.pixels == 0) return errors;
    const double count = double(sums.pixels);
    errors.rmse = std::sqrt(sums.squares / (3 * count));
    errors.relMse = sums.relativeSquares / (3 * count);
    errors.meanImage = sums.image / count;
    errors.meanReference = sums.reference / count;
    const glm::dvec3 shift = errors.meanImage - errors.meanReference;
    errors.meanSignedError = (shift.x + shift.y + shift.z) / 3;
    return errors;
}

WelchResult welchTest(const MeanAndVariance& a, const MeanAndVariance& b, uint32_t tile)
{
    checkPair(a.mean, b.mean);
    checkPair(a.mean, a.variance);
    checkPair(b.mean, b.variance);
    CHECK(tile > 0);
    const uint32_t columns = (a.mean.width + tile - 1) / tile;
    const uint32_t rows = (a.mean.height + tile - 1) / tile;
    std::vector<PairSums> sums(size_t(columns) * rows);
    parallelTiles(a.mean.width, a.mean.height, tile, [&](const Tile& t) {
        sums[size_t(t.y0 / tile) * columns + t.x0 / tile] = sumTile(a, b, t);
    });
    WelchResult result;
    PairSums whole;
    for (size_t i = 0; i < sums.size(); ++i) {
        whole.add(sums[i]);
        if (!hasContent(sums[i])) continue;
        WelchTile entry{uint32_t(i % columns) * tile, uint32_t(i / columns) * tile, {}};
        for (int c = 0; c < 3; ++c)
            entry.channels[size_t(c)] = scoreOf(sums[i], a.samples, b.samples, c);
        result.tiles.push_back(entry);
    }
    for (int c = 0; c < 3; ++c) {
        result.image[size_t(c)] = scoreOf(whole, a.samples, b.samples, c);
        const double deviation = std::sqrt(whole.a.variance[c] + whole.b.variance[c]);
        const double mean = std::abs(whole.b.mean[c]);
        result.detectableBias[size_t(c)] =
            mean > 0 ? (kScore + kPowerScore) * deviation / mean : 0.0;
    }
    summarize(result);
    return result;
}

double noiseOf(const Image& variance)
{
    double sum = 0;
    uint64_t count = 0;
    for (const float v : variance.pixels) {
        if (!std::isfinite(v)) continue;
        sum += double(v);
        ++count;
    }
    return count > 0 ? std::sqrt(sum / double(count)) : 0;
}

double twoSidedP(double z)
{
    return std::erfc(std::abs(z) * glm::one_over_root_two<double>());
}

double kolmogorovUniformP(std::vector<double> values)
{
    if (values.empty()) return 1;
    std::sort(values.begin(), values.end());
    const double n = double(values.size());
    double distance = 0;
    for (size_t i = 0; i < values.size(); ++i)
        distance = std::max({distance, values[i] - double(i) / n, double(i + 1) / n - values[i]});
    const double root = std::sqrt(n);
    const double lambda = (root + 0.12 + 0.11 / root) * distance;
    if (lambda < 0.2) return 1;  // the series below does not converge; the answer is 1 to 12 digits
    double p = 0, sign = 1;
    for (int k = 1; k <= 100; ++k) {
        const double term = std::exp(-2.0 * k * k * lambda * lambda);
        p += sign * term;
        sign = -sign;
        if (term < 1e-17) break;
    }
    return std::clamp(2 * p, 0.0, 1.0);
}

}  // namespace core
