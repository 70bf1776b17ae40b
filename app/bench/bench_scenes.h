// What measurements over several scenes have in common.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "app/args/args.h"

namespace app {

/// Looks at every file before work begins. Throws core::Error naming the first that is not there.
void requireFiles(std::span<const SceneOptions> scenes);

/// The file's name without its ending, with a number behind it where `taken` has it already.
std::string sceneName(const std::filesystem::path& file, const std::vector<std::string>& taken);

}  // namespace app
