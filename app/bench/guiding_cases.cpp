// See guiding_cases.h.
#include "app/bench/guiding_cases.h"

#include <algorithm>
#include <array>

#include "app/base/nearest.h"
#include "core/base/check.h"

namespace app::guiding {

namespace {

using core::GuidedParams;

constexpr std::array kVariants{
    Variant{"path", "path tracing without a guide", nullptr, true},
    Variant{"guided", "the guide as the command line has it", [](GuidedParams&) {}, true},
    Variant{"half-share", "half of all directions from the BSDF, wherever there is a guide",
            [](GuidedParams& p) { p.share = 0.5f; }},
    Variant{"no-gate", "every leaf is guided that thinks it gains anything",
            [](GuidedParams& p) { p.gate = 1; }},
    Variant{"histogram", "directions are learnt in 256 cells",
            [](GuidedParams& p) { p.guide = core::GuideKind::histogram; }},
    Variant{"by-albedo", "roulette by throughput alone",
            [](GuidedParams& p) { p.roulette = core::GuidedRoulette::albedo; }},
    Variant{"by-light", "roulette by the light that is expected alone",
            [](GuidedParams& p) { p.roulette = core::GuidedRoulette::light; }},
    Variant{"record-all", "every path is recorded", [](GuidedParams& p) { p.recordOneIn = 1; }},
    Variant{"record-4th", "one path in four is recorded",
            [](GuidedParams& p) { p.recordOneIn = 4; }},
    Variant{"large-leaves", "leaves are cut after twice the records",
            [](GuidedParams& p) { p.recordsPerLeaf *= 2; }},
    Variant{"small-leaves", "leaves are cut after half the records",
            [](GuidedParams& p) { p.recordsPerLeaf /= 2; }},
};

}  // namespace

std::span<const Variant> variantTable()
{
    return kVariants;
}

std::vector<const Variant*> variantsOf(const GuidingBenchOptions& options)
{
    std::vector<const Variant*> chosen;
    for (const Variant& v : kVariants) {
        const bool named = std::ranges::find(options.variants, v.name) != options.variants.end();
        const bool asked = options.variants.empty() ? v.isMain || !options.quick : named;
        if (asked || v.change == nullptr) chosen.push_back(&v);
    }
    return chosen;
}

core::AnyParams paramsOf(const Variant& variant, const GuidedParams& common, uint32_t seed)
{
    GuidedParams guided = common;
    guided.seed = seed;
    if (variant.change != nullptr) {
        variant.change(guided);
        return guided;
    }
    core::PathParams path;
    path.maxDepth = guided.maxDepth;
    path.rouletteDepth = guided.rouletteDepth;
    path.seed = guided.seed;
    path.sampler = guided.sampler;
    path.kernel = guided.kernel;
    return path;
}

void requireVariants(const std::vector<std::string>& names)
{
    std::vector<std::string> known;
    std::string all;
    for (const Variant& v : kVariants) {
        known.emplace_back(v.name);
        all += (all.empty() ? "" : ", ") + known.back();
    }
    for (const std::string& name : names)
        if (std::ranges::find(known, name) == known.end())
            throw core::Error("--variants: '" + name + "' is not one of " + all +
                                  suggestion(name, known),
                              core::ExitCode::commandLine);
}

}  // namespace app::guiding
