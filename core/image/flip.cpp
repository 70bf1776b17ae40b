// FLIP in double. Every filter is a sum of separable Gaussians or derivatives of one, so each costs
// two passes instead of a square of weights; the result is that of the papers.
#include "core/image/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <glm/glm.hpp>
#include <glm/gtc/constants.hpp>

#include "core/base/check.h"
#include "core/base/parallel.h"

namespace core {

namespace {

using glm::dmat3;
using glm::dvec3;

// Names and values of the 2020 paper: exponents and split of the colour error, feature width and
// exponent.
constexpr double kQc = 0.7, kPc = 0.4, kPt = 0.95;
constexpr double kFeatureWidth = 0.082, kQf = 0.5;  // degrees

// Linear Rec.709 to XYZ, columns; exact for the primaries and the white of sRGB (D65).
const dmat3 kToXyz(10135552.0 / 24577794.0, 2613072.0 / 12288897.0, 1425312.0 / 73733382.0,
                   8788810.0 / 24577794.0, 8788810.0 / 12288897.0, 8788810.0 / 73733382.0,
                   4435075.0 / 24577794.0, 887015.0 / 12288897.0, 70074185.0 / 73733382.0);
const dmat3 kFromXyz = glm::inverse(kToXyz);
const dvec3 kWhite = kToXyz * dvec3(1);

/// Opponent space YCxCz: lightness as CIELAB's but linear in light.
dvec3 toOpponent(dvec3 rgb)
{
    const dvec3 t = kToXyz * rgb / kWhite;
    return {116 * t.y - 16, 500 * (t.x - t.y), 200 * (t.y - t.z)};
}

dvec3 fromOpponent(dvec3 c)
{
    const double y = (c.x + 16) / 116;
    return kFromXyz * (dvec3(y + c.y / 500, y, y - c.z / 200) * kWhite);
}

/// CIELAB with chroma scaled by lightness (Hunt's effect): colours of dark pixels differ less.
dvec3 toHuntLab(dvec3 rgb)
{
    const auto f = [](double t) {
        constexpr double kDelta = 6.0 / 29.0;
        return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0 / 29.0;
    };
    const dvec3 t = kToXyz * rgb / kWhite;
    const double lightness = 116 * f(t.y) - 16;
    return {lightness, 0.01 * lightness * 500 * (f(t.x) - f(t.y)),
            0.01 * lightness * 200 * (f(t.y) - f(t.z))};
}

/// HyAB: large colour differences (Abasi, Tehran, Fairchild 2020).
double hyab(dvec3 a, dvec3 b)
{
    const double da = a.y - b.y, db = a.z - b.z;
    return std::abs(a.x - b.x) + std::sqrt(da * da + db * db);
}

/// One value per pixel.
struct Plane {
    int width = 0, height = 0;
    std::vector<double> values;

