// See light_cases.h.
#include "app/bench/light/light_cases.h"

#include <algorithm>
#include <array>

#include "app/base/nearest.h"
#include "core/base/check.h"
#include "core/scene/emitter_choice.h"

namespace app::light {

namespace {

template <core::Strategy strategy> core::AnyParams pathBy(const core::PathParams& common)
{
    core::PathParams params = common;
    params.strategy = strategy;
    return params;
}

core::AnyParams guided(const core::PathParams& common)
{
    core::GuidedParams params;
    params.maxDepth = common.maxDepth;
    params.rouletteDepth = common.rouletteDepth;
    params.seed = common.seed;
    params.sampler = common.sampler;
    params.kernel = common.kernel;
    params.sky = common.sky;
    return params;
}

constexpr std::array kStrategies{
    Strategy{"power",
             "path tracing, both ways weighted (MIS); one emitter of all is chosen by its power",
             pathBy<core::Strategy::mis>, Strategy::Choice::power, true},
    Strategy{"tree",
             "the same, but that lamps are chosen by the tree of emitters for the place, whether "
             "the scene thinks that this pays or not; only where there are lamps enough for one",
             pathBy<core::Strategy::mis>, Strategy::Choice::tree, true},
    Strategy{"guided", "guided paths; emitters chosen as the scene has it", guided,
             Strategy::Choice::ofScene, true},
    Strategy{"bsdf", "light is met by following surfaces alone, without connections to emitters",
             pathBy<core::Strategy::bsdf>},
    Strategy{"light", "connections to emitters alone, chosen as the scene has it",
             pathBy<core::Strategy::light>},
};

}  // namespace

std::span<const Strategy> strategyTable()
{
    return kStrategies;
}

std::shared_ptr<const core::World> worldOf(const Strategy& strategy,
                                           const std::shared_ptr<const core::World>& world)
{
    switch (strategy.choice) {
    case Strategy::Choice::power:
        return core::chosenByPower(world);
    case Strategy::Choice::tree:
        return core::chosenByPlace(world);
    case Strategy::Choice::ofScene:
        break;
    }
    return world;
}

std::vector<const Strategy*> strategiesOf(const LightBenchOptions& options,
                                          const core::World& world)
{
    std::vector<const Strategy*> chosen;
    for (const Strategy& s : kStrategies) {
        const bool byTree = s.choice == Strategy::Choice::tree;
        const bool usual = byTree || (s.isMain && !options.quick);
        const bool asked = options.strategies.empty()
                               ? usual
                               : std::ranges::find(options.strategies, std::string_view(s.name)) !=
                                     options.strategies.end();
        if (&s == kStrategies.data() || (asked && (!byTree || !world.emitterTree.empty())))
            chosen.push_back(&s);
    }
    return chosen;
}

void requireStrategies(const std::vector<std::string>& names)
{
    std::vector<std::string> known;
    std::string all;
    for (const Strategy& s : kStrategies) {
        known.emplace_back(s.name);
        all += (all.empty() ? "" : ", ") + known.back();
    }
    for (const std::string& name : names)
        if (std::ranges::find(known, name) == known.end())
            throw core::Error("--strategies: '" + name + "' is not one of " + all +
                                  suggestion(name, known),
                              core::ExitCode::commandLine);
}

}  // namespace app::light
