// Layers of an EXR, curve of a PNG. See picture_file.h.
#include "app/files/picture_file.h"

#include "core/base/machine_memory.h"

namespace app {

// Two sums of three doubles, mean and variance as floats, a copy while writing, and the device's
// compensated sums.
static constexpr double kBytesPerPixel = 48 + 24 + 24 + 48;

void writePicture(const std::filesystem::path& file, const core::Estimate& estimate,
                  core::Aovs* aovs, std::vector<core::Layer> maps, const RenderOptions& options,
                  const core::Metadata& metadata)
{
    if (!hasExtension(file, ".exr")) {
        core::writePng(file, estimate.mean, static_cast<float>(options.exposure),
                       static_cast<uint32_t>(options.tone), metadata);
        return;
    }
    core::ImageFile exr{{{"", estimate.mean}}, metadata};
    // One sample says nothing about its spread.
    if (estimate.samples >= 2 && !estimate.variance.pixels.empty())
        exr.layers.push_back({"variance", estimate.variance});
    if (aovs) {
        if (options.aovs.depth) exr.layers.push_back({"depth", std::move(aovs->depth)});
        if (options.aovs.normal) exr.layers.push_back({"normal", std::move(aovs->normal)});
        if (options.aovs.albedo) exr.layers.push_back({"albedo", std::move(aovs->albedo)});
        if (options.aovs.ids) exr.layers.push_back({"ids", std::move(aovs->ids)});
    }
    for (core::Layer& map : maps) exr.layers.push_back(std::move(map));
    core::writeExr(file, exr);
}

core::Image inMetres(core::Image depth, const core::World& world)
{
    const auto metres = static_cast<float>(1 / world.placement.scale);
    for (float& value : depth.pixels) value *= metres;
    return depth;
}

void requireMemoryFor(glm::uvec2 size)
{
    core::requireMemory(kBytesPerPixel * size.x * size.y,
                        "a picture of " + std::to_string(size.x) + "x" + std::to_string(size.y),
                        "ask for a smaller one");
}

}  // namespace app
