// Loading with progress and warnings. See load.h.
#include "app/files/load.h"

#include <algorithm>

#include "app/files/scene_path.h"
#include "core/base/check.h"
#include "core/base/memory.h"
#include "core/base/time.h"
#include "core/gltf/gltf.h"

namespace app {

std::filesystem::path defaultScene()
{
    namespace fs = std::filesystem;
    const fs::path name = fs::path("assets") / "cornell-diffuse.gltf";
    std::error_code error;
    const fs::path program = fs::read_symlink("/proc/self/exe", error);
    if (error) return name;
    const fs::path folder = program.parent_path(), above = folder.parent_path();
    for (const fs::path& root : {above / "share" / "rekindle", above, folder})
        if (fs::exists(root / name, error)) return root / name;
    return name;
}

std::vector<std::string> warningLines(const core::Warnings& warnings)
{
    std::vector<std::string> lines;
    for (const core::Warnings::Count& count : warnings.counts) {
        uint64_t told = 0;
        for (const core::Warning& warning : warnings.listed) {
            if (warning.code != count.code) continue;
            ++told;
            const std::string place = warning.pointer.empty() ? "" : warning.pointer + ": ";
            lines.push_back(place + warning.message + " (" + warning.code + ')');
        }
        if (count.count > told)
            lines.push_back(std::to_string(count.count - told) + " more of " + count.code);
    }
    return lines;
}

void refuseWarnings(const core::Warnings& warnings, const SceneOptions& options,
                    const std::filesystem::path& file, const std::string& when)
{
    if (options.load.strict && warnings.total() > 0)
        throw core::Error(file.string() + ": " + when + warningLines(warnings).front() +
                          " — refused because of --strict");
}

LoadedWorld loadWorld(const SceneOptions& options, uint32_t forcedFeatures,
                      const core::Progress& progress, std::stop_token stop)
{
    const core::Clock::time_point start = core::Clock::now();
    LoadedWorld loaded;
    loaded.file = scenePath(options.file);
    {
        // The scene's own copies of meshes and texels are freed at the end of this block.
        const std::shared_ptr<const core::Scene> scene =
            core::loadGltf(loaded.file, options.load, progress, stop);
        core::giveBackMemory();  // what the document took
        if (progress) progress("placing meshes", core::kUnknownShare);
        loaded.world = core::makeWorld(scene, options.laidOutAt.value_or(options.at),
                                       forcedFeatures, {}, options.load.instancing);
        if (options.laidOutAt) loaded.world = core::poseWorld(loaded.world, options.at);
        if (stop.stop_requested())
            throw core::Error(loaded.file.string() + ": loading was cancelled",
                              core::ExitCode::interrupted);
    }
    const std::optional<core::Environment>& around = loaded.world->scene->environment;
    const bool unasked = options.load.environment == core::kAnyEnvironment;
    if (unasked && around && around->file == core::kPlainSky)
        loaded.note = "nothing shines in this scene: a plain sky lights it (--environment none: "
                      "nothing does)";
    loaded.seconds = core::secondsSince(start);
    refuseWarnings(loaded.world->warnings, options, loaded.file);
    return loaded;
}

}  // namespace app
