// The session's cameras: the scene's, the saved ones, those that come and go as text. See
// session.h.
#include <algorithm>

#include "app/files/camera_file.h"

#include "app/base/json_file.h"
#include "app/camera/surroundings.h"
#include "app/session/session.h"
#include "core/base/check.h"
#include "core/trace/pick.h"
#include <nlohmann/json.hpp>

namespace app {

using Json = nlohmann::ordered_json;

void Session::moved()
{
    movedAt_ = now_;
    fixedSize_ = {};
    sceneCamera_.reset();
    track.stop();
}

/// A camera from elsewhere, at once.
void Session::takeCamera(const core::Camera& camera)
{
    if (!document_) return;
    navigation.set(camera, static_cast<double>(document_->world->radius));
    toldOfWall_ = false;
    sceneCamera_.reset();
    fixedSize_ = {};
}

void Session::useSceneCamera(size_t index)
{
    track.stop();
    followCamera(index);
}

void Session::followCamera(size_t index)
{
    if (!document_ || index >= document_->world->cameras.size()) return;
    takeCamera(document_->world->cameras[index]);
    homeCamera_ = index;
    home_.reset();
    sceneCamera_ = index;  // an animated one carries the view along, until it is moved by hand
    followed_ = document_->world->cameras[index];
}

core::Camera Session::homeCamera() const
{
    const std::vector<core::Camera>& cameras = document_->world->cameras;
    return home_ ? *home_ : cameras[std::min(homeCamera_, cameras.size() - 1)];
}

void Session::goHome()
{
    if (!document_) return;
    history_.settle(navigation.viewpoint());
    track.stop();
    if (home_)
        takeCamera(*home_);
    else
        useSceneCamera(homeCamera_);
}

void Session::goTo(const std::optional<Viewpoint>& viewpoint)
{
    if (!viewpoint) {
        notices.tell(Severity::news, "there is no other view to go to");
        return;
    }
    track.stop();
    navigation.go(*viewpoint);
    toldOfWall_ = false;
    sceneCamera_.reset();
    fixedSize_ = {};
}

void Session::goBack()
{
    if (document_) goTo(history_.back(navigation.viewpoint()));
}

void Session::goForward()
{
    if (document_) goTo(history_.forward(navigation.viewpoint()));
}

void Session::saveCamera(const std::string& name)
{
    if (!document_) return;
    SavedCamera saved{name, navigation.camera()};
    if (saved.name.empty()) saved.name = "view " + std::to_string(savedCameras_.size() + 1);
    saved.camera.name = saved.name;
    notices.tell(Severity::news, saved.name + " is kept with the scene");
    savedCameras_.push_back(std::move(saved));
}

void Session::useSavedCamera(size_t index)
{
    if (index >= savedCameras_.size()) return;
    history_.settle(navigation.viewpoint());
    track.stop();
    takeCamera(savedCameras_[index].camera);
}

void Session::removeSavedCamera(size_t index)
{
    if (index < savedCameras_.size())
        savedCameras_.erase(savedCameras_.begin() + static_cast<std::ptrdiff_t>(index));
}

std::string Session::cameraText() const
{
    return document_ ? jsonText(cameraJson(navigation.camera(), document_->world->placement))
                     : std::string();
}

void Session::pasteCamera(const std::string& json)
{
    if (!document_) return;
    history_.settle(navigation.viewpoint());
    try {
        const core::Camera camera = cameraFromJson(Json::parse(json), navigation.camera(),
                                                   document_->world->placement, "the clipboard");
        track.stop();
        takeCamera(camera);
    } catch (const Json::exception&) {  // no JSON, or a number beyond all bounds
        notices.tell(Severity::error,
                     "the clipboard: holds no camera — a camera is JSON such as " + cameraText());
    } catch (const core::Error& error) {
        notices.tell(Severity::error, error.what());
    }
}

Area Session::placeOf(const Picture& picture) const
{
    const glm::vec2 area(glm::max(area_, glm::uvec2(1)));
    const auto aspect = static_cast<double>(area.x / area.y);
    if (fixedSize_.x > 0 || keepsSize_) return whole(picture.fullSize, area);
    return kept(picture.fullSize, picture.camera, area, framed(navigation.camera(), aspect));
}

Area Session::placeOf(glm::uvec2 size) const
{
    return whole(size, glm::vec2(glm::max(area_, glm::uvec2(1))));
}

/// From [0,1]^2 of the area to that of the picture, which may have another shape.
glm::dvec2 Session::inPicture(glm::dvec2 position) const
{
    const Area place = placeOf(ordered_.size);
    return (position - glm::dvec2(place.corner)) / glm::dvec2(place.size);
}

void Session::focusAt(glm::dvec2 position)
{
    if (!document_ || ordered_.size.x == 0) return;
    const glm::dvec2 at = inPicture(position);
    seek("focus",
         [world = document_->world, view = navigation.view(), size = ordered_.size,
          at](const std::stop_token&) -> Found {
             const auto picked = core::pick(*world, view, size, at);
             return picked ? std::optional(picked->position) : std::nullopt;
         });
}

/// Empty where walls do not stop the camera. A drag waits for nothing: where a ray takes longer
/// than a frame it goes on, and one is told afterwards what has been gone through.
Reach Session::reach() const
{
    constexpr size_t kRays = 2;  // of one motion
    if (settings.view.walls == Walls::pass || insideSolid_ || navigation.camera().orthographic ||
        !quickToLook(*document_->world, kRays))
        return {};
    return [&world = *document_->world](const glm::dvec3& from, const glm::dvec3& to) {
        return freeShare(world, from, to, wallMargin(world));
    };
}

void Session::noteStop(bool stopped)
{
    if (!stopped || std::exchange(toldOfStop_, true)) return;
    notices.tell(Severity::news,
                 "a wall stops the camera, which turns on the spot; G flies through it, and View, "
                 "walls: pass lets all motions through");
}

void Session::orbit(glm::dvec2 drag)
{
    if (document_) noteStop(navigation.orbit(drag.x, drag.y, reach()));
}

void Session::pan(glm::dvec2 drag)
{
    if (document_) noteStop(navigation.pan(drag.x, drag.y, reach()));
}

void Session::dolly(double steps, glm::dvec2 position)
{
    if (!document_ || ordered_.size.x == 0) return;
    // What is ahead is approached and never reached.
    const Reach back = steps < 0 ? reach() : Reach();
    if (settings.view.wheel == Wheel::pivot) {
        noteStop(navigation.dolly(steps, back));
    } else {
        const glm::dvec2 at = inPicture(position);
        // A wheel that turns waits for nothing: what would take longer than a frame is not looked
        // for.
        const auto picked =
            quickToLook(*document_->world)
                ? core::pick(*document_->world, navigation.view(), ordered_.size, at)
                : std::nullopt;
        noteStop(
            navigation.dollyTo(picked ? picked->position : navigation.pointAt(at), steps, back));
    }
    moved();
}

void Session::frameScene()
{
    if (!document_) return;
    history_.settle(navigation.viewpoint());
    seek("frame",
         [world = document_->world, camera = navigation.camera(),
          distance = navigation.framingDistance(1)](const std::stop_token& stop) -> Found {
             return standpointInRoom(*world, camera, distance, stop);
         });
}

/// At once where that is quick, else by the lookout, unless the camera moves before. What that was
/// at it begins again afterwards.
void Session::seek(const char* name, const std::function<Found(std::stop_token)>& find)
{
    if (quickToLook(*document_->world)) return take(find({}));
    soughtFrom_ = navigation.camera();
    looking_ = 0;
    probedWorld_.reset();
    seeking_ = lookout_.start(name, [find, box = foundBox_](core::JobContext& job) {
        box->publish(job.generation(), std::make_shared<const Found>(find(job.stop())));
    });
}

void Session::take(const Found& found)
{
    if (const auto* standpoint = std::get_if<std::optional<Standpoint>>(&found))
        stand(*standpoint);
    else if (const auto& point = std::get<std::optional<glm::dvec3>>(found))
        navigation.setPivot(*point);
}

/// In a room, or before the whole scene.
void Session::stand(const std::optional<Standpoint>& standpoint)
{
    if (standpoint) {
        navigation.stand(standpoint->position, standpoint->target);
    } else {
        const core::World& world = *document_->world;
        const glm::dvec3 low(world.boundsLow), high(world.boundsHigh);
        navigation.frame(0.5 * (low + high), std::max(0.5 * glm::length(high - low), 1e-6));
    }
    moved();
}

/// What rays have found out that took longer than a frame.
void Session::takeLookout()
{
    if (seeking_ != 0 && navigation.camera() != soughtFrom_) seeking_ = 0;  // it has moved on
    if (seeking_ != 0)
        if (const auto found = foundBox_->get(seeking_)) {
            seeking_ = 0;
            take(*found);
        }
    if (looking_ != 0)
        if (const auto found = aroundBox_->get(looking_)) {
            looking_ = 0;
            learn(*found);
        }
}

/// Of a wall that was gone through one is told once, until the camera is put elsewhere. Inside of
/// something the status line tells. The way is done with but where the camera has moved on.
void Session::learn(const LookedAround& found)
{
    const bool wasInside = std::exchange(insideSolid_, found.inside);
    if (navigation.camera().position == probedAt_) navigation.beginWay();
    if (!found.through || wasInside || found.inside || std::exchange(toldOfWall_, true)) return;
    notices.tell(Severity::warning,
                 "the camera has gone through a surface: Backspace leads back to the view before");
}

/// Rays are for a camera at rest, once for each place.
void Session::lookAround()
{
    if (!document_) return;
    takeLookout();
    if (isMoving() || track.playing() || player.playing || seeking_ != 0) return;
    const std::shared_ptr<const core::World> world = document_->world;
    const glm::dvec3 eye = navigation.camera().position;
    if (probedWorld_ == world && probedAt_ == eye) return;
    // What an earlier pose of the scene had in the way is not known.
    if (probedWorld_ != world) navigation.beginWay();
    probedWorld_ = world;
    probedAt_ = eye;
    looking_ = 0;
    const auto find = [world, eye, way = navigation.way().points(),
                       orthographic =
                           navigation.camera().orthographic](const std::stop_token& stop) {
        return LookedAround{.inside = app::insideSolid(*world, eye, stop),
                            .through = !orthographic && leadsThrough(*world, way, stop)};
    };
    if (quickToLook(*world)) return learn(find({}));
    insideSolid_ = false;
    looking_ = lookout_.start("look around", [find, box = aroundBox_](core::JobContext& job) {
        const LookedAround found = find(job.stop());
        if (!job.stopped()) box->publish(job.generation(), std::make_shared<LookedAround>(found));
    });
}

/// Saved cameras of the scene go to the settings ...
void Session::keepCameras()
{
    if (!document_) return;
    const std::string& hash = document_->world->scene->fileHash;
    if (savedCameras_.empty() && unreadCameras_.empty()) {
        settings.cameras.erase(hash);
        return;
    }
    Json list = Json::array();
    for (const SavedCamera& saved : savedCameras_)
        list.push_back(cameraJson(saved.camera, document_->world->placement));
    for (const std::string& text : unreadCameras_) list.push_back(Json::parse(text));
    settings.cameras[hash] = jsonText(list);
}

/// ... and come back with it. What cannot be read, as of a newer version, stays there as it is.
void Session::recallCameras()
{
    savedCameras_.clear();
    unreadCameras_.clear();
    const auto kept = settings.cameras.find(document_->world->scene->fileHash);
    if (kept == settings.cameras.end()) return;
    for (const Json& json : parseJson(kept->second, "the settings' cameras")) {
        try {
            const core::Camera camera = cameraFromJson(
                json, core::Camera{}, document_->world->placement, "the settings' cameras");
            savedCameras_.push_back({camera.name, camera});
        } catch (const std::exception& error) {
            unreadCameras_.push_back(jsonText(json));
            notices.tell(Severity::warning,
                         std::string("a kept view cannot be read: ") + error.what());
        }
    }
}

}  // namespace app
