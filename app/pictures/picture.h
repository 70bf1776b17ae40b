// What the render thread is asked for and what it hands back: immutable snapshots both ways.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "app/args/args.h"
#include "app/pictures/view_params.h"
#include "core/image/film.h"
#include "core/image/image.h"
#include "core/methods/renderer.h"
#include "core/scene/camera.h"
#include "core/scene/world.h"

namespace app {

/// Where to render and how: a change of any member but `sppLimit`, `secondsLimit` and `errorLimit`
/// starts the picture anew.
struct RenderParams {
    DeviceKind device = DeviceKind::vulkan;
    int deviceIndex = -1;
    core::AnyParams method;   // how light is found
    uint64_t sppLimit = 0;    // 0: none
    double secondsLimit = 0;  // 0: none
    double errorLimit = 0;  // RMSE (against the reference, or estimated from the variance); 0: none

    /// Without `method`, which has its own list.
    template <class Self, class V> static void visit(Self& p, V&& v)
    {
        using core::Field;
        v(Field{"device", "Vulkan compute, or Embree on all cores"}, p.device);
        v(Field{"device-index",
                "which Vulkan device, as `devices` lists them; -1 chooses",
                {-1, 255}},
          p.deviceIndex);
        v(Field{"spp-limit",
                "samples per pixel after which the picture is finished; 0: none",
                {0, 2147483647}},
          p.sppLimit);
        v(Field{"seconds-limit",
                "seconds of rendering after which the picture is finished; 0: none",
                {0, 1e9}},
          p.secondsLimit);
        v(Field{"error-limit", "RMSE at which the picture is finished; 0: none", {0, 1e9}},
          p.errorLimit);
    }
    friend bool operator==(const RenderParams&, const RenderParams&) = default;
};

/// Whether both make the same picture: limits only say when it is finished.
inline bool sameRendering(const RenderParams& a, const RenderParams& b)
{
    return a.device == b.device && a.deviceIndex == b.deviceIndex && a.method == b.method;
}

/// The image that errors are measured against; from the core thread or from a file.
struct Reference {
    core::Image mean;      // RGB
    core::Image variance;  // of the mean; empty when unknown
    double noise = 0;      // what referenceNoise() makes of it, known to whoever draws
    uint64_t samples = 0;  // 0: unknown
    double seconds = 0;
    std::string origin;     // "rendered here, path, seed 7" or the file's name
    RenderParams params{};  // that it was rendered with; of one from a file they are unknown
};

/// An immutable order. Two orders with equal `world`, `camera`, `size`, `restarts` and rendering
/// (sameRendering) continue one picture.
struct RenderRequest {
    std::shared_ptr<const core::World> world;  // none: nothing to do
    core::Camera camera;
    glm::uvec2 size{0};  // of the full picture, pixels
    RenderParams params;
    bool validation = false;
    uint64_t restarts = 0;  // counts what asks for a new start though nothing else differs

    // The camera moves: pictures come small and shallow, at the rate asked for
    bool moving = false;
    bool paused = false;
    double targetFrameSeconds = 1.0 / 30;  // while moving
    uint32_t movingDepth = 3;              // of paths while moving, at most
    Moving movingShows = Moving::path;
    bool movingDetail = false;  // see MovingDetail
    bool wantVariance = false, wantAovs = false, wantMaps = false;
    std::shared_ptr<const Reference> reference;  // of the same view, or none

    friend bool operator==(const RenderRequest&, const RenderRequest&) = default;
};

/// A point of the curve of error over time.
struct ErrorPoint {
    double seconds = 0;  // of rendering, since the start of the picture
    uint64_t samples = 0;
    double rmse = 0;    // against the reference; 0 without one
    double rmseSe = 0;  // its standard error
    // Sqrt of the mean variance of the mean: what the samples' own spread says
    double estimated = 0;
};

/// An immutable result. `generation` is that of the request that it answers.
struct Picture {
    uint64_t generation = 0;
    std::weak_ptr<const core::World> world;  // that it shows; a kept picture keeps no scene
    std::weak_ptr<const core::Scene> scene;  // of that world, and of its other poses
    double time = 0;                         // of that world, in seconds of the scene's animation
    // RGB radiance; while moving smaller than asked for
    core::Image mean;
    std::shared_ptr<const core::Image> variance;           // of the mean, RGB; when wanted
    std::shared_ptr<const core::Aovs> aovs;                // when wanted
    std::shared_ptr<const std::vector<core::Image>> maps;  // the method's own, when wanted
    std::shared_ptr<const core::PlaceProbe> probe;         // with them; null where there is none
    core::Camera camera;
    glm::uvec2 fullSize{0};
    RenderParams params;
    uint64_t restarts = 0;  // of that request
    uint64_t samples = 0;   // that every pixel has had
    double fraction = 0;    // in [0,1): how much of the next step some pixels have had, too
    double seconds = 0;     // of rendering, since the start of the picture
    bool preview = false;   // coarse: rendered while the camera moved
    bool shaded = false;    // first hits lit from the camera, for the display at exposure 0
    std::shared_ptr<const core::Image> guide;  // to the pixels of a preview: see surfaceGuide()
    glm::uvec2 sampled{0};  // pixels that have had samples, where these are fewer (MovingDetail)
    bool follows = false;   // began with what the views before had left: see PictureFacts
    bool finished = false;  // a limit is reached
    bool black = false;     // every pixel has had a sample, and none has brought any light
    core::FilmCounters counters;
    core::RenderStats stats;
    // From the start of the picture; thinned, at most a few hundred points
    std::vector<ErrorPoint> curve;
};

/// How many pixels a picture's samples were taken at.
inline glm::uvec2 sampledSize(const Picture& p)
{
    return p.sampled.x > 0 ? p.sampled : glm::uvec2(p.mean.width, p.mean.height);
}

/// Whether every pixel has had as many samples, of the picture's full size: only that can be
/// rendered again to the bit.
inline bool isWhole(const Picture& p)
{
    return !p.preview && p.fraction == 0 && p.samples > 0;
}

/// Whether two pictures show the same: scene at one instant, camera and size.
inline bool oneView(const Picture& a, const Picture& b)
{
    return !a.world.owner_before(b.world) && !b.world.owner_before(a.world) &&
           a.camera == b.camera && a.fullSize == b.fullSize;
}

/// Whether two are results of one picture, to which samples were added in between.
inline bool onePicture(const Picture& a, const Picture& b)
{
    return a.restarts == b.restarts && oneView(a, b) && sameRendering(a.params, b.params);
}

/// Whether `kept` has every sample of `live`. (One with the same samples may carry more, as their
/// variance.)
inline bool holds(const std::shared_ptr<const Picture>& kept,
                  const std::shared_ptr<const Picture>& live)
{
    if (!kept || !live) return false;
    return kept == live ||
           (onePicture(*kept, *live) && !kept->preview && kept->samples >= live->samples);
}

}  // namespace app
