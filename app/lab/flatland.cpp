// See flatland.h.
#include "app/lab/flatland.h"

#include "app/lab/blocks.h"
#include "app/lab/flatland_scene.h"
#include "app/lab/power_sums.h"
#include "app/lab/theory.h"

namespace app::lab {

namespace {

struct FlatlandSums {
    PowerSums value, weight;
};

FlatlandSums runBlock(const FlatlandSettings& s, uint64_t block, uint64_t trials, double truth)
{
    core::Pcg32 old(s.seed, block * 4), candidates(s.seed, block * 4 + 1),
        selection(s.seed, block * 4 + 2);
    std::vector<FlatlandChange::Point> landed;
    landed.reserve(4 * s.N);
    FlatlandSums sums;
    for (uint64_t trial = 0; trial < trials; ++trial) {
        drawOld(s, old, landed);
        const FlatlandEstimate e = reuseInFlatland(s, landed, candidates, selection);
        sums.value.add(corrected(e, s) - truth);
        sums.weight.add(e.weightSum - 1);
    }
    return sums;
}

}  // namespace

double flatlandTruth(const FlatlandSettings& settings, const FlatCamera& seenFrom)
{
    return integrate({0, 1}, [&](double pixel) {
        const double g = kNewCamera.ground(settings.pixelLow + settings.pixelWidth * pixel);
        const Lobe lobe(mirror(seenFrom, g));
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
