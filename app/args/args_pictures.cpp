// What the command lines of measurements of whole pictures have in common. See args_options.h.
#include <string>
#include <utility>
#include <vector>

#include "app/args/args_options.h"

namespace app {

static std::vector<uint32_t> readSamples(const std::string& text)
{
    return readNumbers<uint32_t>("--samples", text, {1, 100000}, "a whole number from 1 to 100000");
}

void addPictureOptions(CLI::App& app, PictureBenchOptions& o, PictureArguments& given,
                       const PictureHelp& help)
{
    addSceneFiles(app, given.files);
    const std::string output = "Output";
    addValue(app, output, "-o,--output", o.output, help.output)->type_name("DIR");
    app.add_flag("-q,--quiet", o.quiet, "no progress on stderr")->group(output);
    const std::string measurement = "Measurement";
    app.add_flag("--quick", o.quick, help.quick)->group(measurement);
    addRead(app, measurement, "--samples", "LIST", o.samples, readSamples, help.samples);
    addRead(app, measurement, "--size", "WxH", o.size, readSize,
            "width and height in pixels (default: 256x256 where the camera's picture is square, "
            "else as many pixels as 192x108)");
    addValue(app, measurement, "--camera", o.camera,
             "name or index of a camera of the scene, or a JSON file (default: the first)");
    const std::string device = "Device";
    addValue(app, device, "--device", o.devices,
             "the CPU, Vulkan compute, or both where there is a Vulkan device");
    addValue(app, device, "--device-index", o.deviceIndex,
             "Vulkan device as rekindle devices lists it; -1 chooses", {-1, 1024});
    addLoadingOptions(app, given.loading);
}

void finishPictures(const std::string& command, const PictureArguments& given,
                    std::vector<uint32_t> usual, PictureBenchOptions& o)
{
    o.scenes = measuredScenes(command, given.loading, given.files, o.output);
    if (o.deviceIndex >= 0 && o.devices == MeasuredDevices::cpu)
        badCommandLine("--device-index is for --device vulkan");
    if (o.samples.empty()) o.samples = std::move(usual);
}

}  // namespace app
