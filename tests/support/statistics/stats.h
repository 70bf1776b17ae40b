// Statistics for tests, by the policy of docs/tests.md: Sidak-corrected levels, pooled chi-square,
// Welch for two estimators, and the smallest bias that a test can detect.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace tests {

// One test's share of a family of 400 at 1 % (Sidak), as a probability and as a normal score.
inline constexpr double kLevel = 2.5e-5;
inline constexpr double kScore = 4.21;

/// Q(a, x) = Gamma(a, x) / Gamma(a): series below a + 1, Lentz's continued fraction above.
double regularizedGammaQ(double a, double x);

/// I_x(a, b), the regularised incomplete beta function, by its continued fraction.
double regularizedBeta(double a, double b, double x);

/// Probability of a chi-square variable above `statistic`.
double chiSquareP(double statistic, double degreesOfFreedom);

/// Probability that a standard normal variable is farther from 0 than z.
double normalTwoSidedP(double z);

/// The z below which a standard normal variable lies with probability p (Newton on erfc).
double normalQuantile(double p);

/// Probability that Student's t is farther from 0 than `t`.
double studentTwoSidedP(double t, double degreesOfFreedom);

/// Level of each of `count` independent tests such that the family has level `family`.
double sidak(double family, std::size_t count);

struct ChiSquare {
    double statistic = 0;
    double degreesOfFreedom = 0;
    double p = 1;
    double outside = 0;  // observations in cells of expectation zero
};

/// Chi-square of counts against expected counts. Cells expected to hold fewer than `minimum` are
/// pooled, the smallest first; those expected to hold nothing are counted apart. `fitted`:
/// parameters taken from the data, including 1 when the expectations were scaled to the observed
/// total.
ChiSquare chiSquareTest(std::span<const double> observed, std::span<const double> expected,
                        int fitted = 0, double minimum = 5);

/// Running mean and variance (Welford).
class Moments {
public:
    void add(double x);
    void merge(const Moments& other);
    double count() const { return count_; }
    double mean() const { return mean_; }
    double variance() const { return count_ > 1 ? squares_ / (count_ - 1) : 0; }
    double varianceOfMean() const { return count_ > 0 ? variance() / count_ : 0; }

private:
    double count_ = 0;
    double mean_ = 0;
    double squares_ = 0;
};

struct Comparison {
    double z = 0;
    double p = 1;
    double detectable = 0;  // relative bias seen with 99 % power: judge the test by it
};

/// Two-sample test of equal means with unequal variances.
Comparison welch(const Moments& a, const Moments& b);

/// One-sample test of a mean; for bounded estimators only.
Comparison againstExact(const Moments& a, double exact);

/// Kolmogorov-Smirnov: probability of a larger distance from the uniform distribution on [0,1].
double kolmogorovUniformP(std::vector<double> values);

/// Pearson's correlation of two equally long series.
double correlation(std::span<const float> a, std::span<const float> b);

}  // namespace tests
