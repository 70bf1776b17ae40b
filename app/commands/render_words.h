// What the render command says while it works and when it ends.
#pragma once

#include <filesystem>
#include <string>

#include "app/commands/render_loop.h"
#include "app/files/stats.h"

namespace app {

/// A number as printf's `pattern` writes it.
std::string printedNumber(const char* pattern, double value);

/// How far a frame is and how long it will take. Of `goal` what is unlimited is left out; of
/// `report` the size and the frames that are done are read.
std::string progressText(const RenderReport& report, const Goal& goal, const Outcome& soFar);

/// The report's newest frame, as it was saved.
std::string savedText(const RenderReport& report, const std::filesystem::path& file);

/// Empty where no frame took more than it was allowed.
std::string overBudgetText(const RenderReport& report);

/// Which target was missed, and by how much; the report's newest frame tells.
std::string missedText(const RenderReport& report);

/// What is left when rendering was interrupted.
std::string interruptedText(const RenderReport& report);

}  // namespace app
