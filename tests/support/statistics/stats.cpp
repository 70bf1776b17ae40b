// See stats.h. Special functions follow Abramowitz & Stegun 26.5 and 6.5 and the modified Lentz
// method.
#include "tests/support/statistics/stats.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/check.h"

namespace tests {

namespace {

constexpr double kLeast = 1e-300;

double away(double x)
{
    return std::fabs(x) < kLeast ? kLeast : x;
}

/// P(a, x) by its power series.
double gammaSeries(double a, double x, double logFactor)
{
    double term = 1 / a;
    double sum = term;
    for (int n = 1; n < 100000 && term > sum * 1e-16; ++n) {
        term *= x / (a + n);
        sum += term;
    }
    return sum * std::exp(logFactor);
}

double gammaFraction(double a, double x, double logFactor)
{
    double b = x + 1 - a;
    double c = 1 / kLeast;
    double d = 1 / away(b);
    double h = d;
    for (int n = 1; n < 100000; ++n) {
        double an = -n * (n - a);
        b += 2;
        d = 1 / away(an * d + b);
        c = away(b + an / c);
        double step = c * d;
        h *= step;
        if (std::fabs(step - 1) < 1e-15) break;
    }
    return h * std::exp(logFactor);
}

double betaFraction(double a, double b, double x)
{
    double c = 1;
    double d = 1 / away(1 - (a + b) * x / (a + 1));
    double h = d;
    for (int n = 1; n < 100000; ++n) {
        double even = n * (b - n) * x / ((a + 2 * n - 1) * (a + 2 * n));
        d = 1 / away(1 + even * d);
        c = away(1 + even / c);
        h *= c * d;
        double odd = -(a + n) * (a + b + n) * x / ((a + 2 * n) * (a + 2 * n + 1));
        d = 1 / away(1 + odd * d);
        c = away(1 + odd / c);
        h *= c * d;
        if (std::fabs(c * d - 1) < 1e-15) break;
    }
    return h;
}

}  // namespace

double regularizedGammaQ(double a, double x)
{
    CHECK(a > 0 && x >= 0);
    if (x == 0) return 1;
    double logFactor = a * std::log(x) - x - std::lgamma(a);
    return x < a + 1 ? 1 - gammaSeries(a, x, logFactor) : gammaFraction(a, x, logFactor);
}

double regularizedBeta(double a, double b, double x)
{
    CHECK(a > 0 && b > 0);
    if (x <= 0) return 0;
    if (x >= 1) return 1;
    double factor = std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) +
                             a * std::log(x) + b * std::log1p(-x));
    return x < (a + 1) / (a + b + 2) ? factor * betaFraction(a, b, x) / a
                                     : 1 - factor * betaFraction(b, a, 1 - x) / b;
}

double chiSquareP(double statistic, double degreesOfFreedom)
{
    return degreesOfFreedom > 0 ? regularizedGammaQ(degreesOfFreedom / 2, statistic / 2) : 1;
}

double normalTwoSidedP(double z)
{
    return std::erfc(std::fabs(z) / std::sqrt(2.0));
}

double normalQuantile(double p)
{
    CHECK(p > 0 && p < 1);
    if (p > 0.5) return -normalQuantile(1 - p);
    // Newton in log p, which is concave in z: the start below the root makes it monotone and safe
    // in the tail.
    double z = -std::sqrt(-2 * std::log(p));
    for (int i = 0; i < 60; ++i) {
        double below = 0.5 * std::erfc(-z / std::sqrt(2.0));
        double density = std::exp(-0.5 * z * z) / std::sqrt(2 * std::acos(-1.0));
        double step = (std::log(below) - std::log(p)) * below / density;
        z -= step;
        if (std::fabs(step) < 1e-14) break;
    }
    return z;
}

double studentTwoSidedP(double t, double degreesOfFreedom)
{
    if (!(degreesOfFreedom > 0)) return 1;
    return regularizedBeta(degreesOfFreedom / 2, 0.5,
                           degreesOfFreedom / (degreesOfFreedom + t * t));
}

double sidak(double family, std::size_t count)
{
    return -std::expm1(std::log1p(-family) / static_cast<double>(count));
}

