// Curves of error over time: fits, times still to go, and which curve a picture belongs to.
//   The noise of such a curve is not independent from point to point, because every point holds all
//   samples of the one before: the mean of m samples shares n of them with the mean of n < m, so
//   squared errors correlate as n / m. In log t the relative error is thus a first-order
//   autoregressive (Ornstein-Uhlenbeck) process of known correlation, and whitening by it (Aitken
//   1936, generalised least squares) gives a slope whose standard error holds. Samples that are
//   less alike (Sobol) make the stated error too large, not too small.
#include "app/pictures/convergence.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "app/pictures/comparison.h"
#include "core/image/metrics.h"

namespace app {
namespace {

constexpr double kFitSpan = 16;  // of time, back from the last point
constexpr double kLeastSpan = 1.5;
constexpr size_t kMostPast = 8, kMostOther = 8 * kMostPast, kLeastKept = 4;

/// A point of the curve in logarithms.
struct LogPoint {
    double t = 0, e = 0;
};

/// The usable points; `floor` is taken away from the errors as independent noise.
std::vector<LogPoint> logPoints(const std::vector<ErrorPoint>& points, bool against, double floor)
{
    std::vector<LogPoint> result;
    for (const ErrorPoint& p : points) {
        const double error = against ? p.rmse : p.estimated;
        const double square = error * error - floor * floor;
        if (!(p.seconds > 0) || !(square > 0) || !std::isfinite(p.seconds) ||
            !std::isfinite(square))
            continue;
        const LogPoint point{std::log(p.seconds), 0.5 * std::log(square)};
        if (result.empty() || point.t > result.back().t) result.push_back(point);
    }
    return result;
}

/// Drops what lies too far back, keeping three points.
void keepLast(std::vector<LogPoint>& points)
{
    size_t first = 0;
    while (points.size() - first > 3 && points[first].t < points.back().t - std::log(kFitSpan))
        ++first;
    points.erase(points.begin(), points.begin() + static_cast<ptrdiff_t>(first));
}

/// Sums of the normal equations of y = a + b x over whitened rows (one, x, y).
struct NormalEquations {
    double oo = 0, ox = 0, xx = 0, oy = 0, xy = 0, yy = 0;
    void add(double o, double x, double y)
    {
        oo += o * o;
        ox += o * x;
        xx += x * x;
        oy += o * y;
        xy += x * y;
        yy += y * y;
    }
};

std::optional<Fit> fitLog(std::vector<LogPoint> points)
{
    keepLast(points);
    if (points.size() < 3 || points.back().t - points.front().t < std::log(kLeastSpan)) return {};
    // Relative to the last point, so that the sums do not cancel.
    const LogPoint origin = points.back();
    NormalEquations sums;
    sums.add(1, points[0].t - origin.t, points[0].e - origin.e);
    for (size_t i = 1; i < points.size(); ++i) {
        const double rho = std::exp(points[i - 1].t - points[i].t);
        const double scale = 1 / std::sqrt(1 - rho * rho);
        const auto white = [&](double before, double now) { return (now - rho * before) * scale; };
        sums.add(white(1, 1), white(points[i - 1].t - origin.t, points[i].t - origin.t),
                 white(points[i - 1].e - origin.e, points[i].e - origin.e));
    }
    const double determinant = sums.oo * sums.xx - sums.ox * sums.ox;
    if (!(determinant > 0)) return {};
    Fit fit;
    fit.points = static_cast<int>(points.size());
    fit.slope = (sums.oo * sums.xy - sums.ox * sums.oy) / determinant;
    const double a = (sums.xx * sums.oy - sums.ox * sums.xy) / determinant;
    const double residual = std::max(0.0, sums.yy - a * sums.oy - fit.slope * sums.xy);
    fit.slopeSe = std::sqrt(residual / (fit.points - 2) * sums.oo / determinant);
    fit.at1 = std::exp(origin.e + a - fit.slope * origin.t);
    return fit;
}

/// Seconds from `last` until the logarithm of the error is `target`, along `slope`.
double secondsAlong(const LogPoint& last, double target, double slope)
{
    return std::exp(last.t) * std::expm1((target - last.e) / std::clamp(slope, -1.0, -0.25));
}

}  // namespace

std::optional<Fit> fitCurve(const std::vector<ErrorPoint>& points, bool against)
{
    return fitLog(logPoints(points, against, 0));
}

std::optional<Eta> etaToError(const std::vector<ErrorPoint>& points, bool against, double target,
                              double referenceNoise)
{
    if (points.empty() || !(target > 0)) return {};
    const double now = against ? points.back().rmse : points.back().estimated;
    if (now > 0 && now <= target) return Eta{};
    const double floor = against ? std::max(referenceNoise, 0.0) : 0;
    if (target <= floor) return {};
    const std::vector<LogPoint> curve = logPoints(points, against, floor);
    const std::optional<Fit> fit = fitLog(curve);
    if (!fit) return {};
    const LogPoint& last = curve.back();
    const double goal = 0.5 * std::log(target * target - floor * floor);
    return Eta{secondsAlong(last, goal, fit->slope),
               secondsAlong(last, goal, fit->slope - fit->slopeSe),
               secondsAlong(last, goal, fit->slope + fit->slopeSe)};
}

double referenceNoise(const Reference& reference)
{
    return core::noiseOf(reference.variance);
}

bool Convergence::continues(const Picture& picture, const CurveView& view) const
{
    if (picture.samples < samples_ || picture.seconds < seconds_) return false;
    if (!sameRendering(picture.params, params_) || view != present_.view) return false;
    // A new start that has overtaken the old picture between two looks differs in its first point.
    if (picture.curve.empty() || present_.points.empty()) return true;
    return picture.curve.front().seconds == present_.points.front().seconds;
}

void Convergence::keepPresent()
{
    if (present_.points.size() >= kLeastKept) past_.push_back(std::move(present_));
    if (past_.size() > kMostPast) past_.erase(past_.begin());
    present_ = {};
}

/// Puts the past curves of another view away and takes out those of the present one.
void Convergence::recall()
{
    if (!past_.empty() && past_.front().view == present_.view) return;
    other_.insert(other_.end(), std::make_move_iterator(past_.begin()),
                  std::make_move_iterator(past_.end()));
    past_.clear();
    const auto here = std::stable_partition(other_.begin(), other_.end(), [&](const Curve& curve) {
        return curve.view != present_.view;
    });
    past_.assign(std::make_move_iterator(here), std::make_move_iterator(other_.end()));
    other_.erase(here, other_.end());
    if (other_.size() > kMostOther)
        other_.erase(other_.begin(), other_.end() - static_cast<ptrdiff_t>(kMostOther));
}

void Convergence::take(const Picture& picture, const std::string& scene)
{
    if (picture.preview || picture.samples == 0) return;
    CurveView view{scene, picture.camera, picture.fullSize};
    if (!continues(picture, view)) {
        keepPresent();
        present_.view = std::move(view);
        recall();
        params_ = picture.params;
    }
    samples_ = picture.samples;
    seconds_ = picture.seconds;
    present_.label = paramsLabel(picture.params);
    present_.points = picture.curve;
    // The last point's: the reference may have been dropped since the earlier ones.
    present_.against = !picture.curve.empty() && picture.curve.back().rmse > 0;
}

void Convergence::clearPast()
{
    past_.clear();
}

}  // namespace app
