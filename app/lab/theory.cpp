// Mean and variance of the laboratory's estimators in closed form, up to one-dimensional integrals.
//
// With g = f/p, alpha = min(1, c q/p), omega = 1 - alpha, A = int alpha f, B = int omega f:
// Reweighting-Augmentation with k candidates has
//   N Var = int q f^2 / max(q, p/c)^2 - A^2 + (N/n) ((1/k) int p omega^2 g^2
//           + (1 - 1/k) R int p omega g^2 - B^2).
// The others follow by the same steps; each is written where it is computed. The correction by a
// constant beta, estimate - beta (sum v - 1), is the same estimator of f - beta p, plus beta.
#include "app/lab/theory.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "core/base/check.h"

namespace app::lab {

namespace {

/// Power of the distance with which each function leaves the ends 0 and 1; infinite: zero near it.
struct EndOrders {
    double at0, at1;
};
constexpr std::array<EndOrders, kFunctions> kFunctionOrders{{
    {0, 0},
    {1, 0},
    {1, 1},
    {kInfinite, kInfinite},
    {0, 0},
    {0, 0},
    {0, 0},
    {-.25, 0},
}};

double square(double x)
{
    return x * x;
}

/// Second moment minus squared mean. A difference within rounding is zero: estimators without
/// variance must show none.
double central(double secondMoment, double mean)
{
    const double difference = secondMoment - square(mean);
    return secondMoment == kInfinite || difference > 1e-11 * secondMoment ? difference : 0;
}

/// Variance of a whole number that is x rounded at random.
double roundingVariance(double x)
{
    const double part = x - std::floor(x);
    return part * (1 - part);
}

/// One integrand h = f - beta p under one change of density, and its integrals against functions of
/// the two densities.
class Integrals {
public:
    Integrals(const Pair& pair, size_t function, bool corrected, double c)
        : pair_(pair), function_(function), breaks_(crossings(pair.q, pair.p, c))
    {
        const double truth = pair.truth()[function];
        if (corrected) beta_ = truth;
        truth_ = truth - beta_;
        for (double jump : {.3, .6}) breaks_.push_back(jump);  // of F4
        std::sort(breaks_.begin(), breaks_.end());
    }

    const Pair& pair() const { return pair_; }
    double beta() const { return beta_; }
    /// Integral of h over the support of p.
    double truth() const { return truth_; }

    /// Integral of h W(q, p) over [0, 1]; W is given only densities above 0, or 0.
    template <class W> double first(W&& weight) const
    {
        return integrate(breaks_, [&](double x) {
            const double w = weight(pair_.q.pdf(x), pair_.p.pdf(x));
            return w != 0 ? h(x) * w : 0;
        });
    }

    /// Integral of h^2 W(q, p) over [0, 1], W >= 0; kInfinite where it diverges at an end.
    template <class W> double second(W&& weight) const
    {
        std::vector<double> breaks = breaks_;
        for (double end : {0., 1.}) {
            if (2 * order(end) + weightOrder(weight, end) > -1) continue;
            // Where the coefficient of a logarithmic divergence is tiny (F6 has f(0) = 2e-6 and
            // f(1) = 9e-4), no experiment sees it: what lies within 1e-6 of the end would add less
            // than 1e-6 times the logarithm of the number of samples. It is left out.
            constexpr double kVanishing = 1e-3, kTail = 1e-6;
            if (!(std::abs(h(inside(end, 1e-12))) < kVanishing)) return kInfinite;
            for (double& x : breaks)
                x = std::clamp(x, end == 0 ? kTail : 0, end == 1 ? 1 - kTail : 1);
        }
        return integrate(breaks, [&](double x) {
            const double w = weight(pair_.q.pdf(x), pair_.p.pdf(x));
            return w != 0 ? square(h(x)) * w : 0;
        });
    }

private:
    double h(double x) const
    {
        const double f = evaluateFunctions(x)[function_];
        const double difference = f - beta_ * pair_.p.pdf(x);
        // f proportional to p: what is left is rounding, and must not count against a density that
        // vanishes.
        return std::abs(difference) > 1e-14 * std::abs(f) ? difference : 0;
    }

    static double inside(double end, double distance) { return end == 0 ? distance : 1 - distance; }

    /// The power of the distance with which h leaves the end.
    double order(double end) const
    {
        if (h(inside(end, 1e-3)) == 0 && h(inside(end, 1e-4)) == 0) return kInfinite;
        const EndOrders& orders = kFunctionOrders[function_];
        const double ofF = end == 0 ? orders.at0 : orders.at1;
        if (beta_ == 0) return ofF;
        return std::min(ofF, densityOrder(end));
    }

    /// Of p: the densities have zeros of first order only.
    double densityOrder(double end) const
    {
        if (pair_.p.pdf(end) > 0) return 0;
        return pair_.p.pdf(inside(end, 1e-8)) > 0 ? 1 : kInfinite;
    }

