// A camera path under edit. See camera_track.h.
#include "app/camera/camera_track.h"

#include <algorithm>
#include <cmath>

#include "app/base/files.h"
#include "app/base/json_file.h"
#include "core/base/check.h"
#include "core/base/output_file.h"

namespace app {

namespace {

constexpr double kLastFrame = 1e9;  // as in camera_file.cpp
/// Frames per second, as on the command line.
constexpr double kLowestRate = 1e-3, kHighestRate = 1e5;

bool isFrame(double frame)
{
    return frame >= 0 && frame <= kLastFrame;  // false for NaN
}

double saneRate(double framesPerSecond)
{
    return std::isfinite(framesPerSecond) ? std::clamp(framesPerSecond, kLowestRate, kHighestRate)
                                          : 24;
}

}  // namespace

void CameraTrack::add(const core::Camera& camera)
{
    const double step = std::max(1.0, std::round(saneRate(framesPerSecond)));
    addAt(empty() ? 0 : lastFrame() + step, camera);
}

void CameraTrack::addAt(double frame, const core::Camera& camera)
{
    if (!isFrame(frame)) return;
    const auto place =
        std::lower_bound(path_.keys.begin(), path_.keys.end(), frame,
                         [](const CameraPath::Key& key, double f) { return key.frame < f; });
    if (place != path_.keys.end() && place->frame == frame)
        place->camera = camera;
    else
        path_.keys.insert(place, {frame, camera});
    settle();
}

void CameraTrack::remove(size_t index)
{
    if (index >= path_.keys.size()) return;
    path_.keys.erase(path_.keys.begin() + static_cast<std::ptrdiff_t>(index));
    settle();
}

void CameraTrack::replace(size_t index, const core::Camera& camera)
{
    if (index < path_.keys.size()) path_.keys[index].camera = camera;
}

size_t CameraTrack::move(size_t index, double frame)
{
    if (index >= path_.keys.size() || !isFrame(frame)) return index;
    const auto taken = [frame](const CameraPath::Key& key) { return key.frame == frame; };
    if (std::any_of(path_.keys.begin(), path_.keys.end(), taken)) return index;
    const core::Camera camera = path_.keys[index].camera;
    path_.keys.erase(path_.keys.begin() + static_cast<std::ptrdiff_t>(index));
    addAt(frame, camera);
    const auto found = std::find_if(path_.keys.begin(), path_.keys.end(), taken);
    return static_cast<size_t>(found - path_.keys.begin());
}

void CameraTrack::clear()
{
    path_.keys.clear();
    file_.clear();
    saved_ = {};
    settle();
}

double CameraTrack::firstFrame() const
{
    return empty() ? 0 : path_.keys.front().frame;
}

double CameraTrack::lastFrame() const
{
    return empty() ? 0 : path_.keys.back().frame;
}

/// After the keys have changed: the frame stays within them, and one key alone does not play.
void CameraTrack::settle()
{
    frame_ = std::clamp(frame_, firstFrame(), lastFrame());
    if (path_.keys.size() < 2) playing_ = false;
}

void CameraTrack::play()
{
    if (path_.keys.size() < 2) return;
    if (frame_ >= lastFrame()) frame_ = firstFrame();
    playing_ = true;
}

void CameraTrack::seek(double frame)
{
    if (!std::isnan(frame)) frame_ = std::clamp(frame, firstFrame(), lastFrame());
}

bool CameraTrack::advance(double seconds)
{
    if (!playing_ || !(seconds > 0) || !std::isfinite(seconds)) return false;
    const double before = frame_, length = lastFrame() - firstFrame();
    const double now = frame_ + seconds * saneRate(framesPerSecond);
    if (now < lastFrame()) {
        frame_ = now;
    } else if (loop) {
        frame_ = firstFrame() + std::fmod(now - firstFrame(), length);
    } else {
        frame_ = lastFrame();
        playing_ = false;
    }
    return frame_ != before;
}

nlohmann::ordered_json CameraTrack::json(const core::Placement& placement) const
{
    nlohmann::ordered_json keys = nlohmann::ordered_json::array();
    for (const CameraPath::Key& key : path_.keys) {
        nlohmann::ordered_json camera = cameraJson(key.camera, placement);
        camera["frame"] = key.frame;
        keys.push_back(std::move(camera));
    }
    return {{"frames_per_second", saneRate(framesPerSecond)}, {"loop", loop}, {"keys", keys}};
}

void CameraTrack::save(const std::filesystem::path& file, const core::Placement& placement)
{
    if (empty()) throw core::Error(file.string() + ": there are no keys to save");
    core::writeFile(file, jsonText(json(placement), 1) + '\n');
    file_ = file;
    saved_ = kept();
}

bool CameraTrack::unsaved() const
{
    return path_.keys.size() >= 2 && kept() != saved_;
}

void CameraTrack::load(const std::filesystem::path& file, const core::Camera& defaults,
                       const core::Placement& placement)
{
    const nlohmann::ordered_json json = readJson(file);
    CameraPath path = cameraPathFromJson(json, defaults, placement, file.string());
    double rate = framesPerSecond;
    bool wraps = loop;
    if (json.contains("frames_per_second")) {
        const auto& value = json["frames_per_second"];
        rate = value.is_number() ? value.get<double>() : std::nan("");
        if (!(rate >= kLowestRate && rate <= kHighestRate))
            throw core::Error(file.string() +
                              ": /frames_per_second: expected a number from 0.001 to 100000");
    }
    if (json.contains("loop")) {
        if (!json["loop"].is_boolean())
            throw core::Error(file.string() + ": /loop: expected true or false");
        wraps = json["loop"].get<bool>();
    }
    path_ = std::move(path);
    file_ = file;
    framesPerSecond = rate;
    loop = wraps;
    saved_ = kept();
    stop();
    frame_ = firstFrame();
}

}  // namespace app
