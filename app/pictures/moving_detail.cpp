// See moving_detail.h.
#include "app/pictures/moving_detail.h"

#include <algorithm>
#include <cmath>

#include "app/pictures/preview_shading.h"
#include "core/base/params.h"
#include "core/base/time.h"
#include "core/methods/reuse_params.h"

namespace app {

namespace {

constexpr double kMostSeconds = 1.0 / 30;  // of a picture
constexpr double kShare = 0.35;            // of its time
constexpr double kTooMuch = 1.7;           // times that: it is made smaller in flight, too

}  // namespace

bool MovingDetail::wanted(const RenderRequest& request)
{
    const core::AnyParams& method = request.params.method;
    const auto* jitter = core::findParam<core::PixelJitter>(method, "jitter");
    const auto* reuse = core::findParam<core::ReuseStrategy>(method, "reuse");
    return request.movingDetail && request.movingShows != Moving::shaded &&
           !request.camera.orthographic && jitter != nullptr &&
           *jitter != core::PixelJitter::always &&
           (reuse == nullptr || *reuse != core::ReuseStrategy::discard);
}

double MovingDetail::secondsOfPicture(const RenderRequest& request)
{
    return std::min(request.targetFrameSeconds, kMostSeconds);
}

/// Whether what the upsampler has seen is of that scene, found in that way.
bool MovingDetail::continues(const RenderRequest& request) const
{
    return world_.lock() == request.world && method_ == request.params.method;
}

/// The largest size, in steps of half the pixels, that is made in kShare of the time of a picture.
glm::uvec2 MovingDetail::affordable(const RenderRequest& request) const
{
    const double pixels = double(request.size.x) * request.size.y,
                 most = kShare * secondsOfPicture(request) / secondsPerPixel_,
                 halves = std::max(std::ceil(std::log2(pixels / most)), 0.0);
    const glm::dvec2 size = glm::dvec2(request.size) * std::exp2(-0.5 * halves);
    return glm::max(glm::uvec2(glm::round(size)), glm::uvec2(1));
}

std::optional<core::Camera> MovingDetail::next(const RenderRequest& request, glm::uvec2 size,
                                               bool follows)
{
    const bool dear = seconds() > kTooMuch * kShare * secondsOfPicture(request);
    if (settled_ || !follows || !active_ || full_ != request.size || dear) {
        full_ = request.size;
        size_ = affordable(request);
    }
    active_ = size.x <= size_.x && size.y <= size_.y;
    if (!active_) {
        upsampler_.forget();
        return {};
    }
    if (settled_) {
        world_ = settled_->world;
        method_ = settled_->params.method;
        upsampler_.begin(settled_->mean, *firstHits_, settled_->camera, size_);
        settled_.reset();
        firstHits_.reset();
    }
    if (!follows || !continues(request)) upsampler_.forget();
    world_ = request.world;
    method_ = request.params.method;
    camera_ = request.camera;
    camera_.shift = TemporalUpsampler::shiftOf(count_++, size);
    return camera_;
}

void MovingDetail::addTo(Picture& picture, const core::Aovs& aovs)
{
    const auto start = core::Clock::now();
    picture.sampledGuide = std::move(picture.guide);
    picture.mean = upsampler_.add({picture.mean, aovs, *picture.sampledGuide, camera_}, size_);
    if (size_ != full_) {
        // It has edges of its own: between its pixels it is shown smooth.
        if (!smooth_ || glm::uvec2(smooth_->width, smooth_->height) != size_)
            smooth_ = std::make_shared<const core::Image>(smoothGuide(size_));
        picture.guide = smooth_;
    }
    const double now = core::secondsSince(start) / (double(size_.x) * size_.y);
    secondsPerPixel_ = 0.75 * secondsPerPixel_ + 0.25 * now;
}

void MovingDetail::settle(std::shared_ptr<const Picture> picture,
                          std::shared_ptr<const core::Aovs> aovs)
{
    settled_ = std::move(picture);
    firstHits_ = std::move(aovs);
}

}  // namespace app
