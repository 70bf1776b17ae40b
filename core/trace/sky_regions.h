// Makes the regions of shared/sky_regions.h: places that paths come to are found by walks from the
// scene's cameras and surfaces, rays towards the environment tell what is seen of it there, first
// of all of it, then where some was seen. A function of the world alone: neither threads nor the
// device nor earlier views change a bit. A pose has regions of its own.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <glm/glm.hpp>

#include "core/base/progress.h"
#include "core/trace/accel.h"

namespace core {

struct SkyRegions {
    std::vector<glm::uvec4> words;  // as shared/sky_regions.h says
    uint32_t count = 0;
    double seconds = 0;  // that it took to make them
};

/// Whether regions are made in any case, or only where places see so little of the environment that
/// they pay.
enum class SkyNeed { always, hidden };

/// The regions of the accelerated world; null where there is no environment, no place, or no need.
/// `progress` gets "looking for the sky" every few hundredths of a second; what it throws ends the
/// work and is passed on.
std::shared_ptr<const SkyRegions> makeSkyRegions(const Accel& accel, SkyNeed need,
                                                 const Progress& progress = {});

}  // namespace core
