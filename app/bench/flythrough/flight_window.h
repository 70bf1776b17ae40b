// Flights in the window's own loop (window_loop.h): a camera that moves by the clock, pictures as
// small as the wanted rate demands.
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <stop_token>

#include "app/bench/window/window_loop.h"

namespace app::flight {

/// What a flight has left on show, and what was seen on the way.
struct WindowLanding {
    core::Image picture;              // of the flight's last view, stretched over the window
    core::Image colours;              // the same as the window shows it (displayColours)
    core::Image underWay;             // what it showed when the flight ended, of a view before
    glm::uvec2 size{0}, fineSize{0};  // in which its light was sampled, its surfaces
    std::shared_ptr<const core::Image> guide;  // to pictures of fineSize; may be null
    // Of the sides of light and surfaces to the window's, means of the flight
    double scale = 1, fineScale = 1;
    uint32_t pictures = 0;  // that were shown on the way
    double seconds = 0;     // of the slowed clock, from the first key to the last
    double share = 1;       // seconds of that clock in a second

    /// From picture to picture, mean of the flight; its length where none was shown on the way.
    double pictureSeconds() const { return seconds / std::max(pictures, 1u); }
};

class WindowPilot {
public:
    /// Loads the scene, for pictures of `size`. Throws core::Error.
    WindowPilot(const SceneOptions& scene, const Target& target, glm::uvec2 size,
                std::stop_token stop);

    /// Plays `track` once, from the first key to the last, while `frameSeconds` are wanted from
    /// picture to picture. Lands with the first picture of the last key's camera, which is that of
    /// a camera that still moves. Nothing when a stop came first. Throws core::Error.
    std::optional<WindowLanding> fly(const CameraTrack& track, const core::ReuseParams& params,
                                     double frameSeconds);

private:
    bool land(WindowLanding& landing);

    glm::uvec2 size_;
    WindowLoop loop_;
};

/// What a window of that size shows of a picture: encoded colours from 0 to 1, at exposure 0 and
/// with the tone curve that the viewer begins with. With a `guide` (surfaceGuide) it is smooth
/// within surfaces, as pictures of a moving camera are.
core::Image displayColours(const core::Image& picture, const core::Image* guide, glm::uvec2 size);

}  // namespace app::flight
