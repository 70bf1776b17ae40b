// See version.h. The only file that sees the headers of all libraries. "Built" is the version whose
// headers were compiled in, "running" that of the library in memory, for those that can tell.
#include "app/version/version.h"

#include <vector>

#include <CLI/Version.hpp>
#include <draco/core/draco_version.h>
#include <GLFW/glfw3.h>
#include <glm/glm.hpp>
#include <imgui.h>
#include <jconfig.h>
#include <meshoptimizer.h>
#include <nlohmann/json.hpp>
#include <OpenEXR/openexr_base.h>
#include <OpenEXR/OpenEXRConfig.h>
#include <png.h>
#include <rapidjson/rapidjson.h>
#include <tbb/version.h>

#include "app/base/program_version.h"
#include "app/gpu/base/api.h"
#include "app/version/system.h"
#include "core/trace/embree_rays.h"
#include "version_build.h"

namespace app {

const char* const kVersion = REKINDLE_VERSION;
const char* const kCommit = REKINDLE_COMMIT;

namespace {

struct Library {
    const char* name;
    std::string built, running;  // running is empty where the library cannot tell
};

std::string dotted(int a, int b, int c)
{
    return std::to_string(a) + '.' + std::to_string(b) + '.' + std::to_string(c);
}

std::string dotted(uint32_t vulkan)
{
    return dotted(static_cast<int>(VK_API_VERSION_MAJOR(vulkan)),
                  static_cast<int>(VK_API_VERSION_MINOR(vulkan)),
                  static_cast<int>(VK_API_VERSION_PATCH(vulkan)));
}

std::string exrLibraryRunning()
{
    int major = 0, minor = 0, patch = 0;
    const char* extra = nullptr;
    exr_get_library_version(&major, &minor, &patch, &extra);
    return dotted(major, minor, patch);
}

/// Its header gives the number without quotation marks: 2.1.5.
std::string jpegLibraryBuilt()
{
#ifdef LIBJPEG_TURBO_VERSION_NUMBER
    constexpr int kNumber = LIBJPEG_TURBO_VERSION_NUMBER;  // 2001005
    return dotted(kNumber / 1000000, kNumber / 1000 % 1000, kNumber % 1000);
#else
    return "not libjpeg-turbo, version " + std::to_string(JPEG_LIB_VERSION);
#endif
}

std::string vulkanLoader()
{
    uint32_t version = 0;
    const auto tell = reinterpret_cast<PFN_vkEnumerateInstanceVersion>(
        gpu::vk.GetInstanceProcAddr(nullptr, "vkEnumerateInstanceVersion"));
    return tell && tell(&version) == VK_SUCCESS ? dotted(version) : "";
}

std::vector<Library> libraries()
{
    const core::EmbreeVersion embree = core::embreeVersion();
    return {
        {"Vulkan", dotted(VK_HEADER_VERSION_COMPLETE), vulkanLoader()},
        {"Embree", embree.built, embree.running},
        {"oneTBB", TBB_VERSION_STRING, TBB_runtime_version()},
        {"OpenEXR", dotted(OPENEXR_VERSION_MAJOR, OPENEXR_VERSION_MINOR, OPENEXR_VERSION_PATCH),
         exrLibraryRunning()},
        {"libpng", PNG_LIBPNG_VER_STRING, png_get_libpng_ver(nullptr)},
        {"libjpeg-turbo", jpegLibraryBuilt(), ""},
        {"Draco", draco::kDracoVersion, ""},
        {"meshoptimizer",
         std::to_string(MESHOPTIMIZER_VERSION / 1000) + '.' +
             std::to_string(MESHOPTIMIZER_VERSION / 10 % 100),
         ""},
        {"GLFW", dotted(GLFW_VERSION_MAJOR, GLFW_VERSION_MINOR, GLFW_VERSION_REVISION),
         glfwGetVersionString()},
        {"Dear ImGui", IMGUI_VERSION, ImGui::GetVersion()},
        {"GLM", dotted(GLM_VERSION_MAJOR, GLM_VERSION_MINOR, GLM_VERSION_PATCH), ""},
        {"CLI11", CLI11_VERSION, ""},
        {"JSON for Modern C++",
         dotted(NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR,
                NLOHMANN_JSON_VERSION_PATCH),
         ""},
        {"RapidJSON", RAPIDJSON_VERSION_STRING, ""},
    };
}

std::string compiler()
{
#ifdef __clang__
    return "Clang " __clang_version__;
#else
    return "GCC " __VERSION__;
#endif
}

}  // namespace

std::string versionText()
{
    std::string text =
        std::string("rekindle ") + kVersion + " (" + (*kCommit ? kCommit : "no commit") + ")\n";
    const auto line = [&text](const std::string& name, const std::string& value) {
        if (!value.empty()) text += "  " + name + ": " + value + '\n';
    };
    line("compiler", compiler());
    line("build", std::string(REKINDLE_BUILD_TYPE) +
                      (REKINDLE_NATIVE ? ", for the processor it was built on (-march=native)"
                                       : ", for any processor of its architecture") +
                      (*REKINDLE_SANITIZE ? ", -fsanitize=" REKINDLE_SANITIZE : ""));
    for (const Library& library : libraries()) {
        const bool same = library.running.empty() || library.running == library.built;
        line(library.name, library.built + (same ? "" : ", running " + library.running));
    }
    const SystemInfo system = systemInfo();
    line("system", system.os + (system.os.empty() ? "" : ", ") + system.kernel);
    line("processor", system.processor + ", " + std::to_string(system.cores) + " cores");
    line("memory", std::to_string(system.memoryBytes >> 20) + " MiB");
    return text + "Vulkan devices and drivers: rekindle devices\n";
}

std::string versionJson()
{
    const SystemInfo system = systemInfo();
    nlohmann::ordered_json json{
        {"schema", 1},
        {"version", kVersion},
        {"commit", kCommit},
        {"compiler", compiler()},
        {"build_type", REKINDLE_BUILD_TYPE},
        {"native", bool(REKINDLE_NATIVE)},
        {"sanitizers", REKINDLE_SANITIZE},
        {"libraries", nlohmann::ordered_json::object()},
        {"system",
         {{"os", system.os},
          {"kernel", system.kernel},
          {"processor", system.processor},
          {"cores", system.cores},
          {"memory_mb", system.memoryBytes >> 20}}},
    };
    for (const Library& library : libraries())
        json["libraries"][library.name] = {{"built", library.built}, {"running", library.running}};
    return json.dump(2) + '\n';
}

}  // namespace app
