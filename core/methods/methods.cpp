#include "core/methods/methods.h"

#include <array>
#include <string>

#include "core/base/check.h"

namespace core {

std::span<const Method> methods()
{
    static constexpr std::array kMethods{
        Method{"path", "unidirectional path tracing with next-event estimation and MIS",
               makePathTracer},
    };
    return kMethods;
}

std::unique_ptr<Renderer> makeRenderer(std::string_view name)
{
    std::string known;
    for (const Method& method : methods()) {
        if (name == method.name) return method.make();
        known += (known.empty() ? "" : ", ") + std::string(method.name);
    }
    throw Error("--method: '" + std::string(name) + "' is unknown — use one of " + known,
                ExitCode::commandLine);
}

}  // namespace core
