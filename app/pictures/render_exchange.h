// What the render thread and the others hand each other, under one lock: requests in one direction,
// pictures and status in the other, and what is worked on, so that a request knows what to
// interrupt.
#pragma once

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>

#include "app/pictures/picture.h"
#include "app/pictures/render_thread.h"
#include "core/base/progress.h"

namespace app {

/// What the render thread is doing, as far as it matters to whoever interrupts it. What is prepared
/// is of use to any view of the world, unless that asks for another thing. A coarse picture
/// is finished whatever happens to the view: it takes no longer than a frame, and one whose camera
/// never rests would otherwise never be seen.
enum class RenderPhase { idle, building, preparing, coarse, sampling };

struct PostedRequest {
    RenderRequest request;
    uint64_t generation = 0;
    std::chrono::steady_clock::time_point postedAt;
};

/// A camera that has moved on, and since when.
struct MotionAhead {
    core::Camera camera;
    uint64_t generation = 0;
    std::chrono::steady_clock::time_point postedAt;
};

class RenderExchange {
public:
    // --- any thread

    /// Takes the place of the request before, and interrupts work that is of no use to it; returns
    /// its generation.
    uint64_t post(RenderRequest request);
    std::shared_ptr<const Picture> newest() const;
    RenderThreadStatus status() const;
    void end();  // interrupts whatever it is

    // --- the render thread

    /// False at the end. Sleeps until there is a request, unless `workLeft`.
    bool wait(bool workLeft);

    /// Where the camera has gone meanwhile, if the newest request asks for nothing else than what
    /// is worked on.
    std::optional<MotionAhead> ahead() const;

    /// The newest request, once; from now on it is what is worked on.
    std::optional<PostedRequest> take();

    /// Begins a phase, in which requests may stop what is done: one that has come in the meantime
    /// does so at once. `movingPreview`: what is rendered is of use only while the camera moves.
    std::stop_token enter(RenderPhase phase, const char* stage, double fraction,
                          bool movingPreview);

    /// Ends a phase of samples.
    void leave(double fraction);

    /// Shows how far a stage is; throws core::Error (interrupted) when it is no longer wanted.
    core::Progress progress();

    void publish(std::shared_ptr<const Picture> picture);
    void publishMoving(double seconds, float scale, float surfaceScale);
    void publishError(const std::string& error);

private:
    bool interrupts(const RenderRequest& next) const;
    void interrupt();
    void setStage(const char* stage, double fraction);

    using Clock = std::chrono::steady_clock;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::optional<PostedRequest> posted_;
    RenderRequest working_;
    uint64_t generations_ = 0;
    bool ended_ = false;
    RenderPhase phase_ = RenderPhase::idle;
    bool movingPreview_ = false;
    std::stop_source interrupt_;
    Clock::time_point interruptedAt_, stageSince_;
    std::shared_ptr<const Picture> picture_;
    RenderThreadStatus status_;
};

}  // namespace app
