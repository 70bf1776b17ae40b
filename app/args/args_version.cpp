// Versions of the program and of the libraries that it was built with: the only file that sees all
// their headers.
#include <CLI/Version.hpp>
#include <embree3/rtcore_config.h>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <OpenImageIO/oiioversion.h>
#include <tbb/version.h>
#include <vulkan/vulkan_core.h>

#include "app/args/args.h"
#include "app/base/program_version.h"
#include "version.h"

namespace app {

const char* const kVersion = REKINDLE_VERSION;
const char* const kCommit = REKINDLE_COMMIT;

static std::string dotted(int a, int b, int c)
{
    return std::to_string(a) + '.' + std::to_string(b) + '.' + std::to_string(c);
}

std::string versionText()
{
    const uint32_t vulkan = VK_HEADER_VERSION_COMPLETE;
    std::string text =
        std::string("rekindle ") + kVersion + " (" + (*kCommit ? kCommit : "no commit") + ")\n";
    const auto library = [&text](const char* name, const std::string& version) {
        text += std::string("  ") + name + ' ' + version + '\n';
    };
    library("Embree", RTC_VERSION_STRING);
    library("Vulkan headers", dotted(static_cast<int>(VK_API_VERSION_MAJOR(vulkan)),
                                     static_cast<int>(VK_API_VERSION_MINOR(vulkan)),
                                     static_cast<int>(VK_API_VERSION_PATCH(vulkan))));
    library("oneTBB", TBB_VERSION_STRING);
    library("OpenImageIO", OIIO_VERSION_STRING);
    library("GLM", dotted(GLM_VERSION_MAJOR, GLM_VERSION_MINOR, GLM_VERSION_PATCH));
    library("CLI11", CLI11_VERSION);
    library("JSON for Modern C++", dotted(NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR,
                                          NLOHMANN_JSON_VERSION_PATCH));
    library("compiler", __VERSION__);
    return text;
}

}  // namespace app
