// What there is in flatland, and the change of density that samples of the old camera are under:
// shared by its measurements and by its picture. See flatland.h.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "app/lab/flatland.h"
#include "core/reuse/reweighting_augmentation.h"

namespace app::lab {

inline constexpr double kLobe = 0.15;

/// sin of the mirror direction at g.
inline double mirror(const FlatCamera& camera, double g)
{
    return (g - camera.x) / std::hypot(g - camera.x, camera.height);
}

/// Cauchy about the mirror direction, truncated to sines in [-1, 1].
struct Lobe {
    double centre, low, span;

    explicit Lobe(double mirror)
        : centre(mirror), low(std::atan((-1 - mirror) / kLobe)),
          span(std::atan((1 - mirror) / kLobe) - low)
    {}
    double pdf(double t) const
    {
        if (!(t >= -1 && t <= 1)) return 0;
        const double d = t - centre;
        return kLobe / (span * (kLobe * kLobe + d * d));
    }
    double sample(double xi) const
    {
        return std::clamp(centre + kLobe * std::tan(low + xi * span), -1.0, 1.0);
    }
};

inline bool visibleFromOld(double g)
{
    return !(g > kHiddenFromOld.low && g < kHiddenFromOld.high);
}

/// Light from direction t towards ground point g.
inline double incident(double g, double t)
{
    return (1 + 0.3 * t) * (1 + std::sin(5 * t) + 0.5 * std::cos(3 * g + 4 * t));
}

/// Densities are per new pixel and unit of t.
struct FlatlandChange {
    struct Point {
        double g, t;
    };
    using Real = double;
    using Value = double;

    const FlatlandSettings* settings;

    double q(const Point& x) const
    {
        if (settings->projection.visibility && !visibleFromOld(x.g)) return 0;
        const double jacobian =
            settings->projection.jacobian ? kNewCamera.height / kOldCamera.height : 1;
        return jacobian * Lobe(mirror(kOldCamera, x.g)).pdf(x.t);
    }
    double p(const Point& x) const { return Lobe(mirror(kNewCamera, x.g)).pdf(x.t); }
    double f(const Point& x) const { return p(x) * incident(x.g, x.t); }

    template <class Random> Point sampleP(Random& random) const
    {
        const double g = kNewCamera.ground(settings->pixelLow + settings->pixelWidth * random());
        return {g, Lobe(mirror(kNewCamera, g)).sample(random())};
    }
};

/// The old image's samples that land in the new pixel: those of every old pixel that the new one's
/// footprint touches.
inline void drawOld(const FlatlandSettings& s, core::Pcg32& random,
                    std::vector<FlatlandChange::Point>& landed)
{
    landed.clear();
    const double low = kNewCamera.ground(s.pixelLow),
                 high = kNewCamera.ground(s.pixelLow + s.pixelWidth);
    const double first = std::floor(kOldCamera.project(low) / s.pixelWidth + 1e-9);
    const double last = std::ceil(kOldCamera.project(high) / s.pixelWidth - 1e-9);
    for (double pixel = first; pixel < last; ++pixel) {
        for (uint32_t i = 0; i < s.N; ++i) {
            const double g = kOldCamera.ground((pixel + random()) * s.pixelWidth);
            const double t = Lobe(mirror(kOldCamera, g)).sample(random());
            if (g >= low && g < high && visibleFromOld(g)) landed.push_back({g, t});
        }
    }
}

using FlatlandEstimate = core::reuse::EstimateOf<FlatlandChange>;

/// R-A of the new pixel from the old samples that landed in it.
inline FlatlandEstimate reuseInFlatland(const FlatlandSettings& s,
                                        const std::vector<FlatlandChange::Point>& landed,
                                        core::Pcg32& candidates, core::Pcg32& selection)
{
    using namespace core::reuse;
    return reweightingAugmentation(
        FlatlandChange{&s}, std::span<const FlatlandChange::Point>(landed),
        static_cast<double>(s.N), s.n, s.k, MinimumFraction<double>{s.c}, candidates, selection);
}

/// The estimate with what its settings subtract.
inline double corrected(const FlatlandEstimate& e, const FlatlandSettings& s)
{
    switch (s.beta) {
    case Beta::none:
        return e.value;
    case Beta::ideal:
        return e.corrected(s.betaValue);
    case Beta::own:
        return e.selfNormalised();
    }
    return e.value;
}

}  // namespace app::lab
