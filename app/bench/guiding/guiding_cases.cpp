// See guiding_cases.h.
#include "app/bench/guiding/guiding_cases.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "app/base/nearest.h"
#include "core/base/check.h"
#include "core/methods/method.h"

namespace app::guiding {

namespace {

using core::Combine, core::CombineFrom, core::CombineOver, core::GuideMemory;
using core::GuidedParams;

/// A preset of the method, with training for half of the samples.
void preset(GuidedParams& p, std::string_view name, uint32_t spp)
{
    for (const core::MethodPreset& known : core::methodNamed(GuidedParams::kMethod).presets) {
        if (known.name != name) continue;
        const GuidedParams common = p;
        p = known.params.as<GuidedParams>();
        p.training = std::max(spp / 2, 1u);
        p.maxDepth = common.maxDepth;
        p.rouletteDepth = common.rouletteDepth;
        p.seed = common.seed;
        p.sampler = common.sampler;
        p.kernel = common.kernel;
        p.sky = common.sky;
    }
}

/// Iterations of 1, 2, 4, ... samples, the last of which has half of all.
void doubling(GuidedParams& p, uint32_t spp)
{
    p.schedule = core::GuideSchedule::doubling;
    p.training = std::max(spp / 2, 1u);
}

/// What training with and without old records is compared on: trees, which all memories know.
template <GuideMemory memory> void trainedWith(GuidedParams& p, uint32_t spp)
{
    doubling(p, spp);
    p.use = core::GuideUse::always;
    p.combine = Combine::samples;
    p.guide = core::GuideKind::tree;
    p.memory = memory;
}

template <Combine by, CombineOver over, CombineFrom from = CombineFrom::own, uint32_t last = 0>
void combined(GuidedParams& p, uint32_t spp)
{
    doubling(p, spp);
    p.use = core::GuideUse::always;
    p.combine = by;
    p.combineOver = over;
    p.combineFrom = from;
    p.combineLast = last;
}

/// A plain tree whose leaves are all so many cuts below its root.
template <uint32_t depth, GuideMemory memory> void atDepth(GuidedParams& p, uint32_t spp)
{
    trainedWith<memory>(p, spp);
    p.space = core::GuideSpace::plain;
    p.recordsPerLeaf = 0;
    p.depth = depth;
}

constexpr auto kPicture = CombineOver::picture;

constexpr std::array kVariants{
    Variant{"path", "path tracing without a guide", nullptr, true},
    Variant{"guided", "the guide as the command line has it", [](GuidedParams&, uint32_t) {}, true},
    Variant{"always", "the guide is followed from the first sample on, whatever it costs",
            [](GuidedParams& p, uint32_t) { p.use = core::GuideUse::always; }},
    Variant{"all-samples", "those from before the guide was followed count as much as others",
            [](GuidedParams& p, uint32_t) { p.combine = Combine::samples; }},
    Variant{"half-share", "half of all directions from the BSDF, wherever there is a guide",
            [](GuidedParams& p, uint32_t) { p.share = 0.5f; }},
    Variant{"no-gate", "every leaf is guided that thinks it gains anything",
            [](GuidedParams& p, uint32_t) { p.gate = 1; }},
    Variant{"histogram", "directions are learnt in 256 cells",
            [](GuidedParams& p, uint32_t) { p.guide = core::GuideKind::histogram; }},
    Variant{"tree", "directions are learnt in a quadtree",
            [](GuidedParams& p, uint32_t) { p.guide = core::GuideKind::tree; }},
    Variant{"by-albedo", "roulette by throughput alone",
            [](GuidedParams& p, uint32_t) { p.roulette = core::GuidedRoulette::albedo; }},
    Variant{"by-light", "roulette by the light that is expected alone",
            [](GuidedParams& p, uint32_t) { p.roulette = core::GuidedRoulette::light; }},
    Variant{"record-all", "every path is recorded",
            [](GuidedParams& p, uint32_t) { p.recordOneIn = 1; }},
    Variant{"record-4th", "one path in four is recorded",
            [](GuidedParams& p, uint32_t) { p.recordOneIn = 4; }},
    Variant{"large-leaves", "leaves are cut after twice the records",
            [](GuidedParams& p, uint32_t) { p.recordsPerLeaf *= 2; }},
    Variant{"small-leaves", "leaves are cut after half the records",
            [](GuidedParams& p, uint32_t) { p.recordsPerLeaf /= 2; }},

    Variant{"ppg", "practical path guiding as published in 2017",
            [](GuidedParams& p, uint32_t spp) { preset(p, "ppg", spp); }, false, Family::papers},
    Variant{"ppg-nee", "the same with next-event estimation, weighted against the mixture",
            [](GuidedParams& p, uint32_t spp) {
                preset(p, "ppg", spp);
                p.nee = core::GuidedNee::mixture;
            },
            false, Family::papers},
    Variant{"ppg-production", "practical path guiding as improved in 2019",
            [](GuidedParams& p, uint32_t spp) { preset(p, "ppg-production", spp); }, false,
            Family::papers},
    Variant{"plain", "one tree of places, whatever their normal",
            [](GuidedParams& p, uint32_t) { p.space = core::GuideSpace::plain; }, false,
            Family::papers},
    Variant{"radiance", "directions follow the light that arrives",
            [](GuidedParams& p, uint32_t) { p.target = core::GuideTarget::radiance; }, false,
            Family::papers},
    Variant{"second-moment", "directions of trees follow the root of the second moment",
            [](GuidedParams& p, uint32_t) {
                p.guide = core::GuideKind::tree;
                p.target = core::GuideTarget::secondMoment;
            },
            false, Family::papers},
    Variant{"doubling", "the guide learns after 1, 2, 4, ... further samples", doubling, false,
            Family::papers},
    Variant{"spread", "records of trees are spread over their leaf's size",
            [](GuidedParams& p, uint32_t) {
                p.guide = core::GuideKind::tree;
                p.filter = core::GuideFilter::spread;
            },
            false, Family::papers},
    Variant{"adam", "the share of the BSDF is learnt by descent",
            [](GuidedParams& p, uint32_t) { p.shareBy = core::ShareBy::adam; }, false,
            Family::papers},
    Variant{"mixture", "next-event estimation is weighted against the mixture",
            [](GuidedParams& p, uint32_t) { p.nee = core::GuidedNee::mixture; }, false,
            Family::papers},
    Variant{"no-nee", "no next-event estimation",
            [](GuidedParams& p, uint32_t) { p.nee = core::GuidedNee::none; }, false,
            Family::papers},
    Variant{"no-roulette", "no path ends by chance once the guide has learnt",
            [](GuidedParams& p, uint32_t) { p.roulette = core::GuidedRoulette::none; }, false,
            Family::papers},

    Variant{"memory-reset", "trees learn from the last records alone",
            trainedWith<GuideMemory::reset>, false, Family::training},
    Variant{"memory-keep", "trees keep all sums", trainedWith<GuideMemory::keep>, false,
            Family::training},
    Variant{"memory-balance",
            "trees learn from the iteration before, too, by the balance heuristic",
            trainedWith<GuideMemory::balance>, false, Family::training},
    Variant{"memory-residual", "the same, and directions are drawn from what those records lack",
            trainedWith<GuideMemory::residual>, false, Family::training},

    Variant{"combine-samples", "iterations by their samples", combined<Combine::samples, kPicture>,
            false, Family::combinations},
    Variant{"combine-last", "the last iteration alone",
            combined<Combine::samples, kPicture, CombineFrom::own, 1>, false, Family::combinations},
    Variant{"combine-variance", "1 / mean variance of the picture",
            combined<Combine::inverseVariance, kPicture>, false, Family::combinations},
    Variant{"combine-mean-inverse", "mean of 1 / variance of the picture",
            combined<Combine::meanInverseVariance, kPicture>, false, Family::combinations},
    Variant{"combine-pixel-variance", "1 / variance of each pixel",
            combined<Combine::inverseVariance, CombineOver::pixel>, false, Family::combinations},
    Variant{"combine-ess", "mean ESS of the picture", combined<Combine::ess, kPicture>, false,
            Family::combinations},
    Variant{"combine-tile-ess", "mean ESS of tiles of 8x8 pixels",
            combined<Combine::ess, CombineOver::tile>, false, Family::combinations},
    Variant{"combine-pixel-ess", "ESS of each pixel", combined<Combine::ess, CombineOver::pixel>,
            false, Family::combinations},
    Variant{"combine-crossed-variance", "1 / variance of each pixel, of the other half",
            combined<Combine::inverseVariance, CombineOver::pixel, CombineFrom::crossed>, false,
            Family::combinations},
    Variant{"combine-crossed-ess", "ESS of each pixel, of the other half",
            combined<Combine::ess, CombineOver::pixel, CombineFrom::crossed>, false,
            Family::combinations},

    Variant{"depth-0", "one leaf", atDepth<0, GuideMemory::reset>, false, Family::depths},
    Variant{"depth-0-balance", "one leaf, old records", atDepth<0, GuideMemory::balance>, false,
            Family::depths},
    Variant{"depth-3", "3 cuts", atDepth<3, GuideMemory::reset>, false, Family::depths},
    Variant{"depth-3-balance", "3 cuts, old records", atDepth<3, GuideMemory::balance>, false,
            Family::depths},
    Variant{"depth-6", "6 cuts", atDepth<6, GuideMemory::reset>, false, Family::depths},
    Variant{"depth-6-balance", "6 cuts, old records", atDepth<6, GuideMemory::balance>, false,
            Family::depths},
    Variant{"depth-9", "9 cuts", atDepth<9, GuideMemory::reset>, false, Family::depths},
    Variant{"depth-9-balance", "9 cuts, old records", atDepth<9, GuideMemory::balance>, false,
            Family::depths},
    Variant{"depth-12", "12 cuts", atDepth<12, GuideMemory::reset>, false, Family::depths},
    Variant{"depth-12-balance", "12 cuts, old records", atDepth<12, GuideMemory::balance>, false,
            Family::depths},
    Variant{"depth-15", "15 cuts", atDepth<15, GuideMemory::reset>, false, Family::depths},
    Variant{"depth-15-balance", "15 cuts, old records", atDepth<15, GuideMemory::balance>, false,
            Family::depths},
};

}  // namespace

std::span<const Variant> variantTable()
{
    return kVariants;
}

const Variant& variantNamed(std::string_view name)
{
    const auto found = std::ranges::find(kVariants, name, &Variant::name);
    CHECK(found != kVariants.end());
    return *found;
}

std::string_view familyName(Family family)
{
    constexpr std::array<std::string_view, 5> kNames{"switches", "papers", "training",
                                                     "combinations", "depths"};
    return kNames[size_t(family)];
}

std::vector<const Variant*> variantsOf(const GuidingBenchOptions& options)
{
    const auto named = [&](std::string_view name) {
        return std::ranges::find(options.variants, name) != options.variants.end();
    };
    std::vector<const Variant*> chosen;
    for (const Variant& v : kVariants) {
        const bool usual = v.isMain || (!options.quick && v.family == Family::switches);
        const bool asked =
            options.variants.empty() ? usual : named(v.name) || named(familyName(v.family));
        if (asked || v.change == nullptr) chosen.push_back(&v);
    }
    return chosen;
}

core::AnyParams paramsOf(const Variant& variant, const GuidedParams& common, uint32_t seed,
                         uint32_t spp)
{
    GuidedParams guided = common;
    guided.seed = seed;
    if (variant.change != nullptr) {
        variant.change(guided, spp);
        return guided;
    }
    core::PathParams path;
    path.maxDepth = guided.maxDepth;
    path.rouletteDepth = guided.rouletteDepth;
    path.seed = guided.seed;
    path.sampler = guided.sampler;
    path.kernel = guided.kernel;
    path.sky = guided.sky;
    return path;
}

void requireVariants(const std::vector<std::string>& names)
{
    std::vector<std::string> known;
    std::string all;
    for (const Family family : kFamilies) {
        known.emplace_back(familyName(family));
        all += (all.empty() ? "" : ", ") + known.back();
    }
    for (const Variant& v : kVariants) {
        known.emplace_back(v.name);
        all += ", " + known.back();
    }
    for (const std::string& name : names)
        if (std::ranges::find(known, name) == known.end())
            throw core::Error("--variants: '" + name + "' is not one of " + all +
                                  suggestion(name, known),
                              core::ExitCode::commandLine);
}

}  // namespace app::guiding
