// One picture on its way: how the renderer is set up for it, how far it is, when it is worth
// handing out, when it is done. Owns no thread and no renderer.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "app/session/picture.h"
#include "app/session/resolution_control.h"

namespace app {

/// What has to be done anew to get from one request to another, least first.
enum class Change { nothing, view, world, renderer };
Change changeBetween(const RenderRequest& from, const RenderRequest& to);

/// A small picture that comes before the full one, or instead of it.
enum class Coarse { no, first, moving };

class PictureWork {
public:
    using Clock = std::chrono::steady_clock;

    /// Sets the renderer up; the film is empty then. `first`: one small sample is to be shown
    /// before the full picture. `paceFactor` shortens every piece of work (1 is normal).
    void begin(core::Renderer& renderer, const RenderRequest& request, Coarse coarse,
               ResolutionControl& control, double paceFactor);

    /// Takes some samples: one at first, then what fits in a tenth of a second, up to the next
    /// limit or point of the curve. False when the film was lost to a stop: then it has to begin
    /// again.
    bool advance(core::Renderer& renderer, const RenderRequest& request, ResolutionControl& control,
                 std::stop_token stop);

    /// Adds a point to the curve when its time has come (`force`: now) and finds out whether a
    /// limit is reached.
    void judge(core::Renderer& renderer, const RenderRequest& request, bool force);

    /// Whether a picture is worth its cost now.
    bool due() const;

    /// The picture as the film stands. Its cost is remembered for due().
    std::shared_ptr<Picture> make(core::Renderer& renderer, const RenderRequest& request);

    void changeLimits() { finished_ = false; }  // judge() looks again
    bool begun() const { return begun_; }
    void lose() { begun_ = false; }
    Coarse coarse() const { return coarse_; }
    float scale() const { return scale_; }
    uint64_t samples() const { return samples_; }
    uint64_t published() const
    {
        return published_;
    }  // samples of the last picture handed out; 0: none yet
    bool finished() const { return finished_; }

private:
    uint32_t nextCount(const RenderRequest& request) const;
    void readFilm(core::Renderer& renderer);
    bool limitReached(const RenderRequest& request) const;

    bool begun_ = false, finished_ = false;
    Coarse coarse_ = Coarse::no;
    glm::uvec2 size_{0};
    float scale_ = 1;
    uint32_t depth_ = 0;
    uint64_t samples_ = 0, published_ = 0, nextPoint_ = 0;
    double seconds_ = 0, pointSeconds_ = 0, publishSeconds_ = 0, firstSeconds_ = 0;
    Clock::time_point publishedAt_;
    std::vector<ErrorPoint> curve_;
    core::FilmCounters counters_;
    std::optional<core::Film> film_;          // as it stands, when it has been read
    std::shared_ptr<const core::Aovs> aovs_;  // of this view
};

}  // namespace app
