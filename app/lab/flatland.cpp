// See flatland.h.
#include "app/lab/flatland.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "app/lab/blocks.h"
#include "app/lab/power_sums.h"
#include "app/lab/theory.h"
#include "core/reuse/reweighting_augmentation.h"

namespace app::lab {

namespace {

constexpr double kLobe = 0.15;

/// sin of the mirror direction at g.
double mirror(const FlatCamera& camera, double g)
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

bool visibleFromOld(double g)
{
    return !(g > kHiddenFromOld.low && g < kHiddenFromOld.high);
}

/// Light from direction t towards ground point g.
double incident(double g, double t)
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
void drawOld(const FlatlandSettings& s, core::Pcg32& random,
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

double corrected(const core::reuse::EstimateOf<FlatlandChange>& e, const FlatlandSettings& s)
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

struct FlatlandSums {
    PowerSums value, weight;
};

FlatlandSums runBlock(const FlatlandSettings& s, uint64_t block, uint64_t trials, double truth)
{
    using namespace core::reuse;
    core::Pcg32 old(s.seed, block * 4), candidates(s.seed, block * 4 + 1),
        selection(s.seed, block * 4 + 2);
    std::vector<FlatlandChange::Point> landed;
    landed.reserve(4 * s.N);
    FlatlandSums sums;
    for (uint64_t trial = 0; trial < trials; ++trial) {
        drawOld(s, old, landed);
        const auto e = reweightingAugmentation(FlatlandChange{&s},
                                               std::span<const FlatlandChange::Point>(landed),
                                               static_cast<double>(s.N), s.n, s.k,
                                               MinimumFraction<double>{s.c}, candidates, selection);
        sums.value.add(corrected(e, s) - truth);
        sums.weight.add(e.weightSum - 1);
    }
    return sums;
}

}  // namespace

double flatlandTruth(const FlatlandSettings& settings)
{
    return integrate({0, 1}, [&](double pixel) {
        const double g = kNewCamera.ground(settings.pixelLow + settings.pixelWidth * pixel);
        const Lobe lobe(mirror(kNewCamera, g));
        return 2 * integrate({0, (lobe.centre + 1) / 2, 1}, [&](double s) {
                   const double t = 2 * s - 1;
                   return lobe.pdf(t) * incident(g, t);
               });
    });
}

FlatlandResult flatland(const FlatlandSettings& settings, std::stop_token stop)
{
    constexpr uint64_t kBlock = 4096;
    FlatlandResult result;
    result.truth = flatlandTruth(settings);
    const auto found = runBlocks(
        settings.trials, kBlock,
        [&](uint64_t block, uint64_t trials) {
            return runBlock(settings, block, trials, result.truth);
        },
        [](FlatlandSums& into, const FlatlandSums& from) {
            into.value.merge(from.value);
            into.weight.merge(from.weight);
        },
        stop);
    if (!found) return result;
    const PowerSums& sums = found->value;
    result.trials = sums.count();
    result.mean = result.truth + sums.mean();
    result.bias = sums.mean() / result.truth;
    result.z = sums.z();
    result.variance = sums.variance();
    result.varianceError = sums.varianceError();
    result.meanWeight = 1 + found->weight.mean();
    return result;
}

std::vector<FlatlandResult> flatlandVariants(uint64_t trials, uint64_t seed,
                                             const std::function<void(double)>& step,
                                             std::stop_token stop)
{
    struct Variant {
        const char *name, *meaning;
        bool unbiased;
        FlatlandSettings settings;
        double bias = kUnknown, variance = kUnknown;  // as computed independently beforehand
    };
    const auto with = [](uint32_t N, double c, Beta beta = Beta::none, Projection projection = {}) {
        FlatlandSettings s;
        s.N = N;
        s.c = c;
        s.beta = beta;
        s.projection = projection;
        return s;
    };
    const Variant variants[] = {
        {"discard", "four new samples, nothing reused", true, with(8, 0), 0, 0.1118},
        {"exact",
         "every sample lands where its point of the ground is seen now, with Jacobian and "
         "visibility",
         true, with(8, 0.6), 0, 0.1005},
        {"exact, corrected", "the noise of the landing count taken out by a neighbour's value",
         true, with(8, 0.6, Beta::ideal), 0, 0.0745},
        {"exact, 32 old", "more history in the same frame: raw, the random count eats the gain",
         true, with(32, 4), 0, 0.1562},
        {"exact, 32 old, corrected", "the same with the correction", true, with(32, 4, Beta::ideal),
         0, 0.0509},
        {"exact, 32 old, self-normalised", "corrected by its own value: a small bias", false,
         with(32, 4, Beta::own), kUnknown, 0.0480},
        {"no Jacobian", "forgets that the old image is sparser there", false,
         with(8, 0.6, Beta::none, {false, true}), -0.032, kUnknown},
        {"no visibility", "believes in old samples where the old camera saw something else", false,
         with(8, 0.6, Beta::none, {true, false}), -0.085, kUnknown},
    };
    std::vector<FlatlandResult> results;
    for (const Variant& v : variants) {
        FlatlandSettings settings = v.settings;
        settings.trials = trials;
        settings.seed = seed;
        FlatlandResult r = flatland(settings, stop);
        if (r.trials == 0) return {};
        r.variant = v.name;
        r.meaning = v.meaning;
        r.unbiased = v.unbiased;
        r.expectedBias = v.bias;
        r.expectedVariance = v.variance;
        results.push_back(std::move(r));
        step(static_cast<double>(results.size()) / static_cast<double>(std::size(variants)));
    }
    return results;
}

}  // namespace app::lab
