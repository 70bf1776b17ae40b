// A camera path under edit: keys are added from where one stands, moved, removed, played, looped, saved.
#pragma once

#include <filesystem>

#include "app/camera_file.h"

namespace app {

class CameraTrack {
public:
    double framesPerSecond = 24;
    bool loop = true;

    const std::vector<CameraPath::Key>& keys() const { return path_.keys; }
    bool empty() const { return path_.keys.empty(); }

    /// Adds a key `framesPerSecond` frames after the last one (or at `frame`; a key that stands there is replaced).
    void add(const core::Camera& camera);
    void addAt(double frame, const core::Camera& camera);
    void remove(size_t index);
    void replace(size_t index, const core::Camera& camera);  // keeps the frame
    size_t move(size_t index, double frame);  // returns its new index; keys stay in order, no two on one frame
    void clear();

    double firstFrame() const;
    double lastFrame() const;
    core::Camera at(double frame) const { return path_.at(frame); }

    // --- playing
    bool playing() const { return playing_; }
    void play();   // from the start when at the end
    void stop() { playing_ = false; }
    double frame() const { return frame_; }
    void seek(double frame);
    /// Moves on by `seconds`; wraps when looping, else stops at the end. True while the frame changed.
    bool advance(double seconds);

    // --- files: the format of camera_file.h
    nlohmann::ordered_json json(const core::Placement& placement) const;
    void save(const std::filesystem::path& file, const core::Placement& placement) const;
    void load(const std::filesystem::path& file, const core::Camera& defaults, const core::Placement& placement);

private:
    CameraPath path_;
    double frame_ = 0;
    bool playing_ = false;
};

}  // namespace app
