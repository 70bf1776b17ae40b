// What the render command says while it works and when it ends.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "app/commands/render_loop.h"
#include "app/files/stats.h"

namespace app {

/// How far a frame is and how long it will take. Of `goal` what is unlimited is left out; of
/// `report` the size and the frames that are done are read.
std::string progressText(const RenderReport& report, const Goal& goal, uint64_t samples,
                         double seconds, std::optional<double> rmse);

/// The report's newest frame, as it was saved.
std::string savedText(const RenderReport& report, const std::filesystem::path& file);

/// Empty where no frame took more than it was allowed.
std::string overBudgetText(const RenderReport& report);

/// What is left when rendering was interrupted.
std::string interruptedText(const RenderReport& report);

}  // namespace app
