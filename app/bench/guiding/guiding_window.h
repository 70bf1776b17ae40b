// What a guide brings to the first sample of a view in the window's own loop (window_loop.h): the
// camera rests, orbits and rests again, as by hand.
#pragma once

#include <optional>

#include "app/bench/window/window_loop.h"
#include "core/image/image.h"

namespace app::guiding {

class WindowArrivals {
public:
    /// Loads the scene, for pictures of `size`. `track`: from where the camera rests first to where
    /// it comes to rest. Throws core::Error.
    WindowArrivals(const SceneOptions& scene, const Target& target, const core::AnyParams& params,
                   glm::uvec2 size, CameraTrack track, std::stop_token stop);

    /// The first sample of the track's last view, after at least `before` of its first. Nothing
    /// when a stop came first. Throws core::Error.
    std::optional<core::Image> arrive(const core::AnyParams& params, uint32_t before);

private:
    WindowLoop loop_;
    CameraTrack track_;
};

}  // namespace app::guiding
