// What the render command says while it works and when it ends.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

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

/// Frames that have missed their target, and the one that is farthest from it.
struct MissedFrames {
    uint32_t count = 0;
    uint32_t worst = 0;                 // its number
    std::optional<double> rmse, noise;  // of that one

    /// The report's newest frame has missed its target.
    void add(const RenderReport& report);
};

/// Which target was missed, and by how much.
std::string missedText(const RenderReport& report, const MissedFrames& missed);

/// The warnings of all poses of a flight. Each is told once for a code and place, as numbers in its
/// text may change from pose to pose; of one code no more than ten places after the first pose.
class ToldWarnings {
public:
    /// Adds those of a pose; lines for what has not been told.
    std::vector<std::string> add(const core::Warnings& pose);

    /// How many there are. Places are known only of those that are spelled out: of the others, the
    /// most in one pose count.
    uint64_t total() const;

private:
    struct OfCode {
        std::set<std::string> places;
        uint64_t most = 0;
    };
    std::map<std::string, OfCode> codes_;
};

/// What is left when rendering was interrupted.
std::string interruptedText(const RenderReport& report);

}  // namespace app
