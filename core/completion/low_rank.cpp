// See low_rank.h.
#include "core/completion/low_rank.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace core::many_lights {

namespace {

constexpr size_t kOversampling = 10;
constexpr int kPowerIterations = 2;
constexpr double kSafeStep = 1.9;  // thresholding converges with steps below 2

/// Normally distributed (G. Box, M. Muller, "A Note on the Generation of Random Normal Deviates",
/// 1958).
double normal(Pcg32& random)
{
    const double radius = std::sqrt(-2 * std::log(1 - random()));
    return radius * std::cos(2 * std::numbers::pi * random());
}

/// The values and vectors whose value is positive after `loss` has been taken from it, multiplied
/// out.
LowRank shrunk(const Svd& parts, double loss, size_t rows, size_t columns)
{
    LowRank low{Matrix(rows, columns), 0, 0, 0};
    for (; low.rank < parts.s.size() && parts.s[low.rank] > loss; ++low.rank)
        for (size_t j = 0; j < columns; ++j) {
            const double factor = (parts.s[low.rank] - loss) * parts.v(j, low.rank);
            const auto to = low.matrix.column(j);
            const auto u = parts.u.column(low.rank);
            for (size_t i = 0; i < rows; ++i) to[i] += factor * u[i];
        }
    return low;
}

double largestSingularValue(const Matrix& a, Pcg32& random)
{
    return randomizedSvd(a, 1, random).s[0];
}

/// sum of squares of known values.
double normOfKnown(const Matrix& a, const BitMatrix& known)
{
    double sum = 0;
    for (uint32_t j = 0; j < known.columns(); ++j)
        forEachBit(known.column(j), [&](uint32_t i) { sum += a(i, j) * a(i, j); });
    return std::sqrt(sum);
}

}  // namespace

Svd randomizedSvd(const Matrix& a, size_t k, Pcg32& random, const Matrix& start)
{
    const size_t width = std::min(k + kOversampling, std::min(a.rows(), a.columns()));
    if (2 * width >= std::min(a.rows(), a.columns())) return svd(a);
    Matrix directions(a.columns(), width);
    for (double& x : directions.values()) x = normal(random);
    for (size_t c = 0; c < std::min(width, start.columns()); ++c)
        std::ranges::copy(start.column(c), directions.column(c).begin());
    Matrix q = orthonormalized(product(a, directions));
    for (int i = 0; i < kPowerIterations; ++i)
        q = orthonormalized(product(a, orthonormalized(innerProducts(a, q))));
    Svd small = svd(innerProducts(q, a));
    return {product(q, small.u), std::move(small.s), std::move(small.v)};
}

Svd singularValuesAbove(const Matrix& a, double least, size_t guess, Pcg32& random,
                        const Matrix& start)
{
    const size_t most = std::min(a.rows(), a.columns());
    for (size_t k = std::max<size_t>(guess, 1);; k *= 2) {
        Svd parts = randomizedSvd(a, k, random, start);
        // What was found beyond k is less exact, but tells that k sufficed.
        if (parts.s.size() == most || !(parts.s[k] > least)) return parts;
    }
}

LowRank completeLowRank(const Matrix& values, const BitMatrix& known, const SvtSettings& settings,
                        Pcg32& random, const std::stop_token& stop)
{
    CHECK(values.rows() == known.rows() && values.columns() == known.columns());
    const size_t rows = values.rows(), columns = values.columns();
    const double entries = double(rows) * double(columns);
    const double norm = normOfKnown(values, known);
    if (!(norm > 0)) return {Matrix(rows, columns), 0, 0, 0};
    const double tau = settings.tau > 0 ? settings.tau : 5 * std::sqrt(entries);
    double delta = settings.delta > 0 ? settings.delta : 1.2 * entries / countBits(known.words());

    const auto forKnown = [&](auto&& f) {
        for (uint32_t j = 0; j < columns; ++j)
            forEachBit(known.column(j), [&](uint32_t i) { f(i, j); });
    };
    Matrix y(rows, columns);
    forKnown([&](uint32_t i, uint32_t j) { y(i, j) = values(i, j); });
    const double kick = std::ceil(tau / (delta * largestSingularValue(y, random)));
    for (double& x : y.values()) x *= kick * delta;

    LowRank low{Matrix(rows, columns), 0, 0, 1};
    Matrix start;
    while (low.iterations < settings.iterations && !stop.stop_requested()) {
        const uint32_t before = low.iterations;
        const double last = low.residual;
        // The vectors of the last iteration are a good start, without which errors would not fall
        // below those of a random subspace.
        Svd parts = singularValuesAbove(y, tau, low.rank + 4, random, start);
        low = shrunk(parts, tau, rows, columns);
        start = std::move(parts.v);
        double error = 0;
        forKnown([&](uint32_t i, uint32_t j) {
            const double missing = values(i, j) - low.matrix(i, j);
            error += missing * missing;
        });
        low.residual = std::sqrt(error) / norm;
        low.iterations = before + 1;
        if (low.residual < settings.tolerance) break;
        // The step that suits few known entries is too long for some matrices, which then diverge.
        if (low.residual > last) delta = std::min(delta, std::max(kSafeStep, 0.5 * delta));
        forKnown(
            [&](uint32_t i, uint32_t j) { y(i, j) += delta * (values(i, j) - low.matrix(i, j)); });
    }
    return low;
}

}  // namespace core::many_lights
