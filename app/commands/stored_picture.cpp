// See stored_picture.h.
#include "app/commands/stored_picture.h"

#include <string>

#include "core/base/check.h"
#include "core/image/metrics.h"
#include "core/methods/method.h"

namespace app {

core::Image storedColors(const core::ImageFile& content, const std::filesystem::path& file)
{
    if (!content.hasLayer("")) {
        std::string names;
        for (const core::Layer& layer : content.layers)
            names += (names.empty() ? "" : ", ") + layer.name;
        throw core::Error(file.string() +
                          ": has no channels R, G, B outside of layers — it has the layers " +
                          names);
    }
    const core::Image& picture = content.layer("");
    if (picture.channels >= 3) return picture;
    core::Image colors(picture.width, picture.height, 3);
    for (size_t i = 0; i < colors.pixels.size(); ++i)
        colors.pixels[i] = picture.pixels[i / 3 * picture.channels];
    return colors;
}

bool hasVariance(const core::ImageFile& content)
{
    return content.hasLayer("variance") && content.layer("variance").channels >= 3;
}

std::optional<StoredNoise> storedNoise(const core::ImageFile& content)
{
    if (!hasVariance(content)) return {};
    return StoredNoise{core::noiseOf(content.layer("variance")), usesSobol(content)};
}

bool usesSobol(const core::ImageFile& content)
{
    const auto params = content.metadata.find("params");
    return params != content.metadata.end() && params->second.find("sobol") != std::string::npos;
}

bool sharesLight(const core::ImageFile& content)
{
    const auto name = content.metadata.find("method");
    if (name == content.metadata.end()) return false;
    const core::MethodInfo* method = core::findMethod(name->second);
    return method != nullptr && method->traits.sharesLight;
}

}  // namespace app