    Plane(int w, int h) : width(w), height(h), values(size_t(w) * size_t(h)) {}
    double* row(int y) { return &values[size_t(y) * size_t(width)]; }
    const double* row(int y) const { return &values[size_t(y) * size_t(width)]; }
};

/// Weights at offsets -radius .. radius.
using Kernel = std::vector<double>;

/// Convolves rows with `across` and columns with `down`; beyond the edge the edge pixel is
/// repeated.
Plane convolve(const Plane& in, const Kernel& across, const Kernel& down)
{
    const int radiusX = int(across.size() / 2), radiusY = int(down.size() / 2);
    Plane rows(in.width, in.height), out(in.width, in.height);
    parallelFor(size_t(in.height), 16, [&](size_t begin, size_t end) {
        std::vector<double> padded(size_t(in.width + 2 * radiusX));
        for (int y = int(begin); y < int(end); ++y) {
            for (int x = -radiusX; x < in.width + radiusX; ++x)
                padded[size_t(x + radiusX)] = in.row(y)[std::clamp(x, 0, in.width - 1)];
            double* row = rows.row(y);
            for (size_t k = 0; k < across.size(); ++k)
                for (int x = 0; x < in.width; ++x) row[x] += across[k] * padded[size_t(x) + k];
        }
    });
    parallelFor(size_t(in.height), 16, [&](size_t begin, size_t end) {
        for (int y = int(begin); y < int(end); ++y)
            for (int k = -radiusY; k <= radiusY; ++k) {
                const double weight = down[size_t(k + radiusY)];
                const double* from = rows.row(std::clamp(y + k, 0, in.height - 1));
                double* row = out.row(y);
                for (int x = 0; x < in.width; ++x) row[x] += weight * from[x];
            }
    });
    return out;
}

/// exp(-falloff r^2) at offsets in pixels.
Kernel gaussian(int radius, double falloff)
{
    Kernel kernel;
    for (int k = -radius; k <= radius; ++k) kernel.push_back(std::exp(-falloff * k * k));
    return kernel;
}

double sumOf(const Kernel& kernel)
{
    double sum = 0;
    for (const double weight : kernel) sum += weight;
    return sum;
}

Kernel scaled(Kernel kernel, double factor)
{
    for (double& weight : kernel) weight *= factor;
    return kernel;
}

/// One term a sqrt(pi / b) exp(-pi^2 x^2 / b) of a contrast sensitivity function in space, x in
/// degrees.
struct SensitivityTerm {
    double a, b;
};

/// Filters by a sum of such terms, together of weight one. Each is separable, so two dimensions
/// cost two passes.
Plane filterSensitivity(const Plane& in, std::span<const SensitivityTerm> terms,
                        double pixelsPerDegree)
{
    // Three standard deviations of the widest term of all channels (blue-yellow), as the paper has
    // it.
    const double widest = std::sqrt(0.04 / (2 * glm::pi<double>() * glm::pi<double>()));
    const int radius = int(std::ceil(3 * widest * pixelsPerDegree));
    std::vector<Kernel> kernels;
    std::vector<double> weights;
    double total = 0;
    for (const SensitivityTerm& term : terms) {
        const double pi = glm::pi<double>();
        kernels.push_back(gaussian(radius, pi * pi / (term.b * pixelsPerDegree * pixelsPerDegree)));
        weights.push_back(term.a * std::sqrt(pi / term.b));
        total += weights.back() * sumOf(kernels.back()) * sumOf(kernels.back());
    }
    Plane out(in.width, in.height);
    for (size_t i = 0; i < kernels.size(); ++i) {
        const Plane part = convolve(in, scaled(kernels[i], weights[i] / total), kernels[i]);
        for (size_t p = 0; p < out.values.size(); ++p) out.values[p] += part.values[p];
    }
    return out;
}

/// Strength of edges (first derivative of a Gaussian) and points (second) in lightness from 0 to 1.
struct Features {
    Plane edges, points;
};

/// Scales the positive weights to a sum of one and the negative ones to minus one.
Kernel balanced(Kernel kernel)
{
    double positive = 0, negative = 0;
    for (const double weight : kernel) (weight > 0 ? positive : negative) += weight;
    for (double& weight : kernel) weight /= weight > 0 ? positive : -negative;
    return kernel;
}

Plane magnitude(const Plane& x, const Plane& y)
{
    Plane out(x.width, x.height);
    for (size_t p = 0; p < out.values.size(); ++p)
        out.values[p] = std::sqrt(x.values[p] * x.values[p] + y.values[p] * y.values[p]);
    return out;
}

Features detectFeatures(const Plane& lightness, double pixelsPerDegree)
{
    const double sigma = 0.5 * kFeatureWidth * pixelsPerDegree;
    const int radius = int(std::ceil(3 * sigma));
    Kernel smooth = gaussian(radius, 1 / (2 * sigma * sigma));
    Kernel edge = smooth, point = smooth;
    for (int k = -radius; k <= radius; ++k) {
        edge[size_t(k + radius)] *= -k;
        point[size_t(k + radius)] *= k * k / (sigma * sigma) - 1;
    }
    smooth = scaled(smooth, 1 / sumOf(smooth));
    edge = balanced(edge);
    point = balanced(point);
    return {magnitude(convolve(lightness, edge, smooth), convolve(lightness, smooth, edge)),
            magnitude(convolve(lightness, point, smooth), convolve(lightness, smooth, point))};
}

/// What the metric compares of one image.
struct Perceived {
    std::vector<dvec3> colors;  // filtered, CIELAB with Hunt's effect
    Features features;
};

Perceived perceive(const std::vector<dvec3>& rgb, int width, int height, double pixelsPerDegree)
{
    static constexpr std::array<SensitivityTerm, 1> kAchromatic{{{1, 0.0047}}};
    static constexpr std::array<SensitivityTerm, 1> kRedGreen{{{1, 0.0053}}};
    static constexpr std::array<SensitivityTerm, 2> kBlueYellow{{{34.1, 0.04}, {13.5, 0.025}}};
    Plane y(width, height), cx(width, height), cz(width, height), lightness(width, height);
    for (size_t p = 0; p < rgb.size(); ++p) {
        const dvec3 c = toOpponent(rgb[p]);
        y.values[p] = c.x;
        cx.values[p] = c.y;
        cz.values[p] = c.z;
        lightness.values[p] = (c.x + 16) / 116;
    }
    y = filterSensitivity(y, kAchromatic, pixelsPerDegree);
    cx = filterSensitivity(cx, kRedGreen, pixelsPerDegree);
    cz = filterSensitivity(cz, kBlueYellow, pixelsPerDegree);
    Perceived result{std::vector<dvec3>(rgb.size()), detectFeatures(lightness, pixelsPerDegree)};
    parallelFor(rgb.size(), 4096, [&](size_t begin, size_t end) {
        for (size_t p = begin; p < end; ++p) {
            const dvec3 shown = fromOpponent({y.values[p], cx.values[p], cz.values[p]});
            result.colors[p] = toHuntLab(glm::clamp(shown, 0.0, 1.0));
        }
    });
    return result;
}

/// Colour error in [0, 1]: the part below kPc of the largest possible one takes kPt of the range.
double colorError(dvec3 a, dvec3 b)
{
    static const double largest = std::pow(hyab(toHuntLab({0, 1, 0}), toHuntLab({0, 0, 1})), kQc);
    const double error = std::pow(hyab(a, b), kQc), knee = kPc * largest;
    return error < knee ? kPt / knee * error : kPt + (error - knee) / (largest - knee) * (1 - kPt);
}

std::vector<double> combine(const Perceived& a, const Perceived& b)
{
    std::vector<double> errors(a.colors.size());
    parallelFor(errors.size(), 4096, [&](size_t begin, size_t end) {
        for (size_t p = begin; p < end; ++p) {
            const double edge = a.features.edges.values[p] - b.features.edges.values[p];
            const double point = a.features.points.values[p] - b.features.points.values[p];
            const double difference = std::max(std::abs(edge), std::abs(point));
            const double feature = std::pow(difference * glm::one_over_root_two<double>(), kQf);
            errors[p] = std::pow(colorError(a.colors[p], b.colors[p]), 1 - feature);
        }
    });
    return errors;
}

/// Pixels as the ACES fit of Narkowicz shows them (with its usual exposure of 0.6), and its
/// inverse.
struct Aces {
    static constexpr double k0 = 0.6 * 0.6 * 2.51, k1 = 0.6 * 0.03, k3 = 0.6 * 0.6 * 2.43,
                            k4 = 0.6 * 0.59, k5 = 0.14;
    static double show(double x)
    {
        return std::clamp((k0 * x * x + k1 * x) / (k3 * x * x + k4 * x + k5), 0.0, 1.0);
    }
    /// The larger root of show(x) = t.
    static double inverse(double t)
    {
        const double a = k0 - t * k3, b = k1 - t * k4, c = -t * k5;
        return (-b + std::sqrt(b * b - 4 * a * c)) / (2 * a);
    }
};

bool isFinite(const float* p)
{
    return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

/// RGB of every pixel, zero where negative or not finite.
std::vector<dvec3> radianceOf(const Image& image)
{
    std::vector<dvec3> rgb(size_t(image.width) * image.height, dvec3(0));
    for (size_t i = 0; i < rgb.size(); ++i) {
        const float* p = &image.pixels[i * image.channels];
        // Radiance beyond 1e30 shows as white at every exposure, and its square would overflow.
        if (isFinite(p)) rgb[i] = glm::clamp(dvec3(p[0], p[1], p[2]), 0.0, 1e30);
    }
    return rgb;
}

void checkPair(const Image& image, const Image& reference)
{
    CHECK(image.width == reference.width && image.height == reference.height);
    CHECK(image.channels >= 3 && reference.channels >= 3 && image.width > 0 && image.height > 0);
}

/// Median of a list that is not empty; reorders it.
double medianOf(std::vector<double>& values)
{
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    if (values.size() % 2 == 1) return *middle;
    return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

std::vector<dvec3> exposed(const std::vector<dvec3>& radiance, double stops)
{
    const double scale = std::exp2(stops);
    std::vector<dvec3> shown(radiance.size());
    for (size_t p = 0; p < shown.size(); ++p)
        for (int c = 0; c < 3; ++c) shown[p][c] = Aces::show(scale * radiance[p][c]);
    return shown;
}

}  // namespace

Image flipLdr(const Image& image, const Image& reference, double pixelsPerDegree)
{
    checkPair(image, reference);
    const int width = int(image.width), height = int(image.height);
    std::vector<dvec3> a = radianceOf(image), b = radianceOf(reference);
    for (dvec3& c : a) c = glm::min(c, 1.0);
    for (dvec3& c : b) c = glm::min(c, 1.0);
    const std::vector<double> errors = combine(perceive(a, width, height, pixelsPerDegree),
                                               perceive(b, width, height, pixelsPerDegree));
    Image map(image.width, image.height, 1);
    std::transform(errors.begin(), errors.end(), map.pixels.begin(),
                   [](double e) { return static_cast<float>(e); });
    return map;
}

FlipExposures flipExposures(const Image& reference)
{
    std::vector<double> luminances, lit;
    for (const dvec3& rgb : radianceOf(reference)) {
        luminances.push_back((kToXyz * rgb).y);
        if (luminances.back() > 0) lit.push_back(luminances.back());
    }
    if (lit.empty()) return {};
    const double brightest = *std::max_element(lit.begin(), lit.end());
    const double typical = medianOf(luminances);
    const double median = typical > 0 ? typical : medianOf(lit);
    const double target = Aces::inverse(0.85);
    FlipExposures exposures;
    exposures.start = std::log2(target / brightest);
    exposures.stop = std::min(std::log2(target / median), exposures.start + 40);
    exposures.count = std::max(2, int(std::ceil(exposures.stop - exposures.start)));
    return exposures;
}

FlipResult flipHdr(const Image& image, const Image& reference, double pixelsPerDegree,
                   std::stop_token stop)
{
    checkPair(image, reference);
    const int width = int(image.width), height = int(image.height);
    const std::vector<dvec3> a = radianceOf(image), b = radianceOf(reference);
    FlipResult result{Image(image.width, image.height, 1), 0, flipExposures(reference)};
    std::vector<double> largest(a.size(), 0.0);
    const FlipExposures& range = result.exposures;
    for (int i = 0; i < range.count && !stop.stop_requested(); ++i) {
        const double stops = range.start + (range.stop - range.start) * i / (range.count - 1);
        const std::vector<double> errors =
            combine(perceive(exposed(a, stops), width, height, pixelsPerDegree),
                    perceive(exposed(b, stops), width, height, pixelsPerDegree));
        for (size_t p = 0; p < largest.size(); ++p) largest[p] = std::max(largest[p], errors[p]);
    }
    for (size_t p = 0; p < largest.size(); ++p) {
        const bool defined = isFinite(&image.pixels[p * image.channels]) &&
                             isFinite(&reference.pixels[p * reference.channels]);
        if (!defined) largest[p] = 1;
        result.map.pixels[p] = static_cast<float>(largest[p]);
    }
    result.mean =
        parallelSum(largest.size(), [&](size_t p) { return largest[p]; }) / double(largest.size());
    return result;
}

}  // namespace core
