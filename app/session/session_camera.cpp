// The session's cameras: the scene's, the saved ones, those that come and go as text. See
// session.h.
#include <algorithm>

#include "app/files/camera_file.h"

#include "app/base/json_file.h"
#include "app/session/session.h"
#include "app/session/surroundings.h"
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
    equalTime_.cancel();
}

/// A camera from elsewhere, at once.
void Session::takeCamera(const core::Camera& camera)
{
    if (!document_) return;
    navigation.set(camera, static_cast<double>(document_->world->radius));
    sceneCamera_.reset();
    fixedSize_ = {};
}

void Session::useSceneCamera(size_t index)
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
    equalTime_.cancel();
    navigation.go(*viewpoint);
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
    savedCameras_.push_back(std::move(saved));
}

void Session::useSavedCamera(size_t index)
{
    if (index >= savedCameras_.size()) return;
    history_.settle(navigation.viewpoint());
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
        takeCamera(cameraFromJson(Json::parse(json), navigation.camera(),
                                  document_->world->placement, "the clipboard"));
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
    if (fixedSize_.x > 0) return whole(picture.fullSize, area);
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
    const auto picked =
        core::pick(*document_->world, navigation.view(), ordered_.size, inPicture(position));
    if (!picked) return;
    navigation.setPivot(picked->position);
}

void Session::dolly(double steps, glm::dvec2 position)
{
    if (!document_ || ordered_.size.x == 0) return;
    if (settings.view.wheel == Wheel::pivot) {
        navigation.dolly(steps);
    } else {
        const glm::dvec2 at = inPicture(position);
        const auto picked = core::pick(*document_->world, navigation.view(), ordered_.size, at);
        navigation.dollyTo(picked ? picked->position : navigation.pointAt(at), steps);
    }
    moved();
}

void Session::frameScene()
{
    if (!document_) return;
    history_.settle(navigation.viewpoint());
    const core::World& world = *document_->world;
    const glm::dvec3 eye = navigation.camera().position;
    const std::optional<Room> room = roomAround(world, eye);
    if (room && !navigation.camera().orthographic) {
        // Looks at the middle of what is around and steps back from it as far as the wall behind.
        const double ahead = glm::distance(room->middle, eye);
        const glm::dvec3 to =
            ahead > 0.1 * room->radius ? (room->middle - eye) / ahead : navigation.camera().forward;
        const double wanted = navigation.framingDistance(room->radius) - ahead;
        const double wall = distanceAlong(world, eye, -to).value_or(wanted);
        const double step = std::clamp(wanted, 0.0, std::max(wall - 0.1 * room->radius, 0.0));
        navigation.stand(eye - step * to, eye + std::max(ahead, 0.1 * room->radius) * to);
    } else {
        const glm::dvec3 low(world.boundsLow), high(world.boundsHigh);
        navigation.frame(0.5 * (low + high), std::max(0.5 * glm::length(high - low), 1e-6));
    }
    moved();
}

/// Rays are for a camera at rest, once for each place.
void Session::lookAround()
{
    if (!document_ || isMoving() || track.playing() || player.playing) return;
    const glm::dvec3 eye = navigation.camera().position;
    if (probedWorld_ == document_->world && probedAt_ == eye) return;
    probedWorld_ = document_->world;
    probedAt_ = eye;
    insideSolid_ = app::insideSolid(*document_->world, eye);
}

/// Saved cameras of the scene go to the settings ...
void Session::keepCameras()
{
    if (!document_) return;
    const std::string& hash = document_->world->scene->hash;
    if (savedCameras_.empty()) {
        settings.cameras.erase(hash);
        return;
    }
    Json list = Json::array();
    for (const SavedCamera& saved : savedCameras_)
        list.push_back(cameraJson(saved.camera, document_->world->placement));
    settings.cameras[hash] = jsonText(list);
}

/// ... and come back with it.
void Session::recallCameras()
{
    savedCameras_.clear();
    const auto kept = settings.cameras.find(document_->world->scene->hash);
    if (kept == settings.cameras.end()) return;
    try {
        const Json list = Json::parse(kept->second);
        for (const Json& json : list) {
            const core::Camera camera = cameraFromJson(
                json, core::Camera{}, document_->world->placement, "the settings' cameras");
            savedCameras_.push_back({camera.name, camera});
        }
    } catch (const std::exception& error) {
        notices.tell(Severity::warning,
                     std::string("saved cameras cannot be read: ") + error.what());
    }
}

}  // namespace app