    /// Of W: whole, because W is rational in the densities and these are powers there.
    template <class W> double weightOrder(W&& weight, double end) const
    {
        constexpr double kNear = 1e-10, kFar = 1e-8;
        const auto at = [&](double distance) {
            const double x = inside(end, distance);
            return weight(pair_.q.pdf(x), pair_.p.pdf(x));
        };
        const double near = at(kNear), far = at(kFar);
        if (!(near > 0) || !(far > 0)) return kInfinite;
        return std::round(std::log(far / near) / std::log(kFar / kNear));
    }

    const Pair& pair_;
    size_t function_;
    std::vector<double> breaks_;
    double beta_ = 0, truth_ = 0;
};

struct Sizes {
    double N, n, k, c;
};

double freshVariance(const Integrals& of)
{
    return central(of.second([](double, double p) { return p > 0 ? 1 / p : 0; }), of.truth());
}

Expectation unbiased(const Integrals& of, double variance)
{
    return {of.truth() + of.beta(), variance};
}

Expectation discardFormula(const Integrals& of, const Sizes& s)
{
    return unbiased(of, s.N / s.n * freshVariance(of));
}

Expectation fullFormula(const Integrals& of, const Sizes& s)
{
    return unbiased(of, s.N / std::max(std::round(s.N / s.c), 1.) * freshVariance(of));
}

/// int f^2/q - (int f)^2, both where q > 0: what lies elsewhere is missing from the mean.
Expectation reweightingFormula(const Integrals& of, const Sizes&)
{
    const double mean = of.first([](double q, double) { return q > 0 ? 1. : 0.; });
    const double moment = of.second([](double q, double) { return q > 0 ? 1 / q : 0; });
    return {mean + of.beta(), central(moment, mean)};
}

/// Each old sample adds (b/N) g with probability p/(b q): N Var = b int f^2/p - I^2.
Expectation rejectionFormula(const Integrals& of, const Sizes&)
{
    const double b = of.pair().rejectionConstant();
    if (!std::isfinite(b)) return {};
    const double moment = of.second([](double, double p) { return p > 0 ? 1 / p : 0; });
    return unbiased(of, central(b * moment, of.truth()));
}

/// Given the old samples, the picks are independent with mean sum(w g) / N in all. Their mean of
/// squares brings, with w = p/q, beside the variance of reweighting:
///   ((N - 1)/n) (E_q[w] E_q[w g^2] - E_q[w g]^2).
Expectation risFormula(const Integrals& of, const Sizes& s)
{
    const Pair& pair = of.pair();
    const double mass = pair.p.cdf(pair.q.high()) - pair.p.cdf(pair.q.low());
    const auto both = [](double q, double p) { return q > 0 && p > 0; };
    const double mean = of.first([&](double q, double p) { return both(q, p) ? 1. : 0.; });
    const double old = of.second([&](double q, double p) { return both(q, p) ? 1 / q : 0; });
    const double picks = of.second([&](double q, double p) { return both(q, p) ? 1 / p : 0; });
    return {mean + of.beta(), central(old, mean) + (s.N - 1) / s.n * central(mass * picks, mean)};
}

/// N Var of (1/M) sum g over a number of samples of r / R that is `count` on average and rounded at
/// random; `residual(q, p)` is r, of mass R = count / M.
template <class Residual>
double addedVariance(const Integrals& of, const Sizes& s, double count, double M,
                     Residual&& residual)
{
    if (!(count > 1e-12)) return 0;
    const double R = count / M;
    const double mean =
        of.first([&](double q, double p) { return p > 0 ? residual(q, p) / p : 0; }) / R;
    const double moment =
        of.second([&](double q, double p) { return p > 0 ? residual(q, p) / p / p : 0; }) / R;
    return s.N / square(M) *
           (count * central(moment, mean) + roundingVariance(count) * square(mean));
}

/// All old samples, g/(aN) each, and (a - 1) N of the density (a p - q)/(a - 1).
Expectation augmentationFormula(const Integrals& of, const Sizes& s)
{
    const double a = of.pair().augmentationConstant();
    if (!std::isfinite(a)) return {};
    const double mean = of.first([](double q, double p) { return p > 0 ? q / p : 0; });
    const double moment = of.second([](double q, double p) { return p > 0 ? q / p / p : 0; });
    const double added = addedVariance(of, s, (a - 1) * s.N, a * s.N,
                                       [a](double q, double p) { return std::max(p - q / a, 0.); });
    return unbiased(of, central(moment, mean) / square(a) + added);
}

/// Old samples add g/M with probability w = min(1, p/(c q)), of which N c^2 E_q[w g^2] / N^2 is the
/// second moment; then M R(c) of the residual.
Expectation rejectionAugmentationFormula(const Integrals& of, const Sizes& s)
{
    const double c = s.c, M = s.N / c;
    const auto kept = [c](double q, double p) { return std::min(c * q, p); };
    const double mean = of.first([&](double q, double p) { return p > 0 ? kept(q, p) / p : 0; });
    const double moment =
        of.second([&](double q, double p) { return p > 0 ? kept(q, p) / p / p : 0; });
    const double added = addedVariance(of, s, M * of.pair().residual(c), M,
                                       [c](double q, double p) { return std::max(p - c * q, 0.); });
    return unbiased(of, central(c * moment, mean) + added);
}

/// alpha of R-A, written a second time so that a mistake in the estimators would show.
double alpha(double c, double q, double p)
{
    if (!(p > 0)) return 0;
    return c * q >= p ? 1 : c * q / p;
}

double omega(double c, double q, double p)
{
    return p > 0 ? 1 - alpha(c, q, p) : 0;
}

/// What the old samples of R-A bring.
struct OldPart {
    double mean, variance;  // A, N Var
};

OldPart oldPart(const Integrals& of, double c)
{
    const double mean = of.first([c](double q, double p) { return alpha(c, q, p); });
    const double moment = of.second(
        [c](double q, double p) { return p > 0 && q > 0 ? q / square(std::max(q, p / c)) : 0; });
    return {mean, central(moment, mean)};
}

Expectation reweightingAugmentationFormula(const Integrals& of, const Sizes& s)
{
    const double c = s.c;
    const OldPart old = oldPart(of, c);
    const double exact = of.pair().residual(c) * of.second([c](double q, double p) {
        return p > 0 ? omega(c, q, p) / p : 0;
    });
    const double single =
        of.second([c](double q, double p) { return p > 0 ? square(omega(c, q, p)) / p : 0; });
    const double moment = single / s.k + (1 - 1 / s.k) * exact;
    return unbiased(of, old.variance + s.N / s.n * central(moment, of.truth() - old.mean));
}

/// M candidates of p, each adding g/M with probability omega; M is a whole number, and c follows
/// from it.
Expectation thinnedFormula(const Integrals& of, const Sizes& s)
{
    const double c = s.c, M = s.N / c;
    const OldPart old = oldPart(of, c);
    const double moment =
        of.second([c](double q, double p) { return p > 0 ? omega(c, q, p) / p : 0; });
    return unbiased(of, old.variance + s.N / M * central(moment, of.truth() - old.mean));
}

Expectation balanceHeuristicFormula(const Integrals& of, const Sizes& s)
{
    // Shares of the sum of densities, so that neither side overflows.
    const auto sum = [s](double q, double p) { return s.N * q + s.n * p; };
    const double mean =
        of.first([&](double q, double p) { return p > 0 ? s.N * q / sum(q, p) : 0; });
    const double old =
        of.second([&](double q, double p) { return p > 0 ? q * square(s.N / sum(q, p)) : 0; });
    const double fresh =
        of.second([&](double q, double p) { return p > 0 ? p * square(s.n / sum(q, p)) : 0; });
    return unbiased(of, central(old, mean) + s.N / s.n * central(fresh, of.truth() - mean));
}

using Formula = Expectation (*)(const Integrals&, const Sizes&);
constexpr std::array<std::pair<std::string_view, Formula>, 10> kFormulas{{
    {"discard", discardFormula},
    {"full", fullFormula},
    {"reweighting", reweightingFormula},
    {"rejection", rejectionFormula},
    {"ris", risFormula},
    {"augmentation", augmentationFormula},
    {"rejection-augmentation", rejectionAugmentationFormula},
    {"ra", reweightingAugmentationFormula},
    {"ra-thinned", thinnedFormula},
    {"mis", balanceHeuristicFormula},
}};

}  // namespace

Expectation expectation(const Cell& cell)
{
    const auto formula = std::find_if(kFormulas.begin(), kFormulas.end(), [&](const auto& entry) {
        return entry.first == cell.method;
    });
    if (formula == kFormulas.end() || cell.beta == Beta::own) return {};

    Sizes sizes{static_cast<double>(cell.oldSamples), static_cast<double>(cell.newSamples),
                cell.candidates == kExactResidual ? kInfinite
                                                  : static_cast<double>(cell.candidates),
                cell.c};
    if (cell.method == "ra-thinned")  // M is whole
        sizes.c = sizes.N / std::max(std::round(sizes.N / cell.c), 1.);
    const double c = std::isnan(sizes.c) ? 1 : sizes.c;  // unused: the pieces are then any
    return formula->second(
        Integrals(pairOf(cell.pair), functionIndex(cell.function), cell.beta == Beta::ideal, c),
        sizes);
}

}  // namespace app::lab
