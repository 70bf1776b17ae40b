// The densities of the one-dimensional laboratory. See density.h.
#include "app/lab/density.h"

#include <algorithm>
#include <array>
#include <limits>
#include <span>

#include "core/base/check.h"

namespace app::lab {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Real roots of a x^2 + b x + c, without cancellation; any coefficient may vanish. A polynomial
/// that is 0 everywhere has none.
std::vector<double> quadraticRoots(double a, double b, double c)
{
    const double discriminant = b * b - 4 * a * c;
    if (!(discriminant >= 0)) return {};
    const double t = -.5 * (b + std::copysign(std::sqrt(discriminant), b));
    std::vector<double> roots;
    if (a != 0) roots.push_back(t / a);
    if (t != 0) roots.push_back(c / t);
    return roots;
}

}  // namespace

Density::Density(Kind kind, double a, double b, double low, double high)
    : kind_(kind), a_(a), b_(b), low_(low), high_(high)
{
    CHECK(0 <= low && low < high && high <= 1);
}

Density Density::cauchy(double centre, double width)
{
    CHECK(width > 0);
    Density d(Kind::cauchy, centre, width, 0, 1);
    d.start_ = std::atan(-centre / width);
    d.span_ = std::atan((1 - centre) / width) - d.start_;
    d.scale_ = width / d.span_;
    return d;
}

Density Density::uniform(double low, double high)
{
    return Density(Kind::affine, 1 / (high - low), 0, low, high);
}

Density Density::linearUp()
{
    return Density(Kind::affine, 0, 2, 0, 1);
}

Density Density::linearDown()
{
    return Density(Kind::affine, 2, -2, 0, 1);
}

Density Density::exponential(double lambda)
{
    CHECK(lambda > 0);
    Density d(Kind::exponential, lambda, 0, 0, 1);
    d.span_ = -std::expm1(-lambda);
    d.scale_ = lambda / d.span_;
    return d;
}

double Density::cdf(double x) const
{
    if (!(x > low_)) return 0;
    if (x >= high_) return 1;
    switch (kind_) {
    case Kind::affine:
        return (x - low_) * (a_ + .5 * b_ * (x + low_));
    case Kind::exponential:
        return -std::expm1(-a_ * x) / span_;
    case Kind::cauchy:
        break;
    }
    return (std::atan((x - a_) / b_) - start_) / span_;
}

double Density::sample(double xi) const
{
    xi = std::max(xi, 0x1p-33);
    double x = 0;
    switch (kind_) {
    case Kind::affine: {  // the quadratic cdf inverted in the form that does not cancel
        const double first = a_ + b_ * low_;
        x = low_ + 2 * xi / (first + std::sqrt(std::max(first * first + 2 * b_ * xi, 0.)));
        break;
    }
    case Kind::exponential:
        x = -std::log1p(-xi * span_) / a_;
        break;
    case Kind::cauchy:
        x = a_ + b_ * std::tan(start_ + xi * span_);
        break;
    }
    return std::clamp(x, low_, high_);
}

double supremumOfRatio(const Density& p, const Density& q)
{
    using Kind = Density::Kind;
    CHECK(p.kind_ == q.kind_);
    if (p.low_ < q.low_ || p.high_ > q.high_) return kInfinity;

    // The ratio of two affine or two exponential functions is monotone; that of two Cauchy lobes
    // is stationary where (x - mq)(sp^2 + (x - mp)^2) = (x - mp)(sq^2 + (x - mq)^2), whose cubes
    // cancel. In y = x - mp, with d = mq - mp:
    std::vector<double> places{p.low_, p.high_};
    if (p.kind_ == Kind::cauchy) {
        const double d = q.a_ - p.a_, sp = p.b_ * p.b_, sq = q.b_ * q.b_;
        for (double y : quadraticRoots(d, sp - sq - d * d, -d * sp))
            places.push_back(std::clamp(p.a_ + y, p.low_, p.high_));
    }
    double supremum = 0;
    for (double x : places) {
        double above = p.pdf(x), below = q.pdf(x);
        if (above == 0 && below == 0) {  // both straight through 0: the ratio of their slopes
            above = std::abs(p.b_);
            below = std::abs(q.b_);
        }
        supremum = std::max(supremum, below > 0 ? above / below : kInfinity);
    }
    return supremum;
}

std::vector<double> crossings(const Density& q, const Density& p, double c)
{
    using Kind = Density::Kind;
    CHECK(p.kind_ == q.kind_);
    std::vector<double> roots;
    if (p.kind_ == Kind::affine) {
        const double slope = p.b_ - c * q.b_;
        if (slope != 0) roots = {(c * q.a_ - p.a_) / slope};
    } else if (p.kind_ == Kind::exponential) {
        if (p.a_ != q.a_ && c > 0) roots = {std::log(p.scale_ / (c * q.scale_)) / (p.a_ - q.a_)};
    } else {  // in y = x - mp, with d = mq - mp
        const double d = q.a_ - p.a_, cq = c * q.scale_;
        roots = quadraticRoots(p.scale_ - cq, -2 * p.scale_ * d,
                               p.scale_ * (q.b_ * q.b_ + d * d) - cq * p.b_ * p.b_);
        for (double& y : roots) y += p.a_;
    }
    std::vector<double> places{0, 1, q.low_, q.high_, p.low_, p.high_};
    const double low = std::max(q.low_, p.low_), high = std::min(q.high_, p.high_);
    for (double x : roots)
        if (x > low && x < high) places.push_back(x);
    std::sort(places.begin(), places.end());
    places.erase(std::unique(places.begin(), places.end()), places.end());
    return places;
}

}  // namespace app::lab
