// What is read from and written to files by name: pictures, camera paths, their frames. See
// file_actions.h.
#include "app/session/file_actions.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/base/files.h"
#include "app/base/new_name.h"
#include "app/session/action_arguments.h"

namespace app {

namespace fs = std::filesystem;

namespace {

/// Whether a file may be written: one that is there is replaced where "replace" says so.
bool mayWrite(const ActionContext& c, const fs::path& file, bool otherwise)
{
    std::error_code unknown;
    if (!fs::exists(file, unknown) || truth(c, "replace", otherwise)) return true;
    c.app.wouldReplace = true;
    c.session.notices.tell(Severity::warning,
                           file.string() + " is there already: the same once more replaces it");
    return false;
}

/// The first of the path's frames that is there already, or the first of all. There may be a
/// thousand million of them, hence not each is looked for.
fs::path firstTaken(const CameraTrack& track, const fs::path& pattern)
{
    if (!isNumbered(pattern)) return pattern;  // exportTrack() says so
    const auto first = static_cast<uint32_t>(track.firstFrame()),
               last = static_cast<uint32_t>(track.lastFrame());
    const fs::path folder = pattern.has_parent_path() ? pattern.parent_path() : fs::path(".");
    std::optional<uint32_t> taken;
    std::error_code unknown;
    fs::directory_iterator entry(folder, unknown);
    for (; entry != fs::directory_iterator(); entry.increment(unknown)) {
        const auto frame = numberIn(pattern, entry->path().filename().string());
        if (frame && *frame >= first && *frame <= last && *frame < taken.value_or(UINT32_MAX))
            taken = frame;
    }
    return numbered(pattern, taken.value_or(first));
}

}  // namespace

void saveAction(const ActionContext& c)
{
    const fs::path file = fileName(c, "file", newName(".exr").string());
    if (mayWrite(c, file, true)) c.session.save(file);
}

void exportPathAction(const ActionContext& c)
{
    const fs::path pattern =
        c.arguments.contains("file") ? fs::path(fileName(c, "file")) : newPattern(kFramePattern);
    const uint32_t samples = std::max(count(c, "spp", 64), 1u);
    if (mayWrite(c, firstTaken(c.session.track, pattern), true))
        c.session.exportTrack(pattern, samples);
}

void savePathAction(const ActionContext& c)
{
    if (!c.session.document()) return;
    try {
        const fs::path file = fileName(c, "file");
        if (file.extension() != ".json")
            throw core::Error(file.string() + ": the name of a camera path ends in .json");
        if (file == c.session.track.file() || mayWrite(c, file, false)) c.session.savePath(file);
    } catch (const core::Error& error) {
        if (error.code() == core::ExitCode::commandLine) throw;
        c.session.notices.tell(Severity::error, error.what());
    }
}

void loadPathAction(const ActionContext& c)
{
    if (!c.session.document()) return;
    try {
        c.session.track.load(fileName(c, "file"), c.session.navigation.camera(),
                             c.session.document()->world->placement);
    } catch (const core::Error& error) {
        if (error.code() == core::ExitCode::commandLine) throw;
        c.session.notices.tell(Severity::error, error.what());
    }
}

void saveAndQuitAction(const ActionContext& c)
{
    std::vector<Loss> losses = lossesOf(c.session);
    const bool named = c.arguments.contains("file");
    const bool told = std::ranges::count(losses, Part::picture, &Loss::part) > 0;
    if (!told && (named || losses.empty())) losses.push_back({Part::picture, "the picture"});
    saveLosses(c.session, losses, named ? fileName(c, "file") : "");
    c.app.quitWhenSaved = true;
}

}  // namespace app
