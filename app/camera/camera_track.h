// A camera path under edit: keys are added from where one stands, moved, removed, played, looped,
// saved.
#pragma once

#include <filesystem>

#include "app/files/camera_file.h"

namespace app {

class CameraTrack {
public:
    double framesPerSecond = 24;
    bool loop = true;

    const std::vector<CameraPath::Key>& keys() const { return path_.keys; }
    bool empty() const { return path_.keys.empty(); }

    /// Adds a key `framesPerSecond` frames (at least one) after the last one.
    void add(const core::Camera& camera);

    /// A key that stands at that frame is replaced. Frames are from 0 to 1e9; others are ignored.
    void addAt(double frame, const core::Camera& camera);

    /// Indices that do not exist are ignored, here and below.
    void remove(size_t index);
    void replace(size_t index, const core::Camera& camera);  // keeps the frame

    /// Returns the key's new index; keys stay in order. Onto the frame of another key it does not
    /// go: it stays where it was.
    size_t move(size_t index, double frame);

    /// Also forgets the file: keys to come are another path, which may not replace it unasked.
    void clear();

    double firstFrame() const;  // 0 when empty
    double lastFrame() const;

    /// The camera at a frame, held before the first and after the last key. Not for empty tracks.
    core::Camera at(double frame) const { return path_.at(frame); }

    // --- playing
    bool playing() const { return playing_; }
    void play();  // from the start when at the end; needs two keys
    void stop() { playing_ = false; }
    double frame() const { return frame_; }
    void seek(double frame);  // held within the keys

    /// Moves on by `seconds`; wraps when looping, else stops at the end. True while the frame
    /// changed.
    bool advance(double seconds);

    // --- files: the format of camera_file.h, with "frames_per_second" and "loop" beside the keys
    nlohmann::ordered_json json(const core::Placement& placement) const;

    /// Throws core::Error, also when there are no keys.
    void save(const std::filesystem::path& file, const core::Placement& placement);

    /// Takes the place of what there is, when it can be read. What was saved comes back to the bit
    /// as far as the file's own space can hold it: see cameraJson. Throws core::Error.
    void load(const std::filesystem::path& file, const core::Camera& defaults,
              const core::Placement& placement);

    /// Where the keys were saved or came from last; empty: nowhere.
    const std::filesystem::path& file() const { return file_; }

    /// Whether a path (two keys are one) is in no file as it is now.
    bool unsaved() const;

private:
    /// What a file keeps.
    struct Kept {
        std::vector<CameraPath::Key> keys;
        double framesPerSecond = 0;
        bool loop = false;
        friend bool operator==(const Kept&, const Kept&) = default;
    };
    Kept kept() const { return {path_.keys, framesPerSecond, loop}; }
    void settle();

    CameraPath path_;
    Kept saved_;  // in file_
    std::filesystem::path file_;
    double frame_ = 0;
    bool playing_ = false;
};

}  // namespace app
