// Parameters of rendering with many lights, the same on every device.
#pragma once

#include "core/completion/completion_params.h"
#include "core/many_lights/light_shape.h"
#include "core/many_lights/technique_params.h"
#include "core/methods/path_params.h"
#include "core/methods/reuse_params.h"

namespace core {

/// What becomes of the light that virtual lights do not bring (core/many_lights/lost_light.h).
enum class LostLight : uint32_t { paths, dropped };
template <> struct EnumNames<LostLight> {
    static constexpr std::array<std::string_view, 2> names{"paths", "dropped"};
};

struct ManyLightsParams {
    static constexpr std::string_view kMethod = "manylights";

    uint32_t lights = 10000;
    many_lights::Technique technique = many_lights::Technique::clusters;
    uint32_t clusters = 250;
    float error = 0.02f;
    uint32_t receivers = 1;
    uint32_t sliceSize = 1000;
    float clamp = 0.1f;
    many_lights::LightShape lightShape = many_lights::LightShape::point;
    LostLight lost = LostLight::paths;
    many_lights::CompletionParams completion{.method = many_lights::CompletionMethod::full};
    PixelJitter jitter = PixelJitter::settled;
    uint32_t maxDepth = 8;
    uint32_t seed = 1;
    SamplerKind sampler = SamplerKind::sobol;

    template <class Self, class V> static void visit(Self& p, V&& v)
    {
        v(Field{"lights",
                "virtual lights of a sample, about; every sample (--spp) has lights of its own",
                {1, 4e6, true}},
          p.lights);
        v(Field{"technique",
                "how lights are chosen that stand for all: for each slice by a cut through a tree "
                "of lights (clusters) or by what points of its neighbourhood see (lightslice), the "
                "same for the whole picture (row-column), for each point (lightcuts: a little "
                "biased, for where a cut ends depends on the lights that stand for others), or for "
                "groups of points, with some visibility guessed (illumination-cut: biased); "
                "matsep: clusters whose visibility is predicted from places, neighbours and "
                "lights nearby, and whose matrix is then made of low rank (biased). The last "
                "three go by error and have no completion",
                {},
                true,
                1u << static_cast<uint32_t>(many_lights::Technique::lightslice) |
                    1u << static_cast<uint32_t>(many_lights::Technique::rowColumn)},
          p.technique);
        v(Field{"clusters",
                "lights for which a slice of the picture is lit; each stands for many (lightcuts: "
                "at most, for each point; illumination-cut: not used)",
                {1, 2e5, true}},
          p.clusters);
        v(Field{"error",
                "lightcuts and illumination-cut: what a cluster of lights may err, over the light "
                "of the point; matsep: which part of a cluster's predictions may be wrong",
                {0, 1, true}},
          p.error);
        v(Field{"receivers",
                "points of each pixel that are lit in a sample, rounded up to a square",
                {1, 64}},
          p.receivers);
        v(Field{"slice-size",
                "points from which a slice of the picture is split in two",
                {64, 8192, true}},
          p.sliceSize);
        v(Field{"clamp",
                "below which distance lights do not become brighter: 0 never, 1 the thesis's, "
                "about a third of a room, in proportion between",
                {0, 4}},
          p.clamp);
        v(Field{"light-shape",
                "what a virtual light shines from: a point, or a sphere or a disc, as wide as the "
                "lights around it are apart (both are biased: they blur); these need no clamp. "
                "lightcuts, illumination-cut and matsep know points only",
                {},
                true},
          p.lightShape);
        v(Field{"lost-light",
                "what the clamp takes, and what comes by mirrors and clear glass: found by a "
                "path from each point (paths), or missing (dropped)",
                {},
                true},
          p.lost);
        many_lights::CompletionParams::visit(p.completion, v);
        v(Field{"jitter",
                "where in its part of the pixel a point lies: in the middle in the first sample "
                "and anywhere in later ones (settled), or one of the two at all times"},
          p.jitter);
        v(fields::maxDepth(), p.maxDepth);
        v(fields::kSeed, p.seed);
        v(fields::kSampler, p.sampler);
    }
    friend bool operator==(const ManyLightsParams&, const ManyLightsParams&) = default;
};

}  // namespace core
