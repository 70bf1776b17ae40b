// What `bench light` measures: one table of ways to find light.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/args/args.h"
#include "core/scene/world.h"

namespace app::light {

struct Strategy {
    const char* name;
    const char* help;  // what it is, one sentence
    /// Its parameters, from what all have in common.
    core::AnyParams (*params)(const core::PathParams& common);
    enum class Choice { ofScene, power, tree } choice = Choice::ofScene;  // of emitters
    bool isMain = false;  // measured unless others are asked for
};

/// All of them; the first is `power`, which the others are compared with.
std::span<const Strategy> strategyTable();

/// The scene with its emitters chosen so.
std::shared_ptr<const core::World> worldOf(const Strategy& strategy,
                                           const std::shared_ptr<const core::World>& world);

/// Those that are measured in a scene, in the table's order: those that are named, else the main
/// ones, in a quick run power and tree. `power` is always among them; `tree` where there is one,
/// whether it pays or not.
std::vector<const Strategy*> strategiesOf(const LightBenchOptions& options,
                                          const core::World& world);

/// Throws core::Error (command line) for a name that no strategy has.
void requireStrategies(const std::vector<std::string>& names);

}  // namespace app::light
