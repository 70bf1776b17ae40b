// The thread that renders what the window shows. It owns the renderer; the window posts requests
// and picks up pictures, and neither waits for the other.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "app/pictures/picture.h"
#include "core/base/worker.h"

namespace app {

struct RenderThreadStatus {
    std::string stage;        // "start", "building the BVH", "prepare", "render", "idle", ...
    double fraction = 0;      // of the stage, or core::kUnknownShare
    double stageSeconds = 0;  // since it began
    bool rendering = false;   // samples are being taken now
    std::string error;        // the last failure; cleared by the next picture
    uint64_t errorCount = 0;  // grows with every failure, so that each is told once
    std::string lastError;    // that one, also when a picture has come since
    // From the last request that interrupted work to the end of that work
    double lastStopSeconds = 0;
    // Of the last picture while the camera moved: from request to picture, and of its sides
    double movingSeconds = 0;
    float movingScale = 1, movingSurfaceScale = 1;
};

/// Makes the renderer for a request.
using RendererFactory =
    std::function<std::unique_ptr<core::Renderer>(const RenderParams&, bool validation)>;
/// Of the program's own methods; what is dear to make is kept in `cacheFolder` (empty: nowhere).
RendererFactory viewRenderers(const std::filesystem::path& cacheFolder = {});

class RenderThread {
public:
    /// `onPicture` is called on that thread whenever there is a new picture.
    explicit RenderThread(RendererFactory factory = viewRenderers(),
                          std::function<void()> onPicture = {});
    ~RenderThread();

    /// Takes the order and returns its generation. Without a scene only the renderer is made, so
    /// that its device is open once there is one. Restarts only what it changes: a new device or
    /// method makes a new renderer, a new world is uploaded, a new view clears the film, everything
    /// else continues. Never blocks. While paused, a new view still gets its first picture. Where a
    /// full sample takes longer than a moment, one coarse picture (Picture::preview) comes first,
    /// also when nothing moves. After a failure the last picture and the error stand until a
    /// request that differs in what failed (scene, device, view) or in `restarts`.
    uint64_t request(RenderRequest request);

    /// The newest picture, of any generation; null before the first. Pictures of a picture's
    /// continuation carry the generation of the newest request that they satisfy.
    std::shared_ptr<const Picture> newest() const;

    RenderThreadStatus status() const;

private:
    class Loop;
    std::shared_ptr<Loop> loop_;
    core::Worker worker_;
};

}  // namespace app
