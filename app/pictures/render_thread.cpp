// The loop behind RenderThread: takes the newest request, brings the renderer to it, takes samples,
// hands out pictures. What interrupts it is decided in render_exchange.cpp.
#include "app/pictures/render_thread.h"

#include <exception>
#include <optional>
#include <utility>

#include "app/methods/methods.h"
#include "app/pictures/picture_work.h"
#include "app/pictures/render_exchange.h"
#include "core/base/check.h"
#include "core/base/memory.h"
#include "core/base/time.h"

namespace app {

namespace {

using core::Clock, core::secondsSince;

// The window is drawn first; see reference_job.cpp for the other threads
constexpr int kNiceness = 5;

}  // namespace

RendererFactory viewRenderers(const std::filesystem::path& cacheFolder)
{
    return [cacheFolder](const RenderParams& params, bool validation) {
        return makeRenderer(params.method.id(),
                            {params.device, params.deviceIndex, validation, cacheFolder});
    };
}

/// What the choice of a preview's size needs to know; methods without depth count as one.
static uint32_t depthOf(const RenderParams& params)
{
    const uint32_t* depth = core::findParam<uint32_t>(params.method, "max-depth");
    return depth != nullptr ? *depth : 1;
}

/// Whether a picture of half the sides is a quarter of the work and tells of the whole.
static bool inSteps(const RenderParams& params)
{
    const core::Traits& traits = core::methodNamed(params.method.id()).traits;
    return traits.streams && !traits.sharesLight;
}

// Of a picture that is looked at: the hand that moved the camera has left it.
constexpr uint64_t kSamplesAtRest = 16;

class RenderThread::Loop {
public:
    Loop(RendererFactory factory, std::function<void()> onPicture)
        : factory_(std::move(factory)), onPicture_(std::move(onPicture))
    {}
    void run(const core::JobContext& job);

    RenderExchange exchange;

private:
    bool takeRequest();
    void step();
    bool prepareRenderer();
    bool preparePicture();
    void makeRenderer();
    bool setWorld();
    void restoreWorld(std::shared_ptr<const core::World> old);
    ResolutionControl& controlOf(Coarse coarse, bool shaded);
    Coarse choosePicture();
    bool showsCoarse() const;
    bool prepareView();
    void beginPicture();
    void lookFirst();
    void measureError();
    void warmUp();
    void takeSamples();
    void publish();
    void handOutNewest(const std::function<std::shared_ptr<Picture>(const core::Camera&)>& make);
    void handOut(std::shared_ptr<Picture> picture);
    void fail(const std::exception_ptr& failure);
    void suspendUntil(Change until, const std::string& error);
    void dropRenderer();
    std::stop_token enter(RenderPhase phase, const char* stage);

