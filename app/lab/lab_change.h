// A pair of densities and all eight functions, as the estimators of core/reuse take them.
#pragma once

#include <span>
#include <vector>

#include "app/lab/pairs.h"
#include "core/reuse/change.h"

namespace app::lab {

/// A point with what is known of it: densities always, f where it is stored (old samples).
struct LabPoint {
    double x = 0, q = 0, p = 0;
    const Values* f = nullptr;
};

class LabChange {
public:
    using Point = LabPoint;
    using Real = double;
    using Value = Values;

    explicit LabChange(const Pair& pair) : pair_(&pair) {}

    double q(const Point& x) const { return x.q; }
    double p(const Point& x) const { return x.p; }
    Values f(const Point& x) const { return x.f ? *x.f : evaluateFunctions(x.x); }

    template <class Random> Point sampleP(Random& random) const
    {
        return at(pair_->p.sample(random()));
    }

    Point at(double x) const { return {x, pair_->q.pdf(x), pair_->p.pdf(x), nullptr}; }

    const Pair& pair() const { return *pair_; }

private:
    const Pair* pair_;
};
static_assert(core::reuse::Change<LabChange>);

/// N samples of the old density with their values, drawn again for every trial without allocating.
class OldSamples {
public:
    OldSamples(const LabChange& change, size_t count)
        : change_(change), points_(count), values_(count)
    {}

    template <class Random> std::span<const LabPoint> draw(Random& random)
    {
        for (size_t i = 0; i < points_.size(); ++i) {
            points_[i] = change_.at(change_.pair().q.sample(random()));
            values_[i] = evaluateFunctions(points_[i].x);
            points_[i].f = &values_[i];
        }
        return points_;
    }

private:
    LabChange change_;
    std::vector<LabPoint> points_;
    std::vector<Values> values_;
};

}  // namespace app::lab
