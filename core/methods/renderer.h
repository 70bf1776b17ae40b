// The one interface behind which every method renders on every device: no API types in it.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/base/progress.h"
#include "core/image/film.h"
#include "core/methods/any_params.h"
#include "core/scene/world.h"

namespace core {

/// What is to be seen and how it is found.
struct View {
    Camera camera;
    glm::uvec2 size{0};  // pixels
    AnyParams params;
    // Samples are taken at the centres of pixels, where first hits are known (aovs), and not all
    // over them. It is for single samples: edges have steps.
    bool centred = false;

    friend bool operator==(const View&, const View&) = default;
};

/// How a view follows on the one before. `moved`: the same scene a moment later, from a camera that
/// has moved or in a pose that has changed; a method that keeps samples (Traits::keepsOnMove) may
/// begin with what it has. `anew`: nothing of before counts.
enum class Start { anew, moved };

/// How work is cut up: what one uninterruptible piece should take, so that a stop is soon obeyed
/// and others on the device, of which a window is one, have their turn.
struct Pace {
    double dispatchSeconds = 0.1;
    bool whole = false;  // nothing stops what is rendered: pieces are for others alone
};

/// How much `advance` may do: so many samples per pixel beyond the whole ones there are, and no new
/// piece after so many seconds. A step that was cut short is completed first, whatever its size;
/// `samples` 0 does no more.
struct Budget {
    uint32_t samples = 1;
    double seconds = std::numeric_limits<double>::infinity();
};

/// How far a picture is. `version` grows with everything that changes what `read` returns, whole
/// samples or not; `samples` are those that every pixel has had, `fraction` in [0,1) is how much of
/// the next step has been done (a renderer may take several samples in one step).
struct RenderProgress {
    uint64_t version = 0;
    uint64_t samples = 0;
    double fraction = 0;
};

/// What to read: the mean alone may be much cheaper.
enum class Reading { mean, everything };

/// A number or a word that only the method understands, for stats and panel.
struct StatsDetail {
    std::string name;
    std::variant<double, std::string> value;
};

struct RenderStats {
    std::string device, driver;
    double buildSeconds = 0, compileSeconds = 0, renderSeconds = 0, readbackSeconds = 0;
    bool hierarchyCached =
        false;  // read from a file of an earlier run; buildSeconds tells how fast
    uint64_t rays = 0, paths = 0;
    uint64_t peakDeviceBytes = 0;
    std::vector<StatsDetail> details;
};

/// First-hit data at pixel centres. Depth is along the ray in units of the world
/// (World::scale of them to a metre), 0 = nothing hit; ids are -1 for a miss.
struct Aovs {
    Image depth, normal, albedo, ids;  // 1, 3, 3, 3 (triangle, material, emitter) channels
    Image emission;                    // 3: towards the camera, of what is behind everything, too
};

/// Which surface a pixel shows: the first one, whatever it is, or, where that is clear glass, a
/// pane or a mirror, what appears in it (shared/seen.h).
enum class Sight { first, clear };

/// What a method knows of a place: a small picture of one channel (negative: nothing there), and a
/// line that says what it shows.
struct PlacePicture {
    Image image;
    std::string caption;
};

/// Tells of the places that a picture shows, from any thread; a snapshot.
class PlaceProbe {
public:
    virtual ~PlaceProbe() = default;

    /// The place where the pixel looks; nothing where nothing is known.
    virtual std::optional<PlacePicture> at(glm::uvec2 pixel) const = 0;
};

class Renderer {
public:
    virtual ~Renderer() = default;

    /// Takes the scene: builds and uploads. What was rendered is gone. When `progress` throws, the
    /// renderer is left without a world.
    virtual void setWorld(std::shared_ptr<const World> world, const Progress& progress) = 0;

    /// Makes what views with such parameters (this method's) need of the world beyond what
    /// setWorld() has made, where that takes longer than a frame: what is seen of the sky from
    /// where. When `progress` throws, the renderer is as it was. setView() makes it, too, if need
    /// be, but tells nobody and goes on to the end.
    virtual void prepare(const AnyParams&, const Progress&) {}

    /// First hits of a view that setView() takes next, where kernels of the method have to be
    /// compiled for it: something to look at meanwhile. What was rendered is gone. Nothing where
    /// setView() does not take long.
    virtual std::optional<Aovs> look(const View&) { return std::nullopt; }

    /// Size, camera and parameters, which must be this method's; begins a picture.
    virtual void setView(const View& view, Start start) = 0;

    /// From now on; the picture does not depend on it.
    virtual void setPace(const Pace& pace) = 0;

    /// Renders on within the budget. A stop, or the end of the time, ends it after the piece under
    /// way: each piece is in the estimate whole or not at all, and the next call goes on from
    /// there, so that pauses do not change the picture. At least one piece is done unless a stop
    /// comes first.
    virtual void advance(const Budget& budget, std::stop_token stop) = 0;

    virtual RenderProgress progress() const = 0;
    virtual Estimate read(Reading what) = 0;
    virtual Aovs aovs() = 0;
    /// The surfaces of the world in a picture of that size, seen by that camera; what is rendered
    /// stays as it is. Seen clearly, depth counts along the whole way, the normal is as it appears,
    /// and albedo and emission are what is left of them. A method that finds none but its own
    /// view's first hits returns those.
    virtual Aovs surfaces(const Camera&, glm::uvec2 /*size*/, Sight) { return aovs(); }
    /// Makes what aovs() needs of a view beyond its samples, where that takes longer than finding
    /// the first hits of a small picture: kernels.
    virtual void prepareAovs() {}
    /// Pictures of numbers that only the method understands, as MethodInfo::maps lists them: one
    /// channel, the size of the view. Empty while there is nothing to show.
    virtual std::vector<Image> maps() { return {}; }
    /// What there is to say of single places beside the maps; null for methods that have nothing.
    virtual std::shared_ptr<const PlaceProbe> probe() { return nullptr; }
    virtual RenderStats stats() const = 0;
};

}  // namespace core
