// The session's cameras: the scene's, the saved ones, those that come and go as text. See
// session.h.
#include "app/files/camera_file.h"

#include "app/base/json_file.h"
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
    sceneCamera_ = index;  // an animated one carries the view along, until it is moved by hand
    followed_ = document_->world->cameras[index];
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
    if (index < savedCameras_.size()) takeCamera(savedCameras_[index].camera);
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

void Session::focusAt(glm::dvec2 position)
{
    if (!document_ || ordered_.size.x == 0) return;
    const auto picked = core::pick(*document_->world, navigation.camera(), ordered_.size, position);
    if (!picked) return;
    navigation.setPivot(picked->position);
}

void Session::frameScene()
{
    if (!document_) return;
    const core::World& world = *document_->world;
    const glm::dvec3 low(world.boundsLow), high(world.boundsHigh);
    navigation.frame(0.5 * (low + high), std::max(0.5 * glm::length(high - low), 1e-6));
    moved();
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
