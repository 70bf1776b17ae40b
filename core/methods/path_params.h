// Parameters of the path tracer, the same on every device.
#pragma once

#include "core/base/params.h"

namespace core {

enum class SamplerKind : uint32_t { sobol, independent };
template <> struct EnumNames<SamplerKind> {
    static constexpr std::array<std::string_view, 2> names{"sobol", "independent"};
};

enum class Strategy : uint32_t { mis, bsdf, light };
template <> struct EnumNames<Strategy> {
    static constexpr std::array<std::string_view, 3> names{"mis", "bsdf", "light"};
};

enum class Kernel : uint32_t { automatic, wavefront, megakernel };
template <> struct EnumNames<Kernel> {
    static constexpr std::array<std::string_view, 3> names{"auto", "wavefront", "megakernel"};
};

enum class SkySampling : uint32_t { automatic, whole, regions };
template <> struct EnumNames<SkySampling> {
    static constexpr std::array<std::string_view, 3> names{"auto", "whole", "regions"};
};

// What several methods have in common is one option of the command line: one text.
namespace fields {

constexpr Field maxDepth(double most = 4096)
{
    return {"max-depth",
            "scattering events per path: 0 shows emitters only, 1 adds direct light",
            {0, most}};
}
inline constexpr Field kRouletteDepth{
    "roulette-depth", "scattering events before Russian roulette may end a path", {1, 4096}};
inline constexpr Field kSeed{"seed", "another seed gives an independent image"};
inline constexpr Field kSampler{"sampler",
                                "sobol converges faster; independent obeys every variance formula"};
inline constexpr Field kKernel{
    "kernel", "GPU kernel: auto measures both; software devices run megakernel to depth 32 only"};

inline constexpr Field kSky{
    "sky",
    "how connections draw the environment: as each region of the scene sees it through windows and "
    "doors, or as a whole; auto: by regions where most places see little of it and nothing "
    "moves"};

}  // namespace fields

struct PathParams {
    static constexpr std::string_view kMethod = "path";

    uint32_t maxDepth = 8;
    uint32_t rouletteDepth = 2;
    uint32_t seed = 1;
    SamplerKind sampler = SamplerKind::sobol;
    Strategy strategy = Strategy::mis;
    float clampIndirect = 0;
    Kernel kernel = Kernel::automatic;
    SkySampling sky = SkySampling::automatic;

    template <class Self, class V> static void visit(Self& p, V&& v)
    {
        v(fields::maxDepth(), p.maxDepth);
        v(fields::kRouletteDepth, p.rouletteDepth);
        v(fields::kSeed, p.seed);
        v(fields::kSampler, p.sampler);
        v(Field{"strategy",
                "next-event estimation with MIS, BSDF sampling alone, or light sampling alone"},
          p.strategy);
        v(Field{"clamp-indirect",
                "upper bound of an indirect sample, 0 = off; darkens the image",
                {0, 1e6, true},
                true},
          p.clampIndirect);
        v(fields::kKernel, p.kernel);
        v(fields::kSky, p.sky);
    }
    friend bool operator==(const PathParams&, const PathParams&) = default;
};

}  // namespace core
