// Parameters of guided path tracing, the same on every device.
#pragma once

#include "core/methods/path_params.h"

namespace core {

/// What decides whether a guided path goes on: the throughput that it has by albedo alone, what the
/// guide expects it to bring beside its pixel, or the larger of the two.
enum class GuidedRoulette : uint32_t { both, albedo, light };
template <> struct EnumNames<GuidedRoulette> {
    static constexpr std::array<std::string_view, 3> names{"both", "albedo", "light"};
};

/// How a guide knows directions: shared/guide_histogram.h, shared/guide_lobes.h.
enum class GuideKind : uint32_t { histogram, lobes };
template <> struct EnumNames<GuideKind> {
    static constexpr std::array<std::string_view, 2> names{"histogram", "lobes"};
};

struct GuidedParams {
    static constexpr std::string_view kMethod = "guided";

    GuideKind guide = GuideKind::lobes;
    uint32_t training = 32;
    uint32_t recordOneIn = 0;
    float recordsPerLeaf = 500;
    float share = 0;
    float gate = 1.1f;
    GuidedRoulette roulette = GuidedRoulette::both;
    uint32_t maxDepth = 8;
    uint32_t rouletteDepth = 2;
    uint32_t seed = 1;
    SamplerKind sampler = SamplerKind::sobol;
    Kernel kernel = Kernel::automatic;

    template <class Self, class V> static void visit(Self& p, V&& v)
    {
        v(Field{"guide",
                "how directions are learnt: a histogram of 256 cells, or 8 lobes of any width, "
                "which need fewer paths"},
          p.guide);
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
                "is cut in two",
                {50, 100000, true}},
          p.recordsPerLeaf);
        v(Field{"bsdf-share",
                "share of the BSDF among directions, where the guide knows something; 0: each leaf "
                "takes the one that has had the least variance",
                {0, 1}},
          p.share);
        v(Field{"gate",
                "how many times the variance must fall for a leaf to be guided",
                {1, 10, true}},
          p.gate);
        v(Field{"guided-roulette",
                "what keeps a path alive: its throughput by albedo alone, the light that the guide "
                "expects of it, or the larger of the two (both)"},
          p.roulette);
        v(fields::maxDepth(), p.maxDepth);
        v(fields::kRouletteDepth, p.rouletteDepth);
        v(fields::kSeed, p.seed);
        v(fields::kSampler, p.sampler);
        v(fields::kKernel, p.kernel);
    }
    friend bool operator==(const GuidedParams&, const GuidedParams&) = default;
};

}  // namespace core
