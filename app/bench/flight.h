// The way of a camera whose samples are to be kept. All flights of a scene end in the same view,
// whatever their length and step: one reference serves them all, and what differs between them is
// history and nothing else.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "app/files/camera_file.h"
#include "core/scene/camera.h"
#include "core/scene/world.h"

namespace app::flight {

class Flight {
public:
    /// Around what the middle of the picture of `end` shows: the eye goes along a circle that ends
    /// at `end` and around which it sees the target from directions up to 20 degrees apart, or more
    /// where a step of `widest` degrees needs it, or less where something stands in the way.
    static Flight around(const std::shared_ptr<const core::World>& world, const core::Camera& end,
                         glm::uvec2 size, double widest);

    /// Along a path, to its last key.
    static Flight along(CameraPath path);

    /// The view that all flights end in.
    core::Camera end() const { return before(1, 0); }

    /// The view so many frames before. A step is in degrees between two views as seen from the
    /// target, or in frames of the path.
    core::Camera before(double step, uint32_t frames) const;

    /// Metres from one view to the next.
    double distance(double step) const;

    /// Why there is no flight of `frames` frames with such steps; nothing when there is one.
    std::string whyNot(double step, uint32_t frames) const;

    /// "degrees", or "frames of the path".
    const char* unit() const { return path_ ? "frames of the path" : "degrees"; }

    /// The way in a sentence.
    std::string words() const;

private:
    Flight() = default;
    glm::dvec3 placeAt(double azimuth) const;

    std::optional<CameraPath> path_;
    core::Camera last_;
    glm::dvec3 target_{0}, axis_{0, 1, 0};
    double opening_ = 0;  // half of the cone's, radians
    double reach_ = 0;    // from the target to the eye, metres
};

}  // namespace app::flight
