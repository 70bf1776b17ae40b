#include "app/gpu/methods/methods.h"

#include <array>

#include "app/gpu/methods/path.h"

namespace gpu {

std::span<const Method> methods()
{
    static constexpr std::array kMethods{
        Method{"path", makePathRenderer},  Method{"ao", makeAmbientOcclusion},
        Method{"reuse", makeSampleReuse},  Method{"manylights", makeManyLights},
        Method{"guided", makeGuidedPaths},
    };
    return kMethods;
}

}  // namespace gpu
