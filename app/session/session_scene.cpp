// The scene of a Session: loading and replaying, what a scene that has come changes, its instants.
#include <algorithm>
#include <cmath>
#include <utility>

#include <nlohmann/json.hpp>

#include "app/files/camera_file.h"
#include "app/report/text.h"
#include "app/session/replay.h"
#include "app/session/session.h"
#include "app/session/session_jobs.h"
#include "core/base/check.h"

namespace app {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

std::string loadTimeText(double seconds)
{
    return seconds < 0.1 ? report::fixedNumber(1000 * seconds, 0) + " ms"
                         : report::shortNumber(seconds) + " s";
}

}  // namespace

void Session::load(const fs::path& file)
{
    SceneOptions scene = options_.scene;
    scene.file = file;
    scene.at = 0;
    load(scene);
}

void Session::load(const SceneOptions& scene)
{
    pendingReplay_.reset();
    sameScene_ = false;
    startLoading(scene);
}

void Session::setEnvironment(const std::string& what)
{
    if (!document_) return;
    SceneOptions scene = options_.scene;
    scene.file = document_->file;
    scene.at = document_->time;
    scene.load.environment = what;
    load(scene);
    sameScene_ = true;
}

void Session::startLoading(const SceneOptions& scene)
{
    loadGeneration_ =
        loader_.start("load " + scene.file.filename().string(), loadJob(scene, loadedBox_));
}

void Session::replay(const fs::path& picture)
{
    try {
        Replay found = readReplay(picture);
        SceneOptions scene = options_.scene;
        scene.file = found.scene;
        scene.at = found.at;
        scene.laidOutAt = found.laidOutAt;
        if (!found.environment.empty()) scene.load.environment = found.environment;
        load(scene);
        pendingReplay_ = std::make_unique<Replay>(std::move(found));
    } catch (const core::Error& error) {
        notices.tell(Severity::error, error.what());
        if (!loader_.status().active()) showBuiltIn();
    }
}

bool Session::settled() const
{
    const bool waits = loadGeneration_ != takenLoad_ && loadedBox_->get(loadGeneration_);
    return document_ && !loader_.status().active() && !waits;
}

void Session::takeLoaded()
{
    const std::shared_ptr<const Loaded> loaded = loadedBox_->get(loadGeneration_);
    if (!loaded || loadGeneration_ == takenLoad_) return;
    takenLoad_ = loadGeneration_;
    if (loaded->pose && document_) {
        document_->world = loaded->document.world;
        document_->time = loaded->document.time;
        followSceneCamera();
        if (player.playing) movedAt_ = now_;
        return;
    }
    show(loaded->document);
}

void Session::show(const Document& document)
{
    keepPicture();
    endSaves("the scene changed");
    keepCameras();
    const bool stays = std::exchange(sameScene_, false) && document_ &&
                       document_->world->scene->fileHash == document.world->scene->fileHash;
    document_ = std::make_unique<Document>(document);
    options_.scene.load.environment = document.environment;  // which could be had
    dropReference();
    equalTime_.cancel();
    slots = {};
    comparing = false;
    metered_ = stays;
    if (!stays) enter();
    if (!options_.settings.empty()) settings.addRecent(document_->file);
    notices.tell(Severity::news,
                 document_->file.filename().string() + ": " +
                     report::counted(core::shownTriangles(*document_->world), "triangle") +
                     ", loaded in " + loadTimeText(document_->loadSeconds));
    for (const std::string& line : document_->warnings) notices.tell(Severity::warning, line);
    if (pendingReplay_) applyReplay();
}

/// What belongs to a scene and not to its light: where one stands in it, its paths, its animation.
void Session::enter()
{
    const core::World& world = *document_->world;
    track.clear();
    player = {};
    player.time = document_->time;
    player.duration =
        world.scene->animations.empty() ? 0 : world.scene->animations.front().duration;
    homeCamera_ = 0;
    history_.clear();
    try {
        beginAt(chooseCamera(world, options_.camera));
    } catch (const core::Error& error) {
        notices.tell(Severity::error, error.what());
        beginAt(world.cameras.front());
    }
    history_.settle(navigation.viewpoint());  // also when it is left at once
    loadFirstPath();
    options_.camera.clear();  // was meant for the first scene
    recallCameras();
}

