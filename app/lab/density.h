// Densities on [0, 1] with cdf and inverse in closed form: what stands in for a glossy lobe (the
// truncated Cauchy: its centre is the mirror direction, its width the roughness) and for the ways
// in which two densities can disagree.
#pragma once

#include <span>
#include <vector>

namespace app::lab {

class Density {
public:
    /// Truncated to [0, 1]; width > 0.
    static Density cauchy(double centre, double width);
    static Density uniform(double low, double high);
    static Density linearUp();    // 2x
    static Density linearDown();  // 2 - 2x
    /// lambda exp(-lambda x) truncated to [0, 1]; lambda > 0.
    static Density exponential(double lambda);

    double pdf(double x) const;  // 0 outside the support
    double cdf(double x) const;
    /// The x with cdf(x) = xi, for xi in [0, 1).
    double sample(double xi) const;

    double low() const { return low_; }
    double high() const { return high_; }

private:
    enum class Kind { cauchy, uniform, linearUp, linearDown, exponential };
    Density(Kind kind, double a, double b, double low, double high);

    Kind kind_;
    double a_, b_, low_, high_;
    double start_ = 0, span_ = 1;  // constants of the normalisation
};

/// The least c with c q >= p everywhere on the support of p: sup p/q. Infinite where q vanishes
/// faster than p.
double supremumOfRatio(const Density& p, const Density& q);

/// Where c q crosses p inside (0, 1), and the ends of both supports: between neighbours of this
/// sorted list the sign of p - c q does not change. Includes 0 and 1.
std::vector<double> crossings(const Density& q, const Density& p, double c);

}  // namespace app::lab
