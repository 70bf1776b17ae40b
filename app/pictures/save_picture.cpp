// A picture of the window as a file. See save_picture.h.
#include "app/pictures/save_picture.h"

#include <algorithm>

#include "app/files/picture_file.h"
#include "app/files/stats.h"
#include "core/base/check.h"
#include "core/methods/method.h"

namespace app {

namespace {

/// Why no more samples were taken, in the words of `render`.
const char* ended(const Picture& p)
{
    if (!p.finished) return "interrupted";
    if (p.params.sppLimit > 0 && p.samples >= p.params.sppLimit) return "spp";
    if (p.params.secondsLimit > 0 && p.seconds >= p.params.secondsLimit) return "time";
    return "target";
}

PictureFacts factsOf(const Picture& p, const ShownScene& scene)
{
    return {.scene = scene,
            .camera = p.camera,
            .size = {p.mean.width, p.mean.height},
            .params = p.params.method,
            .samples = p.samples,
            .seconds = p.seconds,
            .device = p.stats.device,
            .driver = p.stats.driver,
            .ended = ended(p),
            .follows = p.follows};
}

/// Adds a layer that there is and that fits: first hits may lag behind a resize.
void addLayer(core::ImageFile& exr, const std::string& name, const core::Image& image)
{
    const core::Image& mean = exr.layers.front().image;
    if (image.width == mean.width && image.height == mean.height && !image.pixels.empty())
        exr.layers.push_back({name, image});
}

}  // namespace

core::Metadata viewMetadata(const Picture& picture, const ShownScene& scene)
{
    PictureFacts facts = factsOf(picture, scene);
    facts.size = picture.fullSize;
    if (picture.preview) {
        facts.samples = 0;
        facts.seconds = 0;
    }
    return imageMetadata(facts);
}

void savePicture(const std::filesystem::path& file, const Picture& picture, const ShownScene& scene,
                 const ViewParams& view)
{
    core::requireWritable(file);
    if (picture.preview)
        throw core::Error(
            file.string() +
            ": not saved: the picture is a preview of few pixels — save it again when "
            "the camera is at rest and each pixel has a sample");
    if (picture.samples == 0 || picture.mean.pixels.empty())
        throw core::Error(file.string() + ": not saved: there is no picture yet");
    const core::Metadata metadata = imageMetadata(factsOf(picture, scene));
    if (!hasExtension(file, ".exr")) {
        core::writePng(file, picture.mean, view.exposure, static_cast<uint32_t>(view.tone),
                       metadata);
        return;
    }
    core::ImageFile exr{{{"", picture.mean}}, metadata};
    // One sample says nothing about its spread.
    if (picture.variance && picture.samples >= 2) addLayer(exr, "variance", *picture.variance);
    if (picture.aovs) {
        addLayer(exr, "depth", inMetres(picture.aovs->depth, *scene.world));
        addLayer(exr, "normal", picture.aovs->normal);
        addLayer(exr, "albedo", picture.aovs->albedo);
        addLayer(exr, "ids", picture.aovs->ids);
    }
    if (picture.maps) {
        const auto infos = core::methodNamed(picture.params.method.id()).maps;
        for (size_t i = 0; i < std::min(picture.maps->size(), infos.size()); ++i)
            addLayer(exr, std::string("map.") + infos[i].name, (*picture.maps)[i]);
    }
    core::writeExr(file, exr);
}

}  // namespace app
