// See missed_light.h.
#include "core/methods/missed_light.h"

#include "core/methods/reuse_params.h"
#include "core/scene/world.h"

namespace core {

std::string missedLight(std::string_view method, const World& world)
{
    constexpr uint32_t kLampsBehindGlass = shared::kFeaturePanes | shared::kFeaturePunctualLights;
    // Connections that are kept from place to place end at panes (reuse_settings.h); what they miss
    // is found by paths that meet its source, which these lights do not have.
    if (method != ReuseParams::kMethod || (world.features & kLampsBehindGlass) != kLampsBehindGlass)
        return {};
    return "--method reuse does not show light of point, spot and directional lights that comes "
           "through panes of glass; --method path does";
}

}  // namespace core
