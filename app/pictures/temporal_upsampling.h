// Full pictures from small ones while the camera moves. Each small picture has light and first hits
// at points of the film, other points from picture to picture, and a picture of the full size keeps
// what was seen at its pixels. After Yang et al., "Amortized Supersampling", 2009, and Herzog et
// al., "Spatio-Temporal Upsampling on the GPU", 2010. Here first hits are known at the points
// alone: between them, edges are where the pictures before have seen them. What is kept is held to
// the mean and spread of the light around (Salvi, "An Excursion in Temporal Supersampling", 2016,
// cuts it off), less where it foretells the points.
#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "app/pictures/seen_before.h"
#include "core/image/image.h"
#include "core/methods/renderer.h"
#include "core/scene/camera.h"

namespace app {

class TemporalUpsampler {
public:
    TemporalUpsampler();
    ~TemporalUpsampler();

    /// A picture with its first hits, and the camera, of perspective, that saw both.
    struct Seen {
        const core::Image& mean;   // RGB radiance
        const core::Aovs& aovs;    // of the same size
        const core::Image& guide;  // surfaceGuide(aovs)
        const core::Camera& camera;
    };

    /// By how much the camera of picture number `i` of a flight is to be shifted, so that the
    /// points of pictures of that size cover their pixels evenly (core::Camera::shift).
    static glm::dvec2 shiftOf(uint64_t i, glm::uvec2 size);

    /// A picture of little noise to begin with, for ones of `size`.
    void begin(const core::Image& mean, const core::Aovs& aovs, const core::Camera& camera,
               glm::uvec2 size);

    /// Takes a small picture and returns one of `size`. What was seen before counts where it has
    /// been of that size.
    core::Image add(const Seen& seen, glm::uvec2 size);

    /// Nothing of before counts any more.
    void forget();

private:
    struct Sample;
    class Step;

    void findSamples(const Seen& seen);

    std::vector<SeenPlace> places_, before_;
    std::vector<Sample> samples_;  // of the small picture
    glm::uvec2 size_{0};           // of places_
    core::Camera camera_;          // that they are seen from
    uint64_t count_ = 0;           // of pictures
};

}  // namespace app
