// One picture on its way: how the renderer is set up for it, how far it is, when it is worth
// handing out, when it is done. Owns no thread and no renderer.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "app/pictures/moving_detail.h"
#include "app/pictures/picture.h"
#include "app/pictures/resolution_control.h"

namespace app {

/// What has to be done anew to get from one request to another, least first.
enum class Change { nothing, view, world, renderer };
Change changeBetween(const RenderRequest& from, const RenderRequest& to);

/// A small picture that comes before the full one, or instead of it: one that takes a moment, one
/// of half the sides after it where the full one takes long, one of a camera that moves.
enum class Coarse { no, first, half, moving };

class PictureWork {
public:
    using Clock = std::chrono::steady_clock;

    /// Sets the renderer up for the request's view, which follows on the last one as `start` says.
    /// `first`: one small sample is to be shown before the full picture. `paceFactor` shortens
    /// every piece of work (1 is normal).
    void begin(core::Renderer& renderer, const RenderRequest& request, Coarse coarse,
               core::Start start, ResolutionControl& control, double paceFactor);

    /// First hits of the request's view, lit from the camera, where the first samples are far off
    /// (core::Renderer::look); null where they are not. begin() comes next.
    std::shared_ptr<Picture> look(core::Renderer& renderer, const RenderRequest& request,
                                  ResolutionControl& control);

    /// Renders for a tenth of a second, up to the next limit or point of the curve: some samples,
    /// or a part of one. Small pictures are completed, but for what makeAhead() may come between.
    void advance(core::Renderer& renderer, const RenderRequest& request, ResolutionControl& control,
                 std::stop_token stop);

    /// Adds a point to the curve when its time has come (`force`: now) and finds out whether a
    /// limit is reached; both only between whole samples. Whether there is a point as of now.
    bool measureError(core::Renderer& renderer, const RenderRequest& request, bool force);

    /// Whether there is something to show: a whole sample, or a part of the first one before the
    /// small picture that came before it.
    bool presentable() const { return samples_ > 0 || (fraction_ > 0 && backdrop_); }

    /// Whether a picture is worth its cost now.
    bool due() const;

    /// The picture as the estimate stands. Its cost is remembered for due(). Where its surfaces are
    /// finer than its light, it is what `ahead` sees of them: the request's camera, or where that
    /// has gone meanwhile.
    std::shared_ptr<Picture> make(core::Renderer& renderer, const RenderRequest& request,
                                  const core::Camera& ahead);

    /// What the picture before has left while the light of this one is on its way: that light on
    /// the surfaces that `ahead` sees. Null where there is none, or the same is on show.
    std::shared_ptr<Picture> makeAhead(core::Renderer& renderer, const RenderRequest& request,
                                       const core::Camera& ahead);

    /// Whether makeAhead() may come before this picture's own light, which is not there yet.
    bool bridges() const { return bridged_ && samples_ == 0; }

    /// Another reference, or none: errors against the one before are no part of the same curve.
    void forgetReference();

    void changeLimits() { finished_ = false; }  // measureError() looks again
    bool begun() const { return begun_; }
    void discard() { *this = {}; }  // the renderer holds no picture any more
    void dropBackdrop() { backdrop_.reset(); }
    Coarse coarse() const { return coarse_; }
    /// Whether it takes about as long as a frame, and is not cut up.
    bool quick() const { return coarse_ == Coarse::first || coarse_ == Coarse::moving; }
    /// Whether a finer picture of the same view follows it.
    bool precedes() const { return coarse_ == Coarse::first || coarse_ == Coarse::half; }
    bool shaded() const { return shaded_; }
    float scale() const { return scale_; }
    uint64_t samples() const { return samples_; }
    double fraction() const { return fraction_; }
    /// Samples of the last picture handed out; 0: none with a whole one yet.
    uint64_t published() const { return published_; }
    bool finished() const { return finished_; }

private:
    /// The light of a picture in motion: its mean without what is finer, at the pixels that show
    /// `aovs`; and the camera of the newest picture with that light.
    struct KnownLight {
        core::Image mean;
        std::shared_ptr<const core::Aovs> aovs;
        core::Camera camera, shown;
    };

    uint32_t nextCount(const RenderRequest& request) const;
    void readEverything(core::Renderer& renderer);
    void fillFromBackdrop(core::Estimate& estimate) const;
    std::shared_ptr<const core::Aovs> surfaces(core::Renderer& renderer,
                                               const RenderRequest& request) const;
    void advanceShaded(core::Renderer& renderer, const RenderRequest& request,
                       ResolutionControl& control);
    bool spreads(const RenderRequest& request) const;
    void describe(Picture& picture, const core::Renderer& renderer,
                  const RenderRequest& request) const;
    void addPreview(core::Renderer& renderer, Picture& picture, const RenderRequest& request,
                    const core::Camera& ahead);
    void addDetail(core::Renderer& renderer, Picture& picture, const RenderRequest& request,
                   const core::Camera& ahead);
    double secondsBeforeAhead() const;
    bool limitReached(const RenderRequest& request) const;

    bool begun_ = false, finished_ = false;
    Coarse coarse_ = Coarse::no;
    bool shaded_ = false;    // first hits alone
    bool detailed_ = false;  // its surfaces are finer than its light
    bool bridged_ = false;   // which takes so long that the light before it is shown meanwhile
    bool follows_ = false;   // see Picture
    glm::uvec2 size_{0}, fineSize_{0};
    float scale_ = 1;
    uint32_t depth_ = 0;
    core::Pace pace_;
    uint64_t samples_ = 0, published_ = 0, nextPoint_ = 0;
    double seconds_ = 0, pointSeconds_ = 0, publishSeconds_ = 0, firstSeconds_ = 0;
    Clock::time_point publishedAt_;
    std::vector<ErrorPoint> curve_;
    double fraction_ = 0, stepSeconds_ = 0;  // of the step under way
    uint64_t version_ = 0, publishedVersion_ = 0;
    std::optional<core::Estimate>
        estimate_;  // with everything, as it stands, when it has been read
    std::shared_ptr<const core::Image> backdrop_;    // the small picture that came before this one
    std::shared_ptr<const core::Aovs> aovs_, fine_;  // of this view; of light_->shown
    std::optional<KnownLight> light_;                // the newest
    MovingDetail detail_;
};

}  // namespace app
