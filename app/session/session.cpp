// The viewer without a window. See session.h. What the threads have finished is taken at the start
// of `update`; what has to be done differs from what was ordered is found at its end, by
// comparison.
#include "app/session/session.h"

#include <algorithm>
#include <cmath>

#include "app/files/load.h"
#include "app/pictures/metering.h"
#include "app/pictures/save_picture.h"
#include "app/session/pending_saves.h"
#include "app/session/replay.h"
#include "app/session/session_jobs.h"
#include "app/session/settings_keeper.h"
#include "core/base/check.h"

namespace app {

namespace fs = std::filesystem;

namespace {

constexpr double kMovingSeconds = 0.2;  // after the last motion, pictures stay quick for so long
// A window's size counts when it has not changed for so long
constexpr double kSettlingSeconds = 0.15;
constexpr uint32_t kLeastSide = 16;

}  // namespace

Session::Session(const SessionOptions& options)
    : options_(options), pictures_(options.cacheFolder),
      pendingSaves_(std::make_unique<PendingSaves>()),
      loadedBox_(std::make_shared<core::Mailbox<Loaded>>()),
      referenceBox_(std::make_shared<core::Mailbox<Reference>>()),
      saves_(std::make_shared<SaveQueue>()), foundBox_(std::make_shared<core::Mailbox<Found>>()),
      aroundBox_(std::make_shared<core::Mailbox<LookedAround>>()), loader_("loader", 5),
      core_("core", 10), saver_("saver", 5), lookout_("lookout", 5),
      renderThread_(options.factory, options.onPicture)
{
    notices.quiet = options.quiet;
    render = options.render;
    if (!options.settings.empty()) {
        std::string problem;
        settings = readSettings(options.settings, problem);
        if (!problem.empty()) notices.tell(Severity::warning, problem);
        settingsKeeper_ = std::make_unique<SettingsKeeper>(options.settings, settings);
        settings.panels.help = false;  // who closes the window has read it
    }
    keptScale_ = settings.panels.uiScale;
    if (options.uiScale > 0) settings.panels.uiScale = options.uiScale;
    if (!options.methodGiven) render.method = settings.paramsOf(render.method.id());
    if (options.scene.file.empty()) return;
    load(options.scene);
    RenderRequest early;  // the device opens while the scene loads
    early.params = render;
    early.validation = options.validation;
    renderThread_.request(std::move(early));
}

Session::~Session()
{
    try {
        endSaves("the program ended");
        saver_.wait();
        tellEnds();  // a picture that could not be saved is told even now
        keepPicture();
        if (settingsKeeper_) settingsKeeper_->finish(settingsToKeep());
    } catch (const std::exception& error) {
        notices.tell(Severity::warning, error.what());
    }
}

/// The settings as the next run should find them.
Settings Session::settingsToKeep()
{
    keepCameras();
    Settings kept = settings;
    kept.keepParams(render.method);
    if (options_.uiScale > 0 && kept.panels.uiScale == options_.uiScale)
        kept.panels.uiScale = keptScale_;
    return kept;
}

void Session::chooseMethod(std::string_view id)
{
    if (id != render.method.id()) chooseParams(settings.paramsOf(core::methodNamed(id).id()));
}

void Session::chooseParams(const core::AnyParams& params)
{
    settings.keepParams(render.method);
    render.method = params;
}

void Session::update(double seconds, glm::uvec2 pictureArea)
{
    now_ += seconds;
    takeLoaded();
    takeReference();
    tellEnds();
    animate(seconds);
    noteWorks();
    takePicture();
    judge();
    order(pictureArea);
    if (document_ && !track.playing() && !player.playing)
        history_.observe(navigation.viewpoint(), now_);
    lookAround();
    if (settingsKeeper_ && settingsKeeper_->isDue(now_)) settingsKeeper_->offer(settingsToKeep());
}

bool Session::busy() const
{
    const RenderThreadStatus rendering = renderThread_.status();
    const bool works = !rendering.stage.empty() && rendering.stage != "idle";
    return works || judge_.busy() || loader_.status().active() || core_.status().active() ||
           saver_.status().active() || track.playing() || player.playing || isMoving() ||
           equalTime_.running() || !pendingSaves_->empty() || seeking_ != 0 || looking_ != 0 ||
           pendingReference_.has_value() || unsettled_ || hasNews() ||
           (referenceKeySeconds > 0 && !holdReference);
}

bool Session::hasNews() const
{
    return renderThread_.newest() != picture_;
}

/// Something to look at behind the message that there is no first scene.
void Session::showBuiltIn()
{
    if (!options_.builtIn || document_) return;
    options_.builtIn = false;
    load(defaultScene());
}

/// Failures of the threads, each told once.
void Session::tellEnds()
{
    const auto tell = [this](const core::JobStatus& job, uint64_t& told) {
        if (job.active() || job.generation == told || job.state == core::JobState::idle) return;
        told = job.generation;
        if (job.state == core::JobState::failed) notices.tell(Severity::error, job.error);
        if (job.state == core::JobState::cancelled && job.name != kPoseJob)
            notices.tell(Severity::news, job.name + ": cancelled");
        if (job.state == core::JobState::done && job.name.starts_with("export"))
            notices.tell(Severity::news,
                         job.name + ": done, in " +
                             fs::path(wholePath(exportPattern_)).parent_path().string(),
                         exportPattern_);
    };
    tell(loader_.status(), toldLoader_);
    if (loader_.status().state == core::JobState::failed) showBuiltIn();
    tell(core_.status(), toldCore_);
    tell(saver_.status(), toldSaver_);
    for (const auto& [failed, text, file] : saves_->takeTold()) {
        notices.tell(failed ? Severity::error : Severity::news, text, file);
        if (failed) {  // whatever it was is asked for again
            savedSeconds_ = 0;
            saved_.clear();
        }
        saveFailed_ = saveFailed_ || failed;
    }
    const RenderThreadStatus rendering = renderThread_.status();
    if (rendering.errorCount != toldRendering_) {
        toldRendering_ = rendering.errorCount;
        notices.tell(Severity::error, rendering.lastError);
    }
}

bool Session::isMoving() const
{
    return now_ - movedAt_ < kMovingSeconds;
}

// --- pictures

void Session::takePicture()
{
    const std::shared_ptr<const Picture> newest = renderThread_.newest();
    if (newest && newest != picture_) {
        const bool goesOn = picture_ && onePicture(*picture_, *newest);
        picture_ = newest;
        if (!goesOn || picture_->seconds < savedSeconds_) savedSeconds_ = 0;  // it began anew
        // One of the scene before is of no view that there is.
        if (document_ && picture_->world.lock() == document_->world)
            convergence_.take(*picture_, sceneName());
        if (equalTime_.running()) takeEqualTime();
    }
    if (picture_ && isWhole(*picture_)) whole_ = picture_;
    noteBrightness();
    if (pendingReference_) takeReferencePicture();
    pendingSaves_->offer(whole_);
    handOver(pendingSaves_->takeReady(now_));
    completeSlots();
}

std::optional<ShownScene> Session::shownScene() const
{
    if (!document_ || !picture_) return {};
    // Every instant has a world of its own, and while an animation plays pictures lag behind it.
    const bool isNow = picture_->world.lock() == document_->world;
    const bool lags = player.playing && picture_->scene.lock() == document_->world->scene;
    if (!isNow && !lags) return {};
    ShownScene scene = *document_;
    scene.time = picture_->time;
    return scene;
}

void Session::expose()
{
    const std::optional<float> stops = picture_ ? meteredStops(picture_->mean) : std::nullopt;
    if (stops) settings.view.exposure = *stops;
}

/// Who sees white or black alone at first may not know that there is a picture. Told once a scene.
void Session::noteBrightness()
{
    constexpr float kMostOff = 3;  // stops; the curves show two or three more either way
    if (metered_ || !document_ || !picture_ || picture_->preview || picture_->samples == 0 ||
        picture_->world.lock() != document_->world)
        return;
    metered_ = true;
    const std::optional<float> stops = meteredStops(picture_->mean);
    const float off = stops ? settings.view.exposure - *stops : 0;
    if (std::abs(off) < kMostOff) return;
    notices.tell(Severity::news, "the picture is " + std::to_string(std::lround(std::abs(off))) +
                                     (off > 0 ? " stops too bright" : " stops too dark") +
                                     ": Ctrl+E exposes for it");
}

void Session::restart()
{
    ++restarts_;
}

/// While a window's edge is dragged its size changes with every frame: the picture waits until it
/// settles.
void Session::noteArea(glm::uvec2 area)
{
    if (area != area_) {
        area_ = area;
        areaSince_ = now_;
    }
    unsettled_ = now_ - areaSince_ < kSettlingSeconds;
}

/// Of the picture that `wanted` asks for, whose size is still that of the one before. A picture
/// that only its size would begin anew keeps it where that would lose much.
glm::uvec2 Session::pictureSize(const RenderRequest& wanted)
{
    if (fixedSize_.x > 0) return fixedSize_;
    if (unsettled_ && ordered_.size.x > 0) return ordered_.size;
    const auto scale = static_cast<double>(std::clamp(settings.view.pictureScale, 0.1f, 2.0f));
    const glm::uvec2 size =
        glm::max(glm::uvec2(glm::round(glm::dvec2(area_) * scale)), glm::uvec2(kLeastSide));
    // Both sides of an equal-time run have the size that the first began with.
    const bool worthIt = equalTime_.running() || (sameView(wanted, ordered_) &&
                                                  (keepsSize_ || unsavedSeconds() > muchSeconds));
    const bool before = keepsSize_;
    keepsSize_ = generation_ != 0 && size != ordered_.size && scale == sizedFor_ && worthIt;
    if (keepsSize_ && !before)
        notices.tell(Severity::news, "the picture keeps its size, so that nothing of it is lost: R "
                                     "begins it anew");
    if (keepsSize_) return ordered_.size;
    sizedFor_ = scale;
    return size;
}

void Session::order(glm::uvec2 pictureArea)
{
    noteArea(pictureArea);
    if (!document_ || pictureArea.x == 0 || pictureArea.y == 0) return;
    RenderRequest wanted;
    wanted.world = document_->world;
    wanted.camera = navigation.view();
    wanted.size = ordered_.size;
    wanted.params = equalTime_.running() ? equalTime_.wanted() : render;
    wanted.validation = options_.validation;
    wanted.restarts = restarts_;
    wanted.size = pictureSize(wanted);
    navigation.setAspect(static_cast<double>(wanted.size.x) / wanted.size.y);
    wanted.camera = navigation.view();
    if (equalTime_.running() && ordered_.world &&
        (wanted.world != ordered_.world || wanted.camera != ordered_.camera ||
         wanted.size != ordered_.size)) {
        equalTime_.cancel();
        wanted.params = render;
        notices.tell(Severity::news, "equal time: cancelled, the view has changed");
    }
    wanted.moving = isMoving() && !equalTime_.running();
    wanted.paused = paused && !equalTime_.running();
    wanted.targetFrameSeconds = 1.0 / static_cast<double>(std::max(settings.view.movingRate, 1.0f));
    wanted.movingDepth = settings.view.movingDepth;
    wanted.movingShows = settings.view.moving;
    wanted.movingDetail = settings.view.movingDetail;
    wanted.wantVariance = wantsVariance();
    wanted.wantAovs = inspecting || !pendingSaves_->empty() ||
                      (settings.view.show >= Show::depth && settings.view.show <= Show::emitter);
    wanted.wantMaps = settings.view.show == Show::methodMap;
    if (referenceFits(wanted)) wanted.reference = reference_;
    if (generation_ != 0 && wanted == ordered_) return;
    if (!sameView(wanted, ordered_)) handOver(pendingSaves_->leaveView(wanted, document_->time));
    ordered_ = wanted;
    generation_ = renderThread_.request(std::move(wanted));
}

}  // namespace app
