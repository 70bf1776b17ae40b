#include "app/bench/bench_scenes.h"

#include <algorithm>

#include "core/base/check.h"

namespace app {

void requireFiles(std::span<const SceneOptions> scenes)
{
    for (const SceneOptions& scene : scenes) {
        std::error_code none;
        if (!std::filesystem::exists(scene.file, none))
            throw core::Error(scene.file.string() + ": there is no such file");
    }
}

std::string sceneName(const std::filesystem::path& file, const std::vector<std::string>& taken)
{
    const std::string stem = file.stem().string();
    std::string name = stem;
    for (int i = 2; std::ranges::find(taken, name) != taken.end(); ++i)
        name = stem + "-" + std::to_string(i);
    return name;
}

}  // namespace app
