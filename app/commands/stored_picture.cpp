// See stored_picture.h.
#include "app/commands/stored_picture.h"

#include <string>

#include "app/files/picture_layers.h"
#include "core/image/metrics.h"
#include "core/methods/method.h"

namespace app {

std::optional<StoredNoise> storedNoise(const core::ImageFile& content)
{
    const std::optional<core::Image> variance = rgbVarianceOf(content);
    if (!variance) return {};
    return StoredNoise{core::noiseOf(*variance), usesSobol(content)};
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
