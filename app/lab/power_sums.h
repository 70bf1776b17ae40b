// Mean, variance and the standard error of the variance, from power sums about a point near the
// mean. Sums of parts are added in a fixed order, so results do not depend on threads.
#pragma once

#include <cmath>
#include <cstdint>

namespace app::lab {

class PowerSums {
public:
    /// d: the value less the centre, which is the same for all.
    void add(double d)
    {
        const double d2 = d * d;
        ++count_;
        s1_ += d;
        s2_ += d2;
        s3_ += d2 * d;
        s4_ += d2 * d2;
    }

    void merge(const PowerSums& other)
    {
        count_ += other.count_;
        s1_ += other.s1_;
        s2_ += other.s2_;
        s3_ += other.s3_;
        s4_ += other.s4_;
    }

    uint64_t count() const { return count_; }
    double mean() const { return s1_ / n(); }  // less the centre
    double variance() const { return std::fmax(0, (s2_ - s1_ * mean()) / (n() - 1)); }
    double standardError() const { return std::sqrt(variance() / n()); }
    /// Standard errors between mean and centre; finite whenever something varies.
    double z() const { return mean() / std::fmax(standardError(), 1e-300); }

    /// Of variance(): its square times (kurtosis - 1) / n.
    double varianceError() const
    {
        const double m = mean();
        const double fourth =
            s4_ / n() - 4 * m * s3_ / n() + 6 * m * m * s2_ / n() - 3 * m * m * m * m;
        const double v = variance();
        return std::sqrt(std::fmax(0, fourth - v * v) / n());
    }

private:
    double n() const { return static_cast<double>(count_); }

    uint64_t count_ = 0;
    double s1_ = 0, s2_ = 0, s3_ = 0, s4_ = 0;
};

}  // namespace app::lab
