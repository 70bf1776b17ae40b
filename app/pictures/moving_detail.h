// Which pictures of a moving camera get the detail of those before, and where it comes from: the
// picture at rest that the flight begins with, then each small picture.
#pragma once

#include <memory>
#include <optional>

#include "app/pictures/picture.h"
#include "app/pictures/temporal_upsampling.h"

namespace app {

class MovingDetail {
public:
    /// Whether such pictures get it: those whose samples lie at points that are known, the centres
    /// of pixels, seen in perspective, unless nothing is to be kept.
    static bool wanted(const RenderRequest& request);

    /// The camera, with its shift, of the next small picture, which is of `size`. `follows`: it is
    /// of the same scene as those before, as it was.
    /// Nothing where `size` is more than could be afforded: that picture stands for itself.
    std::optional<core::Camera> next(const RenderRequest& request, glm::uvec2 size, bool follows);

    /// Makes a larger picture of a small one that has a guide, of the camera that next() has
    /// returned: of the full size, or one that takes no more than a part of the time of a picture.
    void addTo(Picture& picture, const core::Aovs& aovs);

    /// A picture at rest, with which the next flight may begin, and its first hits.
    void settle(std::shared_ptr<const Picture> picture, std::shared_ptr<const core::Aovs> aovs);

    /// What such a picture may take, paths and addTo() together: no more than a thirtieth of a
    /// second. More pictures do more than larger ones, which know but one point for each pixel.
    static double secondsOfPicture(const RenderRequest& request);

    /// What addTo() will take, by the last ones.
    double seconds() const { return active_ ? secondsPerPixel_ * size_.x * size_.y : 0; }

private:
    bool continues(const RenderRequest& request) const;
    glm::uvec2 affordable(const RenderRequest& request) const;

    TemporalUpsampler upsampler_;
    core::Camera camera_;                          // of the picture under way
    std::shared_ptr<const Picture> settled_;       // null once a flight has begun
    std::shared_ptr<const core::Aovs> firstHits_;  // of settled_
    std::weak_ptr<const core::World> world_;       // that the upsampler has seen
    core::AnyParams method_;                       // with which
    std::shared_ptr<const core::Image> smooth_;    // smoothGuide() of the size that was made last
    glm::uvec2 full_{0}, size_{0};                 // of the request, of what is made
    bool active_ = false;                          // the last picture was made so
    uint64_t count_ = 0;
    double secondsPerPixel_ = 4e-8;  // measured on two cores of 2020; then on these
};

}  // namespace app
