// Checks, loads, renders frame by frame, writes. See render_command.h.
#include "app/commands/render_command.h"

#include <algorithm>
#include <memory>

#include "app/base/interrupt.h"
#include "app/base/log.h"
#include "app/base/user_folders.h"
#include "app/commands/frame_budget.h"
#include "app/commands/render_files.h"
#include "app/commands/render_loop.h"
#include "app/commands/render_words.h"
#include "app/commands/stored_picture.h"
#include "app/files/load.h"
#include "app/files/picture_file.h"
#include "app/files/picture_layers.h"
#include "app/files/stats.h"
#include "app/gpu/base/device.h"
#include "core/base/check.h"
#include "core/base/output_file.h"
#include "core/base/time.h"
#include "core/image/metrics.h"
#include "core/scene/features.h"

namespace app {

namespace {

using core::Clock, core::secondsSince;

constexpr uint64_t kDefaultSpp = 64;
constexpr double kMaxKeepSeconds = 10;  // between copies of the film; at first a second

uint32_t forcedFeatures(const RenderOptions& o)
{
    uint32_t bits = 0;
    for (const std::string& name : o.noSkip) bits |= core::featureBit(name);
    return bits;
}

/// One render command at work.
class Job {
public:
    Job(const RenderOptions& options, const PathMaker& makePath, const RendererMaker& makeRenderer)
        : o_(options), makePath_(makePath), makeRenderer_(makeRenderer), log_(options.quiet)
    {}

    int run();

private:
    void prepare();
    void tellWarnings(const core::World& world, const std::string& when);
    void takeWorld();
    void poseFor(uint32_t index);
    Ended renderFrame(uint32_t index);
    Outcome takeSamples(uint32_t index);
    void readReference();
    void checkReference() const;
    void setGoal();
    void fitBudget();
    void countOverBudget();
    bool follows(uint32_t index) const { return o_.frames && index > o_.frames->first; }
    void report(uint32_t index, const Outcome& outcome);
    void save(uint32_t index, const core::Estimate& estimate, core::Aovs* aovs,
              std::vector<core::Layer> maps);
    std::vector<core::Layer> mapLayers();
    [[noreturn]] void saveLost(uint32_t index, const core::Error& error);

