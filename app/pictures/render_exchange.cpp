// See render_exchange.h.
#include "app/pictures/render_exchange.h"

#include <utility>

#include "app/pictures/picture_work.h"
#include "core/base/check.h"
#include "core/base/time.h"
#include "core/methods/path_params.h"

namespace app {

using core::secondsSince;

/// What there may be to prepare depends on; nothing for methods that do not ask for it.
static std::optional<core::SkySampling> skySampling(const RenderRequest& request)
{
    const auto* sampling = core::findParam<core::SkySampling>(request.params.method, "sky");
    return sampling != nullptr ? std::optional(*sampling) : std::nullopt;
}

// --- any thread

/// Under the lock: whether the work under way is of no use to `next`.
bool RenderExchange::interrupts(const RenderRequest& next) const
{
    const Change change = changeBetween(working_, next);
    switch (phase_) {
    case RenderPhase::idle:
        return false;
    case RenderPhase::building:
    case RenderPhase::coarse:
        return change >= Change::world;
    case RenderPhase::preparing:
        return change >= Change::world || skySampling(working_) != skySampling(next);
    case RenderPhase::sampling:
        return change >= Change::view || (movingPreview_ && !next.moving);
    }
    return false;
}

/// Under the lock.
void RenderExchange::interrupt()
{
    if (interrupt_.stop_requested()) return;
    interruptedAt_ = Clock::now();
    interrupt_.request_stop();
}

uint64_t RenderExchange::post(RenderRequest request)
{
    const std::lock_guard lock(mutex_);
    if (interrupts(request)) interrupt();
    posted_ = PostedRequest{std::move(request), ++generations_, Clock::now()};
    changed_.notify_all();
    return generations_;
}

std::shared_ptr<const Picture> RenderExchange::newest() const
{
    const std::lock_guard lock(mutex_);
    return picture_;
}

RenderThreadStatus RenderExchange::status() const
{
    const std::lock_guard lock(mutex_);
    RenderThreadStatus status = status_;
    status.stageSeconds = secondsSince(stageSince_);
    return status;
}

void RenderExchange::end()
{
    const std::lock_guard lock(mutex_);
    ended_ = true;
    interrupt_.request_stop();
    changed_.notify_all();
}

// --- the render thread

/// Under the lock.
void RenderExchange::setStage(const char* stage, double fraction)
{
    if (status_.stage != stage) stageSince_ = Clock::now();
    status_.stage = stage;
    status_.fraction = fraction;
}

bool RenderExchange::wait(bool workLeft)
{
    std::unique_lock lock(mutex_);
    phase_ = RenderPhase::idle;
    if (!workLeft && !posted_) {
        setStage("idle", 0);
        status_.rendering = false;
        changed_.wait(lock, [this] { return posted_ || ended_; });
    }
    return !ended_;
}

std::optional<PostedRequest> RenderExchange::take()
{
    const std::lock_guard lock(mutex_);
    if (!posted_) return std::nullopt;
    working_ = posted_->request;
    // An end that has come in between stops what follows, too.
    interrupt_ = std::stop_source();
    if (ended_) interrupt_.request_stop();
    return std::exchange(posted_, std::nullopt);
}

std::optional<MotionAhead> RenderExchange::ahead() const
{
    const std::lock_guard lock(mutex_);
    if (!posted_ || !posted_->request.moving) return std::nullopt;
    RenderRequest here = working_;
    here.camera = posted_->request.camera;
    if (here != posted_->request) return std::nullopt;
    return MotionAhead{here.camera, posted_->generation, posted_->postedAt};
}

std::stop_token RenderExchange::enter(RenderPhase phase, const char* stage, double fraction,
                                      bool movingPreview)
{
    const std::lock_guard lock(mutex_);
    phase_ = phase;
    movingPreview_ = movingPreview;
    status_.rendering = phase == RenderPhase::sampling || phase == RenderPhase::coarse;
    setStage(stage, fraction);
    if (posted_ && interrupts(posted_->request)) interrupt();
    return interrupt_.get_token();
}

void RenderExchange::leave(double fraction)
{
    const std::lock_guard lock(mutex_);
    phase_ = RenderPhase::idle;
    status_.fraction = fraction;
    if (interrupt_.stop_requested()) status_.lastStopSeconds = secondsSince(interruptedAt_);
}

core::Progress RenderExchange::progress()
{
    return [this](const char* stage, double fraction) {
        const std::lock_guard lock(mutex_);
        setStage(stage, fraction);
        if (interrupt_.stop_requested())
            throw core::Error("the scene is no longer wanted", core::ExitCode::interrupted);
    };
}

void RenderExchange::publish(std::shared_ptr<const Picture> picture)
{
    const std::lock_guard lock(mutex_);
    picture_.swap(picture);  // the old one dies with the argument, after the lock
    status_.error.clear();
}

void RenderExchange::publishMoving(double seconds, float scale, float surfaceScale)
{
    const std::lock_guard lock(mutex_);
    status_.movingSeconds = seconds;
    status_.movingScale = scale;
    status_.movingSurfaceScale = surfaceScale;
}

void RenderExchange::publishError(const std::string& error)
{
    const std::lock_guard lock(mutex_);
    status_.error = status_.lastError = error;
    ++status_.errorCount;
}

}  // namespace app
