// Parameters of guided path tracing, the same on every device.
#pragma once

#include "core/guiding/guide_options.h"
#include "core/methods/path_params.h"

namespace core {

/// What decides whether a guided path goes on: the throughput that it has by albedo alone, what the
/// guide expects it to bring beside its pixel, or the larger of the two. `none`: by albedo until
/// the guide has learnt, then nothing.
enum class GuidedRoulette : uint32_t { both, albedo, light, none };
template <> struct EnumNames<GuidedRoulette> {
    static constexpr std::array<std::string_view, 4> names{"both", "albedo", "light", "none"};
};

/// How a guide knows directions: shared/guide_histogram.h, guide_lobes.h, guide_tree.h.
enum class GuideKind : uint32_t { histogram, lobes, tree };
template <> struct EnumNames<GuideKind> {
    static constexpr std::array<std::string_view, 3> names{"histogram", "lobes", "tree"};
};

/// When a guide learns: after every sample at first and then ever more seldom, or after 1, 2, 4, 8,
/// ... further samples (2017).
enum class GuideSchedule : uint32_t { steady, doubling };
template <> struct EnumNames<GuideSchedule> {
    static constexpr std::array<std::string_view, 2> names{"steady", "doubling"};
};

// Of how a guide learns: core/guiding/guide_options.h.
using guiding::GuideFilter, guiding::GuideMemory, guiding::GuideSpace, guiding::GuideTarget,
    guiding::ShareBy;
template <> struct EnumNames<GuideSpace> {
    static constexpr std::array<std::string_view, 2> names{"normals", "plain"};
};
template <> struct EnumNames<GuideTarget> {
    static constexpr std::array<std::string_view, 3> names{"product", "radiance", "second-moment"};
};
template <> struct EnumNames<GuideMemory> {
    static constexpr std::array<std::string_view, 4> names{"keep", "reset", "balance", "residual"};
};
template <> struct EnumNames<GuideFilter> {
    static constexpr std::array<std::string_view, 2> names{"nearest", "spread"};
};
template <> struct EnumNames<ShareBy> {
    static constexpr std::array<std::string_view, 2> names{"argmin", "adam"};
};

/// Density that next-event estimation is weighted against: the BSDF's, the mixture's; or no
/// next-event estimation but of what directions cannot meet.
enum class GuidedNee : uint32_t { bsdf, mixture, none };
template <> struct EnumNames<GuidedNee> {
    static constexpr std::array<std::string_view, 3> names{"bsdf", "mixture", "none"};
};

/// Weights of the iterations in the picture (core/guiding/combination.h). `trial`: samples from
/// before the guide was followed count as much less as it was found to be better.
enum class Combine : uint32_t { samples, inverseVariance, meanInverseVariance, ess, trial };
template <> struct EnumNames<Combine> {
    static constexpr std::array<std::string_view, 5> names{"samples", "inverse-variance",
                                                           "mean-inverse-variance", "ess", "trial"};
};

/// Pixels that have weights in common: all, those of a tile of 8x8, each alone.
enum class CombineOver : uint32_t { picture, tile, pixel };
template <> struct EnumNames<CombineOver> {
    static constexpr std::array<std::string_view, 3> names{"picture", "tile", "pixel"};
};

/// Samples that weights are taken from: those they multiply, or the other half of each iteration.
/// Halves of a Sobol sequence are not independent: weights of single pixels then leave a bias, too.
enum class CombineFrom : uint32_t { own, crossed };
template <> struct EnumNames<CombineFrom> {
    static constexpr std::array<std::string_view, 2> names{"own", "crossed"};
};

/// When the guide has a say: where it is thought to pay for what it costs, or always.
enum class GuideUse : uint32_t { pays, always };
template <> struct EnumNames<GuideUse> {
    static constexpr std::array<std::string_view, 2> names{"pays", "always"};
};

struct GuidedParams {
    static constexpr std::string_view kMethod = "guided";

    GuideKind guide = GuideKind::lobes;
    GuideUse use = GuideUse::pays;
    GuideSpace space = GuideSpace::normals;
    GuideTarget target = GuideTarget::product;
    GuideMemory memory = GuideMemory::keep;
    GuideSchedule schedule = GuideSchedule::steady;
    GuideFilter filter = GuideFilter::nearest;
    uint32_t training = 32;
    uint32_t recordOneIn = 0;
    float recordsPerLeaf = 500;
    uint32_t depth = 64;
    float share = 0;
    ShareBy shareBy = ShareBy::argmin;
    float gate = 1.1f;
    GuidedNee nee = GuidedNee::bsdf;
    GuidedRoulette roulette = GuidedRoulette::both;
    Combine combine = Combine::trial;
    CombineOver combineOver = CombineOver::picture;
    CombineFrom combineFrom = CombineFrom::own;
    uint32_t combineLast = 0;
    uint32_t maxDepth = 8;
    uint32_t rouletteDepth = 2;
    uint32_t seed = 1;
    SamplerKind sampler = SamplerKind::sobol;
    Kernel kernel = Kernel::automatic;
    SkySampling sky = SkySampling::automatic;

