// Work that the session gives to its threads: loading, posing an animated scene, exporting frames,
// saving files.
#pragma once

#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "app/session/session.h"
#include "core/base/worker.h"

namespace app {

core::Worker::Job loadJob(const SceneOptions& scene, std::shared_ptr<core::Mailbox<Loaded>> box);
core::Worker::Job poseJob(const Document& document, double time,
                          std::shared_ptr<core::Mailbox<Loaded>> box);

/// Renders the track's frames one after the other with the method of `params` on the CPU, each
/// following on the one before. Throws core::Error when the pattern has no place for a number or
/// cannot be written.
core::Worker::Job exportJob(const Document& document, const CameraTrack& track,
                            const std::filesystem::path& pattern, glm::uvec2 size,
                            const core::AnyParams& params, uint32_t samples,
                            const ViewParams& view);

/// A picture on its way to a file, with the scene that it shows.
struct SaveItem {
    std::filesystem::path file;
    std::shared_ptr<const Picture> picture;
    ShownScene scene;
    ViewParams view;
    std::weak_ptr<const void> work;  // that the file keeps; expired: the picture
};

/// Pictures that wait to be written: none is lost when several are saved at once.
class SaveQueue : public std::enable_shared_from_this<SaveQueue> {
public:
    void add(SaveItem item);
    core::Worker::Job job();  // writes all that waits

    struct Told {
        bool failed = false;
        std::string text;
        std::filesystem::path file;
    };
    /// What has been written or failed since the last call.
    std::vector<Told> takeTold();
    bool hasTold() const;

private:
    mutable std::mutex mutex_;
    std::deque<SaveItem> waiting_;
    std::vector<Told> told_;
};

}  // namespace app
