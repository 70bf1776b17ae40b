// Rendering with many lights: the sums on the device, everything else on the CPU.
#include "app/gpu/methods/methods.h"
#include "app/gpu/slice_sums.h"

namespace gpu {

std::unique_ptr<core::Renderer> makeManyLights(const DeviceOptions& options)
{
    return core::makeManyLights(std::make_unique<SliceSums>(options));
}

}  // namespace gpu
