// What `bench light` measures: one table of ways to find light.
#pragma once

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
    bool byPower = false;  // emitters are chosen by power even where there is a tree
    bool byTree = false;   // measured only where there is one
    bool isMain = false;   // unless others are asked for
};

/// All of them; the first is `power`, which the others are compared with.
std::span<const Strategy> strategyTable();

/// Those that are measured in a scene, in the table's order: those that are named, else the main
/// ones, in a quick run power and tree. `power` is always among them.
std::vector<const Strategy*> strategiesOf(const LightBenchOptions& options,
                                          const core::World& world);

/// Throws core::Error (command line) for a name that no strategy has.
void requireStrategies(const std::vector<std::string>& names);

}  // namespace app::light
