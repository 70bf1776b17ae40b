// The viewer without a window. See session.h. What the threads have finished is taken at the start
// of `update`; what has to be done differs from what was ordered is found at its end, by
// comparison.
#include "app/session/session.h"

#include <algorithm>

#include "app/files/load.h"
#include "app/session/replay.h"
#include "app/session/save_picture.h"
#include "app/session/session_jobs.h"
#include "core/base/check.h"

namespace app {

namespace fs = std::filesystem;

namespace {

constexpr double kMovingSeconds = 0.2;  // after the last motion, pictures stay quick for so long
// A window's size counts when it has not changed for so long
constexpr double kSettlingSeconds = 0.15;
constexpr double kSaveSeconds = 3;  // a save waits so long for a picture that carries its variance
constexpr uint32_t kLeastSide = 16;

}  // namespace

Session::Session(const SessionOptions& options)
    : options_(options), pictures_(options.cacheFolder),
      loadedBox_(std::make_shared<core::Mailbox<Loaded>>()),
      referenceBox_(std::make_shared<core::Mailbox<Reference>>()),
      saves_(std::make_shared<SaveQueue>()), loader_("loader", 5), core_("core", 10),
      saver_("saver", 5), renderThread_(options.factory)
{
    notices.quiet = options.quiet;
    render = options.render;
    if (!options.settings.empty()) {
        std::string problem;
        settings = readSettings(options.settings, problem);
        if (!problem.empty()) notices.tell(Severity::warning, problem);
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
        saveNow();
        saver_.wait();
        tellEnds();  // a picture that could not be saved is told even now
        keepPicture();
        keepCameras();
        settings.keepParams(render.method);
        if (options_.uiScale > 0 && settings.panels.uiScale == options_.uiScale)
            settings.panels.uiScale = keptScale_;
        if (!options_.settings.empty()) writeSettings(options_.settings, settings);
    } catch (const std::exception& error) {
        notices.tell(Severity::warning, error.what());
    }
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
    takePicture();
    judge();
    order(pictureArea);
    if (document_ && !track.playing() && !player.playing)
        history_.observe(navigation.viewpoint(), now_);
    lookAround();
}

bool Session::busy() const
{
    const RenderThreadStatus rendering = renderThread_.status();
    return rendering.rendering || judge_.busy() || loader_.status().active() ||
           core_.status().active() || saver_.status().active() || track.playing() ||
           player.playing || isMoving() || equalTime_.running() || pendingSave_.has_value() ||
           pendingReference_.has_value() || unsettled_ || hasNews() ||
           (referenceKeySeconds > 0 && !holdReference);
}

bool Session::hasNews() const
{
    return renderThread_.newest() != picture_;
}

void Session::cancel()
{
    if (loader_.status().active()) loader_.cancel();
    if (core_.status().active()) core_.cancel();
    if (equalTime_.running()) equalTime_.cancel();
    if (track.playing()) track.stop();
}

/// Failures of the threads, each told once.
void Session::tellEnds()
{
    const auto tell = [this](const core::JobStatus& job, uint64_t& told) {
        if (job.active() || job.generation == told || job.state == core::JobState::idle) return;
        told = job.generation;
        if (job.state == core::JobState::failed) notices.tell(Severity::error, job.error);
        if (job.state == core::JobState::cancelled)
            notices.tell(Severity::news, job.name + ": cancelled");
        if (job.state == core::JobState::done && job.name.starts_with("export"))
            notices.tell(Severity::news,
                         job.name + ": done, in " +
                             fs::path(wholePath(exportPattern_)).parent_path().string(),
                         exportPattern_);
    };
    tell(loader_.status(), toldLoader_);
    // Something to look at behind the message.
    if (options_.builtIn && !document_ && loader_.status().state == core::JobState::failed) {
        options_.builtIn = false;
        load(defaultScene());
    }
    tell(core_.status(), toldCore_);
    tell(saver_.status(), toldSaver_);
    for (const auto& [failed, text, file] : saves_->takeTold()) {
        notices.tell(failed ? Severity::error : Severity::news, text, file);
        if (failed) savedSeconds_ = 0;
    }
    const RenderThreadStatus rendering = renderThread_.status();
    if (rendering.errorCount != toldRendering_) {
        toldRendering_ = rendering.errorCount;
        if (!rendering.error.empty()) notices.tell(Severity::error, rendering.error);
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
        picture_ = newest;
        if (picture_->seconds < savedSeconds_) savedSeconds_ = 0;  // it began anew
        // One of the scene before is of no view that there is.
        if (document_ && picture_->world.lock() == document_->world)
            convergence_.take(*picture_, sceneName());
        if (equalTime_.running()) takeEqualTime();
    }
    if (pendingReference_ && picture_) takeReferencePicture();
    if (pendingSave_ && picture_) {
        // Whole samples only: what is saved can be rendered again to the bit.
        const bool whole = !picture_->preview && picture_->fraction == 0;
        const bool complete = whole && picture_->generation >= generation_ && picture_->variance;
        if (complete || (now_ >= pendingSave_->until && whole)) saveNow();
    }
}

/// Hands the save that waits to its thread, which finishes it even when the program ends.
void Session::saveNow()
{
    if (!pendingSave_ || !picture_ || !document_) return;
    saves_->add({pendingSave_->file, picture_, document_->world, document_->file, document_->time,
                 settings.view});
    saver_.start("save", saves_->job());
    savedSeconds_ = picture_->seconds;
    pendingSave_.reset();
}

void Session::save(const fs::path& file)
{
    if (!document_ || !picture_) {
        notices.tell(Severity::error, file.string() + ": there is no picture to save yet");
        return;
    }
    pendingSave_ = PendingSave{file, now_ + kSaveSeconds};
}

core::Metadata Session::pictureMetadata() const
{
    if (!document_ || !picture_ || picture_->world.lock() != document_->world) return {};
    return viewMetadata(*picture_, *document_->world, document_->file, document_->time);
}

double Session::unsavedSeconds() const
{
    return picture_ && !picture_->preview ? picture_->seconds - savedSeconds_ : 0;
}

void Session::restart()
{
    ++restarts_;
}

glm::uvec2 Session::pictureSize(glm::uvec2 area)
{
    // While a window's edge is dragged its size changes with every frame: the picture waits until
    // it settles.
    if (area != area_) {
        area_ = area;
        areaSince_ = now_;
    }
    unsettled_ = now_ - areaSince_ < kSettlingSeconds;
    if (fixedSize_.x > 0) return fixedSize_;
    if (unsettled_ && ordered_.size.x > 0) return ordered_.size;
    const double scale = static_cast<double>(std::clamp(settings.view.pictureScale, 0.1f, 2.0f));
    return glm::max(glm::uvec2(glm::round(glm::dvec2(area) * scale)), glm::uvec2(kLeastSide));
}

void Session::order(glm::uvec2 pictureArea)
{
    const glm::uvec2 size = pictureSize(pictureArea);
    if (!document_ || pictureArea.x == 0 || pictureArea.y == 0) return;
    navigation.setAspect(static_cast<double>(size.x) / size.y);
    RenderRequest wanted;
    wanted.world = document_->world;
    wanted.camera = navigation.view();
    wanted.size = size;
    wanted.params = equalTime_.running() ? equalTime_.wanted() : render;
    wanted.validation = options_.validation;
    wanted.restarts = restarts_;
    wanted.moving = isMoving() && !equalTime_.running();
    wanted.paused = paused && !equalTime_.running();
    wanted.targetFrameSeconds = 1.0 / static_cast<double>(std::max(settings.view.movingRate, 1.0f));
    wanted.movingDepth = settings.view.movingDepth;
    wanted.movingShows = settings.view.moving;
    wanted.wantVariance = wantsVariance();
    wanted.wantAovs = inspecting || pendingSave_.has_value() ||
                      (settings.view.show >= Show::depth && settings.view.show <= Show::emitter);
    wanted.wantMaps = settings.view.show == Show::methodMap;
    if (referenceFits(wanted)) wanted.reference = reference_;
    if (generation_ != 0 && wanted == ordered_) return;
    ordered_ = wanted;
    generation_ = renderThread_.request(std::move(wanted));
}

}  // namespace app