    template <class Self, class V> static void visit(Self& p, V&& v)
    {
        v(Field{"guide",
                "how directions are learnt: a histogram of 256 cells, 8 lobes of any width, which "
                "need fewer paths, or a quadtree"},
          p.guide);
        v(Field{"guide-use",
                "pays: the guide looks on until the paths that it sees say that it would save "
                "time, and gives up where they do not; always: it is followed from the start"},
          p.use);
        v(Field{"guide-space",
                "what has a leaf of its own: places by the surface's normal, or plain places"},
          p.space);
        v(Field{"guide-target",
                "density that directions are to have: that of the light that is scattered on "
                "(product), of the light that arrives (radiance), or the root of the second moment "
                "of estimates of the first, which lobes do not have (they take the product)"},
          p.target);
        v(Field{"guide-memory",
                "what directions are learnt from beside the last records: all there have been "
                "(keep), none (reset), those of the iteration before by the balance heuristic, or "
                "the same while directions are drawn from what those lack (residual; tree alone, "
                "others balance)"},
          p.memory);
        v(Field{"guide-schedule",
                "when the guide learns: often at first (steady), or after 1, 2, 4, ... samples "
                "more"},
          p.schedule);
        v(Field{"guide-filter",
                "whether records teach their own leaf alone, or are spread over as much space and "
                "directions (of a tree) as it has"},
          p.filter);
        v(Field{"training",
                "samples per pixel of each view from which the guide learns; 0: no guide, the path "
                "tracer's picture",
                {0, 4096}},
          p.training);
        v(Field{"record-one-in",
                "one path in so many (a power of two) is recorded for the guide; 0: chosen by the "
                "size of the picture, and fewer after some samples",
                {0, 64}},
          p.recordOneIn);
        v(Field{"leaf-records",
                "records, times the root of the samples per pixel, after which a leaf of the guide "
                "is cut in two; 0: any leaf that has some",
                {0, 100000, true}},
          p.recordsPerLeaf);
        v(Field{"guide-depth", "how often a leaf may be cut", {0, 64}}, p.depth);
        v(Field{"bsdf-share",
                "share of the BSDF among directions, where the guide knows something; 0: each leaf "
                "has its own",
                {0, 1}},
          p.share);
        v(Field{"share-by",
                "how each leaf finds its share: the one that has had the least variance and only "
                "where that is a gain, or by stochastic descent"},
          p.shareBy);
        v(Field{"gate",
                "how many times the variance must fall for a leaf to be guided",
                {1, 10, true}},
          p.gate);
        v(Field{"guided-nee",
                "next-event estimation, weighted against the density of the BSDF or of the "
                "mixture; none: but of lamps that no direction meets"},
          p.nee);
        v(Field{"guided-roulette",
                "what keeps a path alive: its throughput by albedo alone, the light that the guide "
                "expects of it, the larger of the two (both); none: everything, once the guide has "
                "learnt"},
          p.roulette);
        v(Field{"combine",
                "weights of the iterations between lessons: less for samples from before the guide "
                "was followed (trial), their samples, or what their own noise says, which makes "
                "pictures a little darker",
                {},
                true,
                1u << static_cast<uint32_t>(Combine::samples)},
          p.combine);
        v(Field{"combine-over", "pixels that have these weights in common"}, p.combineOver);
        v(Field{"combine-from",
                "whose noise makes the weights: that of the samples they multiply, or of the other "
                "half of each iteration (crossed: without bias where samples are independent)"},
          p.combineFrom);
        v(Field{"combine-last",
                "how many iterations are in the picture, counted from the last; 0: all. Not with "
                "--combine trial, which has weights for all",
                {0, 64}},
          p.combineLast);
        v(fields::maxDepth(), p.maxDepth);
        v(fields::kRouletteDepth, p.rouletteDepth);
        v(fields::kSeed, p.seed);
        v(fields::kSampler, p.sampler);
        v(fields::kKernel, p.kernel);
        v(fields::kSky, p.sky);
    }
    friend bool operator==(const GuidedParams&, const GuidedParams&) = default;
};

}  // namespace core
