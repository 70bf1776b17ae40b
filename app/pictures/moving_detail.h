// How much finer than its light the surfaces of a small picture are. A first hit takes a twentieth
// of the time of a path, and most of what a small picture lacks are edges and textures.
#pragma once

#include "app/pictures/picture.h"

namespace app {

class MovingDetail {
public:
    /// Whether small pictures of a request get it: those that show light on surfaces, unless paths
    /// are to be seen as they come, or begin all over a lens, where first hits are of its centre.
    static bool wanted(const RenderRequest& request);

    /// The largest size, in steps of half the pixels, whose surfaces take no more than a part of
    /// `seconds`; a quarter of the sides of `full` at least.
    glm::uvec2 affordable(glm::uvec2 full, double seconds) const;

    /// What surfaces of that size and the light on them take, by the last ones.
    double seconds(glm::uvec2 size) const { return secondsPerPixel_ * size.x * size.y; }

    /// Those of a picture have taken `seconds`.
    void observe(glm::uvec2 size, double seconds);

private:
    double secondsPerPixel_ = 1.2e-7;  // measured on two cores of 2020; then on these
};

}  // namespace app
