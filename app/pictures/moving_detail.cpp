// See moving_detail.h.
#include "app/pictures/moving_detail.h"

#include <algorithm>
#include <cmath>

#include "core/methods/method.h"

namespace app {

namespace {

// Of the time of a picture. The error on show of sample reuse is .99 to 1.16 times as large with .2
// as with .5 (three rooms), and what is sharper is better to steer by.
constexpr double kShare = 0.45;
constexpr double kMostHalves = 4;  // of the pixels: a quarter of the sides

}  // namespace

bool MovingDetail::wanted(const RenderRequest& request)
{
    return request.movingDetail && request.movingShows == Moving::filled &&
           !request.camera.hasLens() &&
           core::methodNamed(request.params.method.id()).traits.radiance;
}

glm::uvec2 MovingDetail::affordable(glm::uvec2 full, double seconds) const
{
    const double most = kShare * seconds / secondsPerPixel_,
                 halves = std::clamp(std::ceil(std::log2(double(full.x) * full.y / most)), 0.0,
                                     kMostHalves);
    const glm::dvec2 size = glm::dvec2(full) * std::exp2(-0.5 * halves);
    return glm::max(glm::uvec2(glm::round(size)), glm::uvec2(1));
}

void MovingDetail::observe(glm::uvec2 size, double seconds)
{
    // Slow ones count at once, as in resolution_control.cpp.
    const double now = seconds / (double(size.x) * size.y);
    secondsPerPixel_ = std::max(now, 0.5 * (now + secondsPerPixel_));
}

}  // namespace app