ChiSquare chiSquareTest(std::span<const double> observed, std::span<const double> expected,
                        int fitted, double minimum)
{
    CHECK(observed.size() == expected.size());
    std::vector<std::size_t> order(observed.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(),
              [&](std::size_t i, std::size_t j) { return expected[i] < expected[j]; });
    ChiSquare result;
    double cells = 0;
    double pooledObserved = 0;
    double pooledExpected = 0;
    auto close = [&] {
        double d = pooledObserved - pooledExpected;
        result.statistic += d * d / pooledExpected;
        cells += 1;
        pooledObserved = pooledExpected = 0;
    };
    for (std::size_t i : order) {
        if (!(expected[i] > 0)) {
            result.outside += observed[i];
            continue;
        }
        pooledObserved += observed[i];
        pooledExpected += expected[i];
        if (pooledExpected >= minimum) close();
    }
    if (pooledExpected > 0) close();  // only when everything together stays below the minimum
    result.degreesOfFreedom = std::max(cells - fitted, 0.0);
    result.p = chiSquareP(result.statistic, result.degreesOfFreedom);
    return result;
}

void Moments::add(double x)
{
    count_ += 1;
    double d = x - mean_;
    mean_ += d / count_;
    squares_ += d * (x - mean_);
}

void Moments::merge(const Moments& other)
{
    if (other.count_ == 0) return;
    double total = count_ + other.count_;
    double d = other.mean_ - mean_;
    squares_ += other.squares_ + d * d * count_ * other.count_ / total;
    mean_ += d * other.count_ / total;
    count_ = total;
}

namespace {

/// 99 % power: 2.33 is the 99 % quantile.
double detectableBias(double variance, double mean)
{
    return mean == 0 ? 0 : (kScore + 2.33) * std::sqrt(variance) / std::fabs(mean);
}

}  // namespace

Comparison welch(const Moments& a, const Moments& b)
{
    double va = a.varianceOfMean();
    double vb = b.varianceOfMean();
    Comparison r;
    r.detectable = detectableBias(va + vb, 0.5 * (a.mean() + b.mean()));
    double difference = a.mean() - b.mean();
    if (!(va + vb > 0)) {
        r.z = difference == 0 ? 0 : std::copysign(1e30, difference);
        r.p = difference == 0 ? 1 : 0;
        return r;
    }
    r.z = difference / std::sqrt(va + vb);
    double freedom =
        (va + vb) * (va + vb) / (va * va / (a.count() - 1) + vb * vb / (b.count() - 1));
    r.p = studentTwoSidedP(r.z, freedom);
    return r;
}

Comparison againstExact(const Moments& a, double exact)
{
    Comparison r;
    double v = a.varianceOfMean();
    r.detectable = detectableBias(v, exact);
    double difference = a.mean() - exact;
    // A constant estimator has no variance; its rounding is all that may remain.
    double rounding = 1e-6 * std::fabs(exact);
    r.z = difference / std::sqrt(v + rounding * rounding);
    r.p = studentTwoSidedP(r.z, a.count() - 1);
    return r;
}

double kolmogorovUniformP(std::vector<double> values)
{
    CHECK(!values.empty());
    std::sort(values.begin(), values.end());
    double n = static_cast<double>(values.size());
    double distance = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        double k = static_cast<double>(i);
        distance = std::max({distance, (k + 1) / n - values[i], values[i] - k / n});
    }
    // Stephens's argument makes the limit law good from n = 5 on.
    double x = distance * (std::sqrt(n) + 0.12 + 0.11 / std::sqrt(n));
    if (x < 0.2) return 1;
    double sum = 0;
    for (int k = 1; k < 200; ++k) {
        double term = std::exp(-2.0 * k * k * x * x);
        sum += k % 2 == 1 ? term : -term;
        if (term < 1e-18) break;
    }
    return std::clamp(2 * sum, 0.0, 1.0);
}

double correlation(std::span<const float> a, std::span<const float> b)
{
    CHECK(a.size() == b.size() && !a.empty());
    double n = static_cast<double>(a.size());
    double meanA = std::accumulate(a.begin(), a.end(), 0.0) / n;
    double meanB = std::accumulate(b.begin(), b.end(), 0.0) / n;
    double ab = 0;
    double aa = 0;
    double bb = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        double x = static_cast<double>(a[i]) - meanA;
        double y = static_cast<double>(b[i]) - meanB;
        ab += x * y;
        aa += x * x;
        bb += y * y;
    }
    return ab / std::sqrt(aa * bb);
}

}  // namespace tests
