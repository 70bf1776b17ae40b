// Densities on [0, 1] with cdf and inverse in closed form: what stands in for a glossy lobe (the
// truncated Cauchy: its centre is the mirror direction, its width the roughness) and for the ways
// in which two densities can disagree.
#pragma once

#include <cmath>
#include <vector>

namespace app::lab {

class Density {
public:
    /// Truncated to [0, 1]; width > 0.
    static Density cauchy(double centre, double width);
    /// 0 <= low < high <= 1.
    static Density uniform(double low, double high);
    static Density linearUp();    // 2x
    static Density linearDown();  // 2 - 2x
    /// lambda exp(-lambda x) truncated to [0, 1]; lambda > 0.
    static Density exponential(double lambda);

    /// 0 outside the support. Inline: the laboratory spends its time here.
    double pdf(double x) const
    {
        if (!(x >= low_ && x <= high_)) return 0;
        if (kind_ == Kind::affine) return a_ + b_ * x;
        if (kind_ == Kind::exponential) return scale_ * std::exp(-a_ * x);
        const double d = x - a_;
        return scale_ / (b_ * b_ + d * d);
    }
    double cdf(double x) const;
    /// The x with cdf(x) = xi, for xi in [0, 1). Less than 2^-33 counts as that, half a step of a
    /// generator with 32 bits: no sample falls on the end of the domain, where F8 is infinite.
    double sample(double xi) const;

    double low() const { return low_; }
    double high() const { return high_; }

private:
    enum class Kind { cauchy, affine, exponential };  // affine: the uniform and the linear ones
    Density(Kind kind, double a, double b, double low, double high);

    friend double supremumOfRatio(const Density& p, const Density& q);
    friend std::vector<double> crossings(const Density& q, const Density& p, double c);

    Kind kind_;
    double a_, b_;  // cauchy: centre and width; affine: a + b x; exponential: a = lambda
    double low_, high_;
    double scale_ = 1;             // numerator of the pdf
    double start_ = 0, span_ = 1;  // cauchy: angle of x = 0 and range of angles; exponential: mass
};

/// The least c with c q >= p everywhere on the support of p: sup p/q. Infinite where q vanishes
/// faster than p. Both must be of one family: Cauchy, exponential, or uniform and linear.
double supremumOfRatio(const Density& p, const Density& q);

/// Where c q crosses p inside (0, 1), and the ends of both supports: between neighbours of this
/// sorted list the sign of p - c q does not change. Includes 0 and 1. Exact to rounding, by
/// the closed form of each family (both must be of one).
std::vector<double> crossings(const Density& q, const Density& p, double c);

}  // namespace app::lab
