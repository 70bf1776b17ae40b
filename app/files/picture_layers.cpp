// See picture_layers.h.
#include "app/files/picture_layers.h"

#include <string>

#include "core/base/check.h"

namespace app {

namespace {

core::Image firstThree(const core::Image& image)
{
    if (image.channels == 3) return image;
    core::Image rgb(image.width, image.height, 3);
    for (size_t i = 0; i < rgb.pixels.size(); ++i)
        rgb.pixels[i] = image.pixels[i / 3 * image.channels + (image.channels > 3 ? i % 3 : 0)];
    return rgb;
}

}  // namespace

core::Image rgbOf(const core::ImageFile& content, const std::filesystem::path& file)
{
    if (content.hasLayer("")) return firstThree(content.layer(""));
    std::string names;
    for (const core::Layer& layer : content.layers)
        names += (names.empty() ? "" : ", ") + layer.name;
    throw core::Error(file.string() +
                      ": has no channels R, G, B outside of layers — it has the layers " + names);
}

std::optional<core::Image> rgbVarianceOf(const core::ImageFile& content)
{
    if (!content.hasLayer("variance") || content.layer("variance").channels < 3) return {};
    return firstThree(content.layer("variance"));
}

}  // namespace app
