// Jobs of the session's threads. See session_jobs.h.
#include "app/session/session_jobs.h"

#include <utility>

#include "app/base/files.h"
#include "app/files/load.h"
#include "app/pictures/save_picture.h"
#include "core/base/check.h"
#include "core/methods/method.h"

namespace app {

namespace fs = std::filesystem;

core::Worker::Job loadJob(const SceneOptions& scene, std::shared_ptr<core::Mailbox<Loaded>> box)
{
    return [scene, box = std::move(box)](core::JobContext& context) {
        const LoadedWorld loaded = loadWorld(
            scene, 0,
            [&context](const char* stage, double fraction) { context.progress(stage, fraction); },
            context.stop());
        auto result = std::make_shared<Loaded>();
        Document& document = result->document;
        document.file = fs::absolute(loaded.file);
        document.world = loaded.world;
        document.time = scene.at;
        document.environment = scene.load.environment;
        document.loadSeconds = loaded.seconds;
        document.warnings = warningLines(loaded.world->warnings);
        if (!loaded.note.empty()) document.warnings.push_back(loaded.note);
        box->publish(context.generation(), std::move(result));
    };
}

core::Worker::Job poseJob(const Document& document, double time,
                          std::shared_ptr<core::Mailbox<Loaded>> box)
{
    return [world = document.world, time, box = std::move(box)](core::JobContext& context) {
        auto result = std::make_shared<Loaded>();
        result->pose = true;
        result->document.world = core::poseWorld(world, time);
        result->document.time = time;
        box->publish(context.generation(), std::move(result));
    };
}

core::Worker::Job exportJob(const Document& document, const CameraTrack& track,
                            const fs::path& pattern, glm::uvec2 size, const core::AnyParams& params,
                            uint32_t samples, const ViewParams& view)
{
    if (!isNumbered(pattern))
        throw core::Error(pattern.string() +
                          ": frames need a place for their number, as in frame-%04d.png");
    core::requireWritable(numbered(pattern, 0));
    return [document, track, pattern, size, params, samples, view](core::JobContext& context) {
        const std::unique_ptr<core::Renderer> renderer = core::makeRenderer(params.id());
        renderer->setPace({.dispatchSeconds = 0.05});
        const core::Progress progress = [&](const char* stage, double fraction) {
            context.progress(stage, fraction);
            if (context.stopped()) throw core::Error("cancelled", core::ExitCode::interrupted);
        };
        renderer->setWorld(document.world, progress);
        renderer->prepare(params, progress);
        const int first = static_cast<int>(track.firstFrame()),
                  last = static_cast<int>(track.lastFrame());
        for (int frame = first; frame <= last && !context.stopped(); ++frame) {
            context.progress(("frame " + std::to_string(frame)).c_str(),
                             static_cast<double>(frame - first) / (last - first + 1));
            const core::Camera camera =
                framed(track.at(frame), static_cast<double>(size.x) / size.y);
            // A method that keeps samples does so from frame to frame, as in the window.
            renderer->setView({camera, size, params},
                              frame == first ? core::Start::anew : core::Start::moved);
            renderer->advance({.samples = samples}, context.stop());
            if (renderer->progress().samples < samples) return;  // cancelled: no half frames
            core::Estimate estimate = renderer->read(core::Reading::everything);
            Picture picture;
            picture.mean = std::move(estimate.mean);
            picture.variance = std::make_shared<core::Image>(std::move(estimate.variance));
            picture.camera = camera;
            picture.fullSize = size;
            picture.params.device = DeviceKind::cpu;
            picture.params.method = params;
            picture.params.sppLimit = samples;
            picture.finished = true;
            picture.follows = frame != first && core::methodNamed(params.id()).traits.keepsOnMove;
            picture.samples = estimate.samples;
            picture.stats = renderer->stats();
            picture.seconds = picture.stats.renderSeconds;
            picture.counters = estimate.counters;
            savePicture(numbered(pattern, static_cast<uint32_t>(frame)), picture, document, view);
        }
    };
}

void SaveQueue::add(SaveItem item)
{
    const std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(item));
}

core::Worker::Job SaveQueue::job()
{
    return [self = shared_from_this()](core::JobContext&) {
        while (true) {
            SaveItem item;
            {
                const std::lock_guard lock(self->mutex_);
                if (self->waiting_.empty()) return;
                item = std::move(self->waiting_.front());
                self->waiting_.pop_front();
            }
            Told told{false,
                      wholePath(item.file) + ": saved, " + std::to_string(item.picture->samples) +
                          " samples per pixel",
                      item.file};
            try {
                savePicture(item.file, *item.picture, item.scene, item.view);
            } catch (const std::exception& error) {
                told = {true, error.what(), {}};
            }
            const std::lock_guard lock(self->mutex_);
            self->told_.push_back(std::move(told));
        }
    };
}

bool SaveQueue::hasTold() const
{
    const std::lock_guard lock(mutex_);
    return !told_.empty();
}

std::vector<SaveQueue::Told> SaveQueue::takeTold()
{
    const std::lock_guard lock(mutex_);
    return std::exchange(told_, {});
}

}  // namespace app