/// One of the scene's own cameras is followed when it is animated; any other stays where it is.
void Session::beginAt(const core::Camera& camera)
{
    const std::vector<core::Camera>& cameras = document_->world->cameras;
    const auto own = std::find(cameras.begin(), cameras.end(), camera);
    if (own != cameras.end()) {
        followCamera(static_cast<size_t>(own - cameras.begin()));
    } else {
        takeCamera(camera);
        home_ = camera;
    }
}

/// How the scene looks that is about to go, for the list of those that were open before.
void Session::keepPicture()
{
    if (!document_ || !picture_ || options_.settings.empty()) return;
    const bool ofIt = picture_->world.lock() == document_->world;
    if (ofIt && !picture_->shaded && picture_->samples > 0)
        pictures_.keep(document_->file, smallPicture(picture_->mean, settings.view));
}

void Session::loadFirstPath()
{
    if (options_.path.empty()) return;
    try {
        track.load(options_.path, navigation.camera(), document_->world->placement);
    } catch (const core::Error& error) {
        notices.tell(Severity::error, error.what());
    }
    options_.path.clear();
}

void Session::applyReplay()
{
    const Replay replay = std::move(*pendingReplay_);
    pendingReplay_.reset();
    if (!replay.sceneHash.empty() && replay.sceneHash != document_->world->scene->hash)
        notices.tell(
            Severity::warning,
            document_->file.string() +
                ": is not the scene that the picture was made of (its hash differs): the view "
                "is the same, the picture may not be");
    if (replay.follows)
        notices.tell(Severity::warning,
                     "the saved picture began with what the views before it had left: it comes out "
                     "with the same light, but not with the same noise");
    chooseParams(replay.params);
    if (render.device != replay.device) {
        render.device = replay.device;
        render.deviceIndex = -1;
    }
    render.secondsLimit = render.errorLimit = 0;
    if (replay.samples > 0) render.sppLimit = replay.samples;
    fixedSize_ = replay.size;
    try {
        core::Camera camera = cameraFromJson(Json::parse(replay.cameraJson), core::Camera{},
                                             document_->world->placement, "the saved picture");
        // What of a wider frame the picture does not show is left out again.
        camera.aspect = std::min(camera.aspect, static_cast<double>(replay.size.x) / replay.size.y);
        navigation.set(camera, static_cast<double>(document_->world->radius));
        sceneCamera_.reset();
    } catch (const std::exception& error) {
        notices.tell(Severity::error, error.what());
    }
}

void Session::animate(double seconds)
{
    if (track.playing() && track.advance(seconds)) {
        takeCamera(track.at(track.frame()));
        movedAt_ = now_;
    }
    if (!document_ || player.duration <= 0) return;
    if (player.playing) {
        player.time += seconds * player.speed;
        if (player.time >= player.duration) {
            player.time = player.loop ? std::fmod(player.time, player.duration) : player.duration;
            player.playing = player.loop;
        }
        player.time = std::max(player.time, 0.0);
    }
    if (player.time == document_->time || loader_.status().active()) return;
    // A scene that has come since takeLoaded() is not to be passed over for a pose of the old one.
    if (loadGeneration_ != takenLoad_ && loadedBox_->get(loadGeneration_)) return;
    loadGeneration_ = loader_.start(kPoseJob, poseJob(*document_, player.time, loadedBox_));
}

void Session::followSceneCamera()
{
    const std::vector<core::Camera>& cameras = document_->world->cameras;
    if (sceneCamera_ && *sceneCamera_ < cameras.size() && cameras[*sceneCamera_] != followed_)
        followCamera(*sceneCamera_);
}

}  // namespace app
