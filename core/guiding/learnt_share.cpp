#include "core/guiding/learnt_share.h"

#include <algorithm>
#include <cmath>

namespace core::guiding {

namespace {

constexpr double kRate = 0.01, kFirst = 0.9, kSecond = 0.999, kLeast = 1e-8;
constexpr double kRegular = 0.01;  // of theta: towards a half
constexpr double kMostTheta = 20;
constexpr double kBatch = 1;  // lessons in a batch: more than this

}  // namespace

double LearntShare::share() const
{
    return 1 / (1 + std::exp(-theta_));
}

void LearntShare::learn(double product, double bsdfPdf, double guidePdf, double pdf)
{
    const double a = share();
    const double mixture = a * bsdfPdf + (1 - a) * guidePdf;
    if (!(product > 0 && mixture > 0 && pdf > 0)) return;
    const double slope = -(product / mixture) / pdf * (bsdfPdf - guidePdf);
    const double gradient = slope * a * (1 - a) + kRegular * theta_;
    if (!std::isfinite(gradient)) return;
    gradient_ += gradient;
    weight_ += 1;
    if (!(weight_ > kBatch)) return;
    step(gradient_ / weight_);
    gradient_ = weight_ = 0;
}

void LearntShare::step(double gradient)
{
    ++steps_;
    first_ = kFirst * first_ + (1 - kFirst) * gradient;
    second_ = kSecond * second_ + (1 - kSecond) * gradient * gradient;
    const double mean = first_ / (1 - std::pow(kFirst, steps_));
    const double square = second_ / (1 - std::pow(kSecond, steps_));
    theta_ -= kRate * mean / (std::sqrt(square) + kLeast);
    theta_ = std::clamp(theta_, -kMostTheta, kMostTheta);
}

}  // namespace core::guiding