    RenderOptions o_;  // as given, but for what a budget makes of the parameters
    const PathMaker& makePath_;
    const RendererMaker& makeRenderer_;
    const Clock::time_point start_ = Clock::now();
    Interrupt interrupt_;  // before anything that starts threads
    Log log_;
    RenderReport report_;
    ToldWarnings warnings_;
    std::unique_ptr<core::Renderer> renderer_;
    std::optional<CameraPath> path_;
    core::Image reference_;
    Goal goal_;
    uint32_t forced_ = 0;        // features that are compiled in though nothing needs them
    double prepareSeconds_ = 0;  // counted against the time limit of the first frame
    core::Estimate kept_;        // copied from the device now and then, in case it is lost
    double keptAt_ = 0;
    uint64_t raysBefore_ = 0, pathsBefore_ = 0;  // of the frame
};

void Job::prepare()
{
    checkFiles(o_);
    if (hasExtension(o_.output, ".exr") && (o_.exposure != 0 || o_.tone != RenderOptions().tone))
        log_.line("--exposure and --tone are for PNG files: an EXR holds the radiance as it is");
    forced_ = forcedFeatures(o_);
    if (!o_.reference.empty()) readReference();
    const Clock::time_point opening = Clock::now();
    renderer_ = makeRenderer_();
    report_.deviceSeconds = secondsSince(opening);
    const LoadedWorld loaded = loadWorld(o_.scene, forced_, log_.callback());
    o_.scene.file = loaded.file;
    tellWarnings(*loaded.world, "");
    if (!loaded.note.empty()) log_.warning(o_.scene.file.string() + ": " + loaded.note);
    report_.options = &o_;
    report_.world = loaded.world;
    report_.loadSeconds = loaded.seconds;
    report_.time = o_.scene.at;
    if (o_.frames && !makePath_ && loaded.world->scene->animations.empty())
        throw core::Error(o_.scene.file.string() +
                              ": has no animation — --frames needs --path FILE.json",
                          core::ExitCode::commandLine);
    report_.camera = chooseCamera(*loaded.world, o_.camera);
    if (makePath_) {
        path_ = makePath_(*loaded.world);
        report_.camera = path_->at(o_.frames->first);
    }
    if (report_.camera.orthographic && report_.camera.apertureRadius > 0)
        log_.warning("the camera's aperture_radius is ignored: an orthographic camera (ymag) has "
                     "no lens");
    report_.size = o_.size ? *o_.size : core::sizeForWidth(report_.camera, o_.width);
    checkReference();
    requireMemoryFor(report_.size);
    log_.line(o_.scene.file.string() + ": " + std::to_string(core::shownTriangles(*loaded.world)) +
              " triangles, loaded in " + printedNumber("%.2f s", loaded.seconds));

    const Clock::time_point start = Clock::now();
    takeWorld();
    prepareSeconds_ = secondsSince(start);
    setGoal();
}

/// What is known of a flight when it has begun is not all: meshes may vanish later.
void Job::tellWarnings(const core::World& world, const std::string& when)
{
    for (const std::string& line : warnings_.add(world.warnings))
        log_.warning(o_.scene.file.string() + ": " + when + line);
    report_.warnings = warnings_.total();
}

void Job::takeWorld()
{
    renderer_->setWorld(report_.world, log_.callback());
    renderer_->prepare(o_.params, log_.callback());
    report_.buildSeconds += renderer_->stats().buildSeconds;
}

void Job::setGoal()
{
    const bool limited =
        o_.timeSeconds || o_.untilRmse || o_.untilNoise || o_.budgetMs || o_.budgetRays;
    goal_.spp = o_.spp.value_or(limited ? kMaxSpp : kDefaultSpp);
    goal_.rmse = o_.untilRmse.value_or(0);
    goal_.noise = o_.untilNoise.value_or(0);
    goal_.reference = o_.untilRmse ? &reference_ : nullptr;
    goal_.budgetRays = o_.budgetRays.value_or(0) * report_.size.x * report_.size.y;
    if (o_.budgetRays) fitBudget();
}

/// The first, the middle and the last view are tried: the parameters stay for the whole flight,
/// since what is kept depends on them.
void Job::fitBudget()
{
    const FrameRange frames = o_.frames.value_or(FrameRange{});
    std::vector<uint32_t> indices{frames.first, frames.first + (frames.last - frames.first) / 2,
                                  frames.last};
    indices.erase(std::unique(indices.begin(), indices.end()), indices.end());
    const auto viewOf = [&](size_t i) {
        poseFor(indices[i]);
        return core::View{report_.camera, report_.size, o_.params};
    };
    const std::string said = fitRays(*renderer_, indices.size(), viewOf, *o_.budgetRays, o_.params);
    if (!said.empty()) log_.line(said);
}

/// One sample may be more than there is room for.
void Job::countOverBudget()
{
    constexpr double kRoom = 1.1;  // times are never quite what was expected
    const FrameReport& frame = report_.frames.back();
    const bool slow = goal_.budgetSeconds > 0 && frame.seconds > kRoom * goal_.budgetSeconds;
    const bool many =
        goal_.budgetRays > 0 && static_cast<double>(frame.rays) > kRoom * goal_.budgetRays;
    if (slow || many) ++report_.overBudget;
}

/// Against a noisy reference no error falls below its noise.
void Job::readReference()
{
    const core::ImageFile content = core::readExr(o_.reference);
    reference_ = rgbOf(content, o_.reference);
    const std::optional<StoredNoise> noise = storedNoise(content);
    if (!noise) return;
    report_.referenceNoise = noise->rmse;
    if (o_.untilRmse && *o_.untilRmse <= noise->rmse)
        log_.warning(o_.reference.string() + ": its own noise is " +
                     printedNumber("%.4g", noise->rmse) +
                     (noise->isBound ? " (at most: Sobol samples)" : "") + ": --until-rmse " +
                     printedNumber("%.4g", *o_.untilRmse) +
                     " may never be reached — give a larger one or a reference of more samples");
}

void Job::checkReference() const
{
    if (o_.reference.empty()) return;
    const glm::uvec2 other(reference_.width, reference_.height);
    if (other == report_.size) return;
    const auto text = [](glm::uvec2 size) {
        return std::to_string(size.x) + 'x' + std::to_string(size.y);
    };
    throw core::Error(o_.reference.string() + ": is " + text(other) + ", the picture is " +
                      text(report_.size) + " — give --size " + text(other) +
                      " or another reference");
}

void Job::report(uint32_t index, const Outcome& outcome)
{
    constexpr const char* kNames[] = {"spp", "time", "target", "interrupted", "budget"};
    report_.renderer = renderer_->stats();
    report_.ended = kNames[static_cast<size_t>(outcome.ended)];
    report_.rmse = outcome.rmse;
    report_.noise = outcome.noise;
    report_.frames.push_back(
        {index,
         outcome.seconds,
         report_.renderer.rays - raysBefore_,
         report_.renderer.paths - pathsBefore_,
         outcome.samples,
         follows(index) && core::methodNamed(o_.params.id()).traits.keepsOnMove,
         report_.renderer.details,
         {}});
}

Outcome Job::takeSamples(uint32_t index)
{
    kept_.samples = 0;
    keptAt_ = 0;
    try {
        return renderUntil(*renderer_, goal_, interrupt_.token(), [this](const Outcome& soFar) {
            log_.progressText(progressText(report_, goal_, soFar));
            const double seconds = soFar.seconds;
            if (seconds - keptAt_ < std::clamp(keptAt_, 1.0, kMaxKeepSeconds)) return;
            kept_ = renderer_->read(core::Reading::everything);
            keptAt_ = seconds;
        });
    } catch (const core::Error& error) {
        // The one failure that leaves something to save: a device that was lost after a copy of its
        // film was taken.
        if (error.code() != core::ExitCode::deviceLost || kept_.samples == 0) throw;
        saveLost(index, error);
    }
}

void Job::saveLost(uint32_t index, const core::Error& error)
{
    report(index, {Ended::stopped, kept_.samples, keptAt_, {}, {}});
    report_.ended = "device lost";
    save(index, kept_, nullptr, {});  // the device can tell nothing more
    report_.totalSeconds = secondsSince(start_);
    if (!o_.stats.empty()) core::writeFile(o_.stats, statsJson(report_));
    throw core::Error(std::string(error.what()) + " — the first " + std::to_string(kept_.samples) +
                          " samples per pixel are saved in " + pictureFile(o_, index).string(),
                      core::ExitCode::deviceLost);
}

void Job::poseFor(uint32_t index)
{
    if (path_) {
        report_.camera = path_->at(index);
        return;
    }
    const double time = o_.scene.at + (o_.frames ? index / o_.framesPerSecond : 0);
    if (time == report_.time) return;
    report_.time = time;
    report_.world = core::poseWorld(report_.world, time);
    const std::string when = printedNumber("at %.4g s: ", time);
    refuseWarnings(report_.world->warnings, o_.scene, o_.scene.file, when);
    tellWarnings(*report_.world, when);
    // The camera of a scene that has none frames what is seen at first. If it framed every pose
    // anew, what moves would seem to rest while the camera moves.
    if (!report_.world->scene->cameras.empty())
        report_.camera = chooseCamera(*report_.world, o_.camera);
    takeWorld();
}

Ended Job::renderFrame(uint32_t index)
{
    const Clock::time_point start = Clock::now();
    poseFor(index);
    // A frame follows on the one before: methods that keep samples go on with them.
    renderer_->setView({report_.camera, report_.size, o_.params},
                       follows(index) ? core::Start::moved : core::Start::anew);
    const double readBefore = renderer_->stats().readbackSeconds;
    raysBefore_ = renderer_->stats().rays;
    pathsBefore_ = renderer_->stats().paths;
    prepareSeconds_ += secondsSince(start);
    report_.prepareSeconds += prepareSeconds_;
    // What is left of the time after preparation; never zero, which would mean no limit.
    goal_.seconds = o_.timeSeconds ? std::max(*o_.timeSeconds - prepareSeconds_, 1e-9) : 0;
    if (o_.budgetMs) {
        // Of the first frame compiling is a part, which says nothing of those that follow.
        const double spent = follows(index) ? prepareSeconds_ : 0;
        goal_.budgetSeconds = std::max(*o_.budgetMs * 1e-3 - spent, 1e-9);
    }
    prepareSeconds_ = 0;
    interrupt_.keepResult(true);
    const Outcome outcome = takeSamples(index);
    report(index, outcome);
    if (outcome.samples > 0 && !o_.stats.empty())
        report_.frames.back().means = mapMeans(*renderer_, o_.params.id());
    countOverBudget();
    if (outcome.samples > 0) {
        const core::Estimate estimate = renderer_->read(core::Reading::everything);
        core::Aovs aovs;
        if (o_.aovs.firstHits()) aovs = renderer_->aovs();
        aovs.depth = inMetres(std::move(aovs.depth), *report_.world);
        save(index, estimate, o_.aovs.any() ? &aovs : nullptr, mapLayers());
    }
    report_.readbackSeconds += renderer_->stats().readbackSeconds - readBefore;
    return outcome.ended;
}

std::vector<core::Layer> Job::mapLayers()
{
    std::vector<core::Layer> maps;
    if (!o_.aovs.maps) return maps;
    std::vector<core::Image> images = renderer_->maps();
    const auto infos = core::methodNamed(o_.params.id()).maps;
    for (size_t i = 0; i < images.size(); ++i)
        maps.push_back({std::string("map.") + infos[i].name, std::move(images[i])});
    return maps;
}

void Job::save(uint32_t index, const core::Estimate& estimate, core::Aovs* aovs,
               std::vector<core::Layer> maps)
{
    report_.counters += estimate.counters;
    if (!o_.reference.empty()) report_.rmse = core::imageErrors(estimate.mean, reference_).rmse;
    const std::filesystem::path file = pictureFile(o_, index);
    writePicture(file, estimate, aovs, std::move(maps), o_, imageMetadata(report_));
    const std::string text = savedText(report_, file);
    // One line per frame would be too many.
    if (o_.frames)
        log_.progressText(text);
    else
        log_.line(text);
}

int Job::run()
{
    prepare();
    Ended ended = Ended::spp;
    const bool hasTarget = o_.untilRmse || o_.untilNoise;
    MissedFrames missed;
    const FrameRange frames = o_.frames.value_or(FrameRange{});
    for (uint32_t index = frames.first; index <= frames.last && ended != Ended::stopped; ++index) {
        ended = renderFrame(index);
        if (hasTarget && ended != Ended::target) missed.add(report_);
    }
    report_.renderer = renderer_->stats();
    report_.totalSeconds = secondsSince(start_);
    report_.validationMessages = o_.validation ? gpu::validationMessages() : 0;
    if (!o_.stats.empty()) core::writeFile(o_.stats, statsJson(report_));
    if (const std::string text = overBudgetText(report_); !text.empty()) log_.line(text);

    const core::FilmCounters& c = report_.counters;
    if (!c.clean())
        log_.warning("samples dropped: " + std::to_string(c.nan) + " NaN, " +
                     std::to_string(c.inf) + " infinite, " + std::to_string(c.negative) +
                     " negative; rays cut short: " + std::to_string(c.stackOverflow));
    if (report_.validationMessages > 0)
        log_.warning(std::to_string(report_.validationMessages) +
                     " messages of the Vulkan validation layer");
    if (ended == Ended::stopped) {
        log_.warning(interruptedText(report_));
        return static_cast<int>(core::ExitCode::interrupted);
    }
    if (missed.count > 0) {
        log_.warning(missedText(report_, missed));
        return static_cast<int>(core::ExitCode::targetNotReached);
    }
    return static_cast<int>(core::ExitCode::done);
}

}  // namespace

int renderWith(const RenderOptions& options, const PathMaker& makePath,
               const RendererMaker& makeRenderer)
{
    CHECK(!makePath || options.frames);
    return Job(options, makePath, makeRenderer).run();
}

int renderFrames(const RenderOptions& options, const PathMaker& makePath)
{
    return renderWith(options, makePath, [&options] {
        return makeRenderer(
            options.params.id(),
            {.device = options.device,
             .deviceIndex = options.deviceIndex,
             .validation = options.validation,
             .cacheFolder = options.noCache ? std::filesystem::path() : userCacheFolder()});
    });
}

int renderCommand(const RenderOptions& options)
{
    if (options.path.empty()) return renderFrames(options, {});
    return renderFrames(options, [&options](const core::World& world) {
        return readCameraPath(options.path, chooseCamera(world, options.camera), world.placement);
    });
}

}  // namespace app
