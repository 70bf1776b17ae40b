// Linear algebra of small dense matrices.
#include "core/completion/dense.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "core/base/check.h"

namespace core::many_lights {

namespace {

constexpr double kRounding = 1e-30;  // squared length of a column, relative, that counts as zero

/// Eight sums side by side: a single one waits for each addition.
double dot(std::span<const double> a, std::span<const double> b)
{
    constexpr size_t kSums = 8;
    double sums[kSums] = {};
    const size_t whole = a.size() / kSums * kSums;
    for (size_t i = 0; i < whole; i += kSums)
        for (size_t k = 0; k < kSums; ++k) sums[k] += a[i + k] * b[i + k];
    for (size_t i = whole; i < a.size(); ++i) sums[0] += a[i] * b[i];
    return std::accumulate(sums, sums + kSums, 0.0);
}

void addScaled(std::span<double> to, double factor, std::span<const double> x)
{
    for (size_t i = 0; i < to.size(); ++i) to[i] += factor * x[i];
}

void rotate(std::span<double> a, std::span<double> b, double c, double s)
{
    for (size_t i = 0; i < a.size(); ++i) {
        const double x = a[i], y = b[i];
        a[i] = c * x - s * y;
        b[i] = s * x + c * y;
    }
}

/// The columns of `a`, in another order and each times a factor.
Matrix pickColumns(const Matrix& a, std::span<const size_t> order, std::span<const double> factors)
{
    Matrix picked(a.rows(), order.size());
    for (size_t k = 0; k < order.size(); ++k)
        for (size_t i = 0; i < a.rows(); ++i) picked(i, k) = factors[k] * a(i, order[k]);
    return picked;
}

/// Rotates pairs of columns of `a` until all are orthogonal, and those of `v` with them.
void orthogonalize(Matrix& a, Matrix& v)
{
    constexpr int kMostSweeps = 60;
    constexpr double kTolerance = 1e-14;
    const double nothing = kRounding * dot(a.values(), a.values());
    for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
        bool rotated = false;
        for (size_t p = 0; p + 1 < a.columns(); ++p)
            for (size_t q = p + 1; q < a.columns(); ++q) {
                const double pp = dot(a.column(p), a.column(p)), qq = dot(a.column(q), a.column(q)),
                             pq = dot(a.column(p), a.column(q));
                if (pp <= nothing || qq <= nothing) continue;  // rounding has no direction
                if (!(std::abs(pq) > kTolerance * std::sqrt(pp * qq))) continue;
                rotated = true;
                const double zeta = (qq - pp) / (2 * pq);
                const double t =
                    std::copysign(1.0, zeta) / (std::abs(zeta) + std::sqrt(1 + zeta * zeta));
                const double c = 1 / std::sqrt(1 + t * t), s = c * t;
                rotate(a.column(p), a.column(q), c, s);
                rotate(v.column(p), v.column(q), c, s);
            }
        if (!rotated) return;
    }
}

}  // namespace

Matrix transposed(const Matrix& a)
{
    Matrix t(a.columns(), a.rows());
    for (size_t j = 0; j < a.columns(); ++j)
        for (size_t i = 0; i < a.rows(); ++i) t(j, i) = a(i, j);
    return t;
}

Matrix product(const Matrix& a, const Matrix& b)
{
    CHECK(a.columns() == b.rows());
    Matrix c(a.rows(), b.columns());
    // Part of `a` stays in the cache for all columns of `b`; each sum keeps its order.
    constexpr size_t kRows = 512, kColumns = 32;
    for (size_t i = 0; i < a.rows(); i += kRows)
        for (size_t from = 0; from < a.columns(); from += kColumns) {
            const size_t count = std::min(kRows, a.rows() - i);
            const size_t to = std::min(from + kColumns, a.columns());
            for (size_t j = 0; j < b.columns(); ++j)
                for (size_t k = from; k < to; ++k)
                    addScaled(c.column(j).subspan(i, count), b(k, j),
                              a.column(k).subspan(i, count));
        }
    return c;
}

Matrix innerProducts(const Matrix& a, const Matrix& b)
{
    CHECK(a.rows() == b.rows());
    Matrix c(a.columns(), b.columns());
    for (size_t j = 0; j < b.columns(); ++j)
        for (size_t i = 0; i < a.columns(); ++i) c(i, j) = dot(a.column(i), b.column(j));
    return c;
}

