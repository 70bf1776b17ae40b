// What the pictures before have seen at their pixels, and where it is found in the next one: by
// nearness, 1 / distance along the axis of the camera. Within a plane it is linear on the film, and
// 0 where nothing is hit.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "core/methods/renderer.h"
#include "core/scene/camera.h"

namespace app {

/// What is known of a pixel.
struct SeenPlace {
    glm::vec4 light{0};  // radiance times weight, and weight: samples that it stands for
    float nearness = 0;
    uint32_t surface = 0;  // packSurface()
};

// Bilinear weight of pixels that show a place, from which on it was seen.
constexpr float kFewestSeen = 0.1f;

/// Normal and material of the surface in a pixel, for comparison alone.
uint32_t packSurface(const core::Aovs& aovs, size_t pixel);

/// Whether they may be of one surface.
bool oneSurface(uint32_t a, uint32_t b);

/// The pixels of a picture, as the film has them.
class FilmPoints {
public:
    FilmPoints(const core::Camera& camera, glm::uvec2 size);

    float nearness(const core::Aovs& aovs, size_t pixel) const;

private:
    size_t width_;
    glm::vec2 pixel_, half_, shift_;
};

/// Number `i` of an additive recurrence in [0, 1).
double additive(uint64_t i, double step);

/// Four pixels of before, around where a place was.
struct Look {
    float weight = 0;                  // bilinear, of those that show it
    glm::vec4 light{0};                // that they have, on average
    bool picked = false;               // whether the one that chance picks of the four shows it
    const SeenPlace* other = nullptr;  // of the rest, the one that counts most and is not beyond
};

class SeenBefore {
public:
    /// `places` of `size`, which the camera `then` has seen, for the picture number `count` of a
    /// flight, which the camera `now` sees. Refers to the places.
    SeenBefore(const std::vector<SeenPlace>& places, glm::uvec2 size, const core::Camera& then,
               const core::Camera& now, uint64_t count);

    bool empty() const { return places_.empty(); }

    /// What lookUp() takes for a point of the film of now, from -1 to 1 on it, upwards: linear.
    glm::vec3 direction(glm::vec2 film) const { return turn_ * glm::vec3(film * half_, 1); }

    /// What was seen before of such a surface (packSurface) in `direction` that is so near, give or
    /// take `slack`.
    Look lookUp(const glm::vec3& direction, float nearness, uint32_t surface, float slack) const;

    /// How near that was seen before is now in `direction`; negative: behind the camera.
    float nearnessNow(float then, const glm::vec3& direction) const;

private:
    const std::vector<SeenPlace>& places_;
    glm::ivec2 size_;
    glm::vec2 half_{0};  // of the film now
    glm::mat3 turn_{0};  // directions now to the film of before, pixels
    glm::vec3 way_{0};   // between the cameras, the same
    // Of the four pixels around a place, which one tells what is there: by chance, the same for
    // all. So an edge that moves by parts of a pixel is where it should be on average, and things
    // keep their shape.
    glm::vec2 chance_;
};

}  // namespace app
