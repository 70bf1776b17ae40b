// What exposure a picture asks for, as a camera's meter finds it.
#pragma once

#include <optional>

#include "core/image/image.h"

namespace app {

/// Stops that bring the middle of a picture of radiance to mid-grey (.18): the median luminance of
/// its parts, of which there are some thousands and which hide the noise of first samples. What is
/// black or no number does not count, and lamps do not as long as they fill less than half of it.
/// Within the display's 20 stops. Nothing where no part has light.
std::optional<float> meteredStops(const core::Image& picture);

}  // namespace app