    RendererFactory factory_;
    std::function<void()> onPicture_;
    std::unique_ptr<core::Renderer> renderer_;
    std::shared_ptr<const core::World> world_;  // that the renderer holds
    std::optional<RenderRequest> made_;         // what the renderer was made for
    RenderRequest request_;
    uint64_t generation_ = 0;
    Clock::time_point postedAt_;
    std::optional<RenderRequest> begun_;  // what the picture was begun for
    PictureWork work_;
    ResolutionControl control_, shadedControl_;  // of paths, of first hits alone
    ResolutionControl quickerControl_;           // of MethodInfo::whileMoving
    std::optional<Change> suspendedUntil_;  // after a failure: the least change of the request that
                                            // is worth another try
    bool publishDue_ = false, errorDue_ = false, workLeft_ = false;
    bool retried_ = false;
    bool warm_ = false;  // first hits of this world have been found once
    bool tidy_ = false;  // this picture has given back what others freed
    double paceFactor_ = 1;
};

void RenderThread::Loop::run(const core::JobContext& job)
{
    const std::stop_callback bridge(job.stop(), [this] { exchange.end(); });
    while (takeRequest()) {
        try {
            step();
        } catch (...) {
            fail(std::current_exception());
        }
    }
    renderer_.reset();
}

/// Sleeps until there is something to do, and takes the newest request if there is one. False at
/// the end.
bool RenderThread::Loop::takeRequest()
{
    if (!exchange.wait(workLeft_)) return false;
    std::optional<PostedRequest> posted = exchange.take();
    if (!posted) return true;
    const RenderRequest old = std::exchange(request_, std::move(posted->request));
    generation_ = posted->generation;
    postedAt_ = posted->postedAt;

    const Change change = changeBetween(old, request_);
    const bool again = old.restarts != request_.restarts;
    if (change == Change::renderer || again) {
        retried_ = false;
        paceFactor_ = 1;
    }
    if (suspendedUntil_ && (change >= *suspendedUntil_ || again)) suspendedUntil_.reset();
    if (old.reference != request_.reference) {
        errorDue_ = true;
        work_.forgetReference();
    }
    publishDue_ = true;
    work_.changeLimits();
    return true;
}

void RenderThread::Loop::step()
{
    workLeft_ = false;
    if (suspendedUntil_ || !prepareRenderer()) return;
    if (!request_.world || request_.size.x == 0 || request_.size.y == 0) return;
    if (!preparePicture()) return;
    const auto wantsSamples = [&] {
        // A pause waits for a whole sample.
        const bool whole = work_.published() > 0 && work_.fraction() == 0;
        return !work_.finished() && (!request_.paused || !whole);
    };
    measureError();
    if (wantsSamples()) {
        takeSamples();
        measureError();
    }
    if ((publishDue_ && work_.presentable()) || work_.due()) publish();
    warmUp();
    workLeft_ = wantsSamples() || work_.precedes();
}

/// A new reference is measured against as soon as there are whole samples.
void RenderThread::Loop::measureError()
{
    if (work_.measureError(*renderer_, request_, errorDue_)) errorDue_ = false;
}

/// The first camera motion needs first hits, whose kernel a software device compiles for seconds:
/// better while a whole picture is on show. What its compiler has freed by then (a third of the
/// program's memory, measured) goes back to the system; so does, where a picture stays, what those
/// in motion before it have freed (20 MiB).
void RenderThread::Loop::warmUp()
{
    if (work_.coarse() != Coarse::no || work_.published() == 0) return;
    if (!warm_) {
        warm_ = true;
        renderer_->prepareAovs();
        core::giveBackMemory();
    } else if (!tidy_ && work_.published() >= kSamplesAtRest) {
        tidy_ = true;
        core::giveBackMemory();
    }
}

/// Brings the renderer to the request, whether there is a scene yet or not; false when that has
/// failed.
bool RenderThread::Loop::prepareRenderer()
{
    if (renderer_ && changeBetween(*made_, request_) != Change::renderer) return true;
    try {
        makeRenderer();
        return true;
    } catch (const core::Error& error) {
        suspendUntil(Change::renderer, error.what());
        return false;
    }
}

/// Brings world and view to the request; false when that has failed or is no longer wanted.
bool RenderThread::Loop::preparePicture()
{
    if (world_ != request_.world && !setWorld()) return false;
    const bool coarseIsOver = (work_.coarse() == Coarse::moving && !request_.moving) ||
                              (work_.precedes() && work_.published() > 0);
    if (work_.begun() && changeBetween(*begun_, request_) == Change::nothing && !coarseIsOver)
        return true;
    if (!prepareView()) return false;
    beginPicture();
    return true;
}

/// What takes longer than a frame before any picture; false when it is no longer wanted.
bool RenderThread::Loop::prepareView()
{
    enter(RenderPhase::preparing, "prepare");
    try {
        renderer_->prepare(request_.params.method, exchange.progress());
        return true;
    } catch (const core::Error& error) {
        if (error.code() != core::ExitCode::interrupted) throw;
        workLeft_ = true;
        return false;
    }
}

/// The old renderer stays until there is a new one: who asks for something that does not exist can
/// go back.
void RenderThread::Loop::makeRenderer()
{
    enter(RenderPhase::building, "start");
    std::unique_ptr<core::Renderer> renderer = factory_(request_.params, request_.validation);
    dropRenderer();
    renderer_ = std::move(renderer);
    made_ = request_;
    made_->world.reset();  // the renderer holds the one that it shows
    made_->reference.reset();
}

void RenderThread::Loop::dropRenderer()
{
    work_.discard();
    renderer_.reset();
    world_.reset();
    begun_.reset();
    control_.forget();
    shadedControl_.forget();
    quickerControl_.forget();
}

bool RenderThread::Loop::setWorld()
{
    enter(RenderPhase::building, "scene");
    work_.discard();
    const std::shared_ptr<const core::World> old = std::exchange(world_, nullptr);
    std::string text;
    try {
        renderer_->setWorld(request_.world, exchange.progress());
        world_ = request_.world;
        warm_ = false;
        control_.forget();
        shadedControl_.forget();
        quickerControl_.forget();
        return true;
    } catch (const core::Error& error) {
        workLeft_ = error.code() == core::ExitCode::interrupted;
        if (workLeft_) return false;
        text = error.what();
    } catch (const std::bad_alloc&) {
        text = "the scene does not fit into memory";
    }
    restoreWorld(old);
    suspendUntil(Change::world, text);
    return false;
}

/// After a world that could not be had: the one before, so that who goes back to it need not wait.
void RenderThread::Loop::restoreWorld(std::shared_ptr<const core::World> old)
{
    if (!old) return;
    try {
        renderer_->setWorld(old, exchange.progress());
        world_ = std::move(old);
    } catch (const std::exception&) {
        dropRenderer();  // the first failure is the one to tell
    }
}

/// Whether the picture that the request demands is preceded by a coarse one, or is one.
Coarse RenderThread::Loop::choosePicture()
{
    // Seconds of a full sample from which on a small one comes first
    constexpr double kSlow = 0.15;
    constexpr double kManyPixels = 1u << 15;  // and from here on, when nothing is known
    constexpr double kVerySlow = 1;           // and one of half the sides after that
    if (request_.moving) return Coarse::moving;
    const double pixels = double(request_.size.x) * request_.size.y;
    const double expected = control_.predict(pixels, depthOf(request_.params));
    if (!showsCoarse()) {
        const bool slow = expected > 0 ? expected > kSlow : pixels > kManyPixels;
        return slow ? Coarse::first : Coarse::no;
    }
    const bool worthHalf = work_.coarse() != Coarse::half && work_.scale() < 0.4f &&
                           expected > kVerySlow && inSteps(request_.params);
    return worthHalf ? Coarse::half : Coarse::no;
}

/// Whether a coarse picture of what the request demands is on show.
bool RenderThread::Loop::showsCoarse() const
{
    return work_.coarse() != Coarse::no && !work_.shaded() && work_.published() > 0 &&
           changeBetween(*begun_, request_) == Change::nothing;
}

void RenderThread::Loop::beginPicture()
{
    const Coarse coarse = choosePicture();
    if (!showsCoarse()) work_.dropBackdrop();
    // On a device that is what takes long, if anything does: the first view with a method.
    const bool compiles = request_.params.device == DeviceKind::vulkan;
    enter(RenderPhase::building, compiles ? "compiling kernels" : "prepare");
    if (coarse == Coarse::first) lookFirst();
    const bool follows = begun_ && begun_->restarts == request_.restarts;
    begun_ = request_;
    tidy_ = errorDue_ = false;
    const bool shaded = coarse == Coarse::moving && request_.movingShows == Moving::shaded;
    work_.begin(*renderer_, request_, coarse, follows ? core::Start::moved : core::Start::anew,
                controlOf(coarse, shaded), paceFactor_);
}

/// What pictures of a kind take: quicker parameters tell nothing of others.
ResolutionControl& RenderThread::Loop::controlOf(Coarse coarse, bool shaded)
{
    if (shaded) return shadedControl_;
    const core::MethodInfo& method = core::methodNamed(request_.params.method.id());
    return coarse == Coarse::moving && method.whileMoving != nullptr ? quickerControl_ : control_;
}

/// Of a scene of which nothing has been seen yet: software devices compile the kernels of paths for
/// a moment before there is a sample.
void RenderThread::Loop::lookFirst()
{
    const bool known = control_.predict(1, 1) > 0;
    if (known || request_.movingShows == Moving::path) return;
    const std::shared_ptr<Picture> picture = work_.look(*renderer_, request_, shadedControl_);
    if (picture) handOut(picture);
}

void RenderThread::Loop::takeSamples()
{
    const bool firstLook = work_.quick() && work_.samples() == 0;
    const std::stop_token stop =
        enter(firstLook ? RenderPhase::coarse : RenderPhase::sampling, "render");
    ResolutionControl& control = controlOf(work_.coarse(), work_.shaded());
    work_.advance(*renderer_, request_, control, stop);
    while (work_.bridges() && !stop.stop_requested()) {
        handOutNewest([&](const core::Camera& camera) {
            return work_.makeAhead(*renderer_, request_, camera);
        });
        work_.advance(*renderer_, request_, control, stop);
    }
    exchange.leave(work_.fraction());
}

std::stop_token RenderThread::Loop::enter(RenderPhase phase, const char* stage)
{
    const bool samples = phase == RenderPhase::coarse || phase == RenderPhase::sampling;
    const double fraction = samples ? work_.fraction() : core::kUnknownShare;
    return exchange.enter(phase, stage, fraction, work_.coarse() == Coarse::moving);
}

void RenderThread::Loop::publish()
{
    handOutNewest(
        [&](const core::Camera& camera) { return work_.make(*renderer_, request_, camera); });
    publishDue_ = false;
}

/// What `make` makes for the newest camera, if anything: what the hand does while paths are traced
/// need not wait for the next ones.
void RenderThread::Loop::handOutNewest(
    const std::function<std::shared_ptr<Picture>(const core::Camera&)>& make)
{
    const std::optional<MotionAhead> ahead = exchange.ahead();
    std::shared_ptr<Picture> picture = make(ahead ? ahead->camera : request_.camera);
    if (!picture) return;
    if (ahead && picture->camera == ahead->camera) {
        generation_ = ahead->generation;
        postedAt_ = ahead->postedAt;
    }
    handOut(std::move(picture));
}

void RenderThread::Loop::handOut(std::shared_ptr<Picture> picture)
{
    picture->generation = generation_;
    if (work_.coarse() == Coarse::moving) {
        const float full = static_cast<float>(picture->fullSize.x);
        exchange.publishMoving(secondsSince(postedAt_), work_.scale(),
                               static_cast<float>(picture->mean.width) / full);
    }
    exchange.publish(std::move(picture));
    if (onPicture_) onPicture_();
}

void RenderThread::Loop::suspendUntil(Change until, const std::string& error)
{
    suspendedUntil_ = until;
    exchange.publishError(error);
}

/// A renderer that has thrown is not trusted again. A lost device gets one new one, with half as
/// much work at a time.
void RenderThread::Loop::fail(const std::exception_ptr& failure)
{
    std::string text;
    bool lost = false;
    try {
        std::rethrow_exception(failure);
    } catch (const core::Error& error) {
        text = error.what();
        lost = error.code() == core::ExitCode::deviceLost;
    } catch (const std::bad_alloc&) {
        text = "out of memory";
    } catch (const std::exception& error) {
        text = error.what();
    }
    dropRenderer();
    if (lost && !retried_) {
        retried_ = true;
        paceFactor_ *= 0.5;
        workLeft_ = true;
        exchange.publishError(text + " — the device is started anew");
        return;
    }
    suspendUntil(Change::view, text);
}

// --- RenderThread

RenderThread::RenderThread(RendererFactory factory, std::function<void()> onPicture)
    : loop_(std::make_shared<Loop>(std::move(factory), std::move(onPicture))),
      worker_("render", kNiceness)
{
    worker_.start("render", [loop = loop_](core::JobContext& job) { loop->run(job); });
}

RenderThread::~RenderThread() = default;

uint64_t RenderThread::request(RenderRequest request)
{
    return loop_->exchange.post(std::move(request));
}

std::shared_ptr<const Picture> RenderThread::newest() const
{
    return loop_->exchange.newest();
}

RenderThreadStatus RenderThread::status() const
{
    return loop_->exchange.status();
}

}  // namespace app