Matrix orthonormalized(Matrix a)
{
    const double nothing = kRounding * dot(a.values(), a.values());
    for (size_t k = 0; k < a.columns(); ++k) {
        for (int pass = 0; pass < 2; ++pass)
            for (size_t j = 0; j < k; ++j)
                addScaled(a.column(k), -dot(a.column(j), a.column(k)), a.column(j));
        const double squared = dot(a.column(k), a.column(k));
        const double factor = squared > nothing ? 1 / std::sqrt(squared) : 0;
        for (double& x : a.column(k)) x *= factor;
    }
    return a;
}

double frobeniusNorm(const Matrix& a)
{
    return std::sqrt(dot(a.values(), a.values()));
}

Svd svd(const Matrix& a)
{
    if (a.rows() < a.columns()) {
        Svd other = svd(transposed(a));
        return {std::move(other.v), std::move(other.s), std::move(other.u)};
    }
    Matrix scaled = a, v(a.columns(), a.columns());
    for (size_t k = 0; k < v.columns(); ++k) v(k, k) = 1;
    orthogonalize(scaled, v);
    const double all = dot(a.values(), a.values());
    std::vector<double> lengths(a.columns());
    for (size_t k = 0; k < lengths.size(); ++k) {
        const double squared = dot(scaled.column(k), scaled.column(k));
        lengths[k] = squared > kRounding * all ? std::sqrt(squared) : 0;
    }
    std::vector<size_t> order(lengths.size());
    std::iota(order.begin(), order.end(), size_t(0));
    std::ranges::stable_sort(order, [&](size_t x, size_t y) { return lengths[x] > lengths[y]; });
    std::vector<double> s, inverse;
    for (const size_t k : order) {
        s.push_back(lengths[k]);
        inverse.push_back(lengths[k] > 0 ? 1 / lengths[k] : 0);
    }
    return {pickColumns(scaled, order, inverse), s,
            pickColumns(v, order, std::vector<double>(order.size(), 1))};
}

namespace {

/// R^-1 Q^T of a tall matrix by Gram and Schmidt, each column twice; nothing when some column is
/// nearly a combination of others: is left with a length of at most `least`.
std::optional<Matrix> inverseByQr(const Matrix& a, double least)
{
    const size_t r = a.columns();
    if (a.rows() < r) return std::nullopt;
    Matrix q = a, upper(r, r);
    for (size_t k = 0; k < r; ++k) {
        for (int pass = 0; pass < 2; ++pass)
            for (size_t j = 0; j < k; ++j) {
                const double along = dot(q.column(j), q.column(k));
                addScaled(q.column(k), -along, q.column(j));
                upper(j, k) += along;
            }
        const double length = std::sqrt(dot(q.column(k), q.column(k)));
        if (!(length > least)) return std::nullopt;
        upper(k, k) = length;
        for (double& x : q.column(k)) x /= length;
    }
    Matrix inverse(r, r);  // of `upper`, by columns from their ends
    for (size_t k = 0; k < r; ++k) {
        inverse(k, k) = 1;
        for (size_t i = k + 1; i-- > 0;) {
            const double x = inverse(i, k) /= upper(i, i);
            for (size_t above = 0; above < i; ++above) inverse(above, k) -= x * upper(above, i);
        }
    }
    return product(inverse, transposed(q));
}

}  // namespace

Matrix pseudoInverse(const Matrix& a, double cutoff)
{
    if (auto inverse = inverseByQr(a, 100 * cutoff)) return std::move(*inverse);
    const Svd parts = svd(a);
    std::vector<size_t> kept;
    std::vector<double> inverse;
    for (size_t k = 0; k < parts.s.size(); ++k) {
        if (!(parts.s[k] > cutoff)) break;
        kept.push_back(k);
        inverse.push_back(1 / parts.s[k]);
    }
    const Matrix v = pickColumns(parts.v, kept, inverse);
    const Matrix u = pickColumns(parts.u, kept, std::vector<double>(kept.size(), 1));
    return product(v, transposed(u));
}

}  // namespace core::many_lights
