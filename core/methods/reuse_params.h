// Parameters of path tracing that keeps its samples when the camera moves, the same on every
// device.
#pragma once

#include "core/methods/path_params.h"

namespace core {

/// What is done with old samples; the order is that of shared/reuse_records.h.
enum class ReuseStrategy : uint32_t {
    discard,
    naive,
    reweighting,
    mis,
    ra,
    rejectionAugmentation,
    restirGi,
    svgf,
    full
};
template <> struct EnumNames<ReuseStrategy> {
    static constexpr std::array<std::string_view, 9> names{
        "discard",   "naive", "reweighting", "mis", "ra", "rejection-augmentation",
        "restir-gi", "svgf",  "full"};
};

/// How new paths are given to pixels: as many to each, or more to those whose single paths differ
/// more from each other.
enum class PathAllocation : uint32_t { even, deviation };
template <> struct EnumNames<PathAllocation> {
    static constexpr std::array<std::string_view, 2> names{"even", "deviation"};
};

/// What becomes of the light that a store brings less, or more, after it was cut down: it is kept
/// beside the store and given back in the next frame, or dropped, which is noise.
enum class ReuseRemainder : uint32_t { keep, drop };
template <> struct EnumNames<ReuseRemainder> {
    static constexpr std::array<std::string_view, 2> names{"keep", "drop"};
};

/// Where in its pixel a first hit lies: at the centre while the camera moves and anywhere once it
/// rests (edges are steady, then smooth), or one of the two at all times.
enum class PixelJitter : uint32_t { settled, always, never };
template <> struct EnumNames<PixelJitter> {
    static constexpr std::array<std::string_view, 3> names{"settled", "always", "never"};
};

/// What may be wrong with the mean. Nothing: visibility between first hits and places is asked for
/// again. Up to a bound: as often as keeps what is found to be wrong below it. Or it is not asked.
enum class ReuseBias : uint32_t { fast, bounded, unbiased };
template <> struct EnumNames<ReuseBias> {
    static constexpr std::array<std::string_view, 3> names{"fast", "bounded", "unbiased"};
};

struct ReuseParams {
    static constexpr std::string_view kMethod = "reuse";

    ReuseStrategy reuse = ReuseStrategy::ra;
    // Twice as many leave 1 to 4 per cent less error in a flight, in 1.2 to 1.8 times the time.
    uint32_t records = 4;
    uint32_t lights = 2;
    uint32_t candidates = 8;
    float rays = 1;
    PathAllocation allocation = PathAllocation::even;
    float cap = 32;
    float protection = 1;
    ReuseRemainder remainder = ReuseRemainder::keep;
    ReuseBias bias = ReuseBias::fast;
    float bound = 0.005f;
    PixelJitter jitter = PixelJitter::settled;
    uint32_t maxDepth = 8;
    uint32_t rouletteDepth = 2;
    uint32_t seed = 1;
    SamplerKind sampler = SamplerKind::sobol;

    template <class Self, class V> static void visit(Self& p, V&& v)
    {
        v(Field{"reuse",
                "what old samples are good for: discard them, average them as they are (naive), "
                "reweight them, weigh them by the balance heuristic (mis), "
                "Reweighting-Augmentation (ra); for comparison rejection-augmentation, the "
                "temporal "
                "half of restir-gi, and the accumulation of svgf; as the ceiling of all, as many "
                "fresh paths as the history would stand for (full: slow)"},
          p.reuse);
        v(Field{"records", "samples of arriving light that a pixel keeps", {1, 16}}, p.records);
        v(Field{"lights", "connections to lights that a pixel keeps", {1, 16}}, p.lights);
        v(Field{"candidates",
                "directions among which a new one is chosen where the surface's lobe has moved",
                {1, 32}},
          p.candidates);
        v(Field{"rays",
                "new paths per pixel and view of a camera that moves: below one, pixels with a "
                "good "
                "history take turns",
                {static_cast<double>(0.1f), 4, true}},
          p.rays);
        v(Field{"allocation",
                "who gets the new paths when --rays is 2 or more: every pixel as many (even), or "
                "noisy ones up to eight times as many, by the standard deviation of the paths "
                "before (deviation; not of naive and svgf)"},
          p.allocation);
        v(Field{"history", "old samples that what is kept may stand for", {1, 1024, true}}, p.cap);
        v(Field{"protection",
                "how much bright samples are preferred when the store is cut down",
                {0, 16}},
          p.protection);
        v(Field{"remainder",
                "what a pixel's store brings too little or too much for having been cut down: kept "
                "beside it and given back in the next view, so that a few samples do as well as "
                "all that they stand for, or dropped (noise)"},
          p.remainder);
        v(Field{"bias",
                "whether it is asked again what lies between a surface and where its old samples "
                "come from: never (fast), as often as keeps the error below the bound, or always "
                "(unbiased: several times the rays)"},
          p.bias);
        v(Field{"bound",
                "of the bias, as a part of the picture",
                {static_cast<double>(0.0001f), 1, true}},
          p.bound);
        v(Field{"jitter",
                "first hits anywhere in the pixel, for smooth edges: when the camera rests "
                "(settled), always or never"},
          p.jitter);
        v(fields::maxDepth(32), p.maxDepth);
        v(fields::kRouletteDepth, p.rouletteDepth);
        v(fields::kSeed, p.seed);
        v(fields::kSampler, p.sampler);
    }
    friend bool operator==(const ReuseParams&, const ReuseParams&) = default;
};

}  // namespace core
