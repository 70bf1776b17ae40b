#include "app/bench/bench_scenes.h"

#include <algorithm>
#include <cmath>

#include "app/files/load.h"
#include "app/files/scene_path.h"

namespace app {

void requireFiles(std::span<const SceneOptions> scenes)
{
    for (const SceneOptions& scene : scenes) (void)scenePath(scene.file);
}

std::string sceneName(const std::filesystem::path& file, const std::vector<std::string>& taken)
{
    // A folder's name may end in a slash, which leaves no last part.
    const std::string stem = (file.has_filename() ? file : file.parent_path()).stem().string();
    std::string name = stem;
    for (int i = 2; std::ranges::find(taken, name) != taken.end(); ++i)
        name = stem + "-" + std::to_string(i);
    return name;
}

std::shared_ptr<const core::World> loadBenchScene(const SceneOptions& options,
                                                  const BenchTools& tools)
{
    const LoadedWorld loaded = loadWorld(options, 0, tools.loading, tools.stop);
    for (const std::string& line : warningLines(loaded.world->warnings))
        tools.warn(options.file.string() + ": " + line);
    if (!loaded.note.empty()) tools.warn(options.file.string() + ": " + loaded.note);
    return loaded.world;
}

glm::uvec2 usualSize(const core::Camera& camera)
{
    const glm::uvec2 shape = core::sizeForWidth(camera, 1000);
    const double aspect = double(shape.x) / shape.y;
    const double pixels = std::abs(aspect - 1) < 0.1 ? 256 * 256 : 192 * 108;
    return core::sizeForWidth(camera, uint32_t(std::lround(std::sqrt(pixels * aspect))));
}

std::filesystem::path referenceFile(const std::filesystem::path& folder, const std::string& scene,
                                    glm::uvec2 size, const std::string& rest)
{
    return folder / "references" / (scene + '-' + sizeText(size) + '-' + rest + ".exr");
}

std::string sizeText(glm::uvec2 size)
{
    return std::to_string(size.x) + 'x' + std::to_string(size.y);
}

}  // namespace app
