// The one interface behind which every device and method renders: no API types in it.
#pragma once

#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "core/base/params.h"
#include "core/image/film.h"
#include "core/scene/world.h"

namespace core {

enum class SamplerKind : uint32_t { sobol, independent };
template <> struct EnumNames<SamplerKind> {
    static constexpr std::array<std::string_view, 2> names{"sobol", "independent"};
};

enum class Strategy : uint32_t { mis, bsdf, light };
template <> struct EnumNames<Strategy> {
    static constexpr std::array<std::string_view, 3> names{"mis", "bsdf", "light"};
};

enum class Kernel : uint32_t { automatic, wavefront, megakernel };
template <> struct EnumNames<Kernel> {
    static constexpr std::array<std::string_view, 3> names{"auto", "wavefront", "megakernel"};
};

/// Parameters of the path tracer, the same on every device.
struct PathParams {
    uint32_t maxDepth = 8;
    uint32_t rouletteDepth = 2;
    uint32_t seed = 1;
    SamplerKind sampler = SamplerKind::sobol;
    Strategy strategy = Strategy::mis;
    float clampIndirect = 0;
    Kernel kernel = Kernel::automatic;

    template <class Self, class V> static void visit(Self& p, V&& v)
    {
        v(Field{"max-depth",
                "scattering events per path: 0 shows emitters only, 1 adds direct light",
                {0, 4096}},
          p.maxDepth);
        v(Field{"roulette-depth",
                "scattering events before Russian roulette may end a path",
                {1, 4096}},
          p.rouletteDepth);
        v(Field{"seed", "another seed gives an independent image"}, p.seed);
        v(Field{"sampler", "sobol converges faster; independent obeys every variance formula"},
          p.sampler);
        v(Field{"strategy",
                "next-event estimation with MIS, BSDF sampling alone, or light sampling alone"},
          p.strategy);
        v(Field{"clamp-indirect",
                "upper bound of an indirect sample, 0 = off; darkens the image",
                {0, 1e6, true},
                true},
          p.clampIndirect);
        v(Field{"kernel",
                "GPU kernel: auto measures both; software devices run megakernel to depth 32 only"},
          p.kernel);
    }
    friend bool operator==(const PathParams&, const PathParams&) = default;
};

struct RenderStats {
    std::string device, driver;
    double buildSeconds = 0, compileSeconds = 0, prepareSeconds = 0, renderSeconds = 0,
           readbackSeconds = 0;
    uint64_t rays = 0, paths = 0;
    uint64_t peakDeviceBytes = 0;
    std::string kernel;
};

/// Called for stages that can last over half a second: a name and the fraction done in [0,1]; from
/// any thread, but never from two at a time. It may throw to end the work: the exception goes on to
/// the caller, and the renderer is left without a world.
using Progress = std::function<void(const char* stage, double fraction)>;

/// First-hit data at pixel centres. Depth is along the ray in metres, 0 = nothing hit; ids are -1
/// for a miss.
struct Aovs {
    Image depth, normal, albedo, ids;  // 1, 3, 3, 3 (triangle, material, emitter) channels
};

/// How work is cut up: `dispatchSeconds` is what one uninterruptible piece should take. With
/// `discardOnStop`, a stop may end `advance` in the middle of a sample, and the film is then empty
/// (samples() is 0) until the next setView; without, it keeps whole samples.
struct Pace {
    double dispatchSeconds = 0.1;
    bool discardOnStop = false;
};

class Renderer {
public:
    virtual ~Renderer() = default;

    /// Takes the scene: builds and uploads. Clears the film.
    virtual void setWorld(std::shared_ptr<const World> world, const Progress& progress) = 0;

    /// Image size, camera and parameters; clears the film.
    virtual void setView(const Camera& camera, uint32_t width, uint32_t height,
                         const PathParams& params) = 0;

    /// From now on; the image does not depend on it.
    virtual void setPace(const Pace& pace) = 0;

    /// Adds `samples` to every pixel, or stops early when asked to: see Pace for what the film then
    /// holds.
    virtual void advance(uint32_t samples, std::stop_token stop) = 0;

    /// Samples per pixel that the film holds now.
    virtual uint64_t samples() const = 0;

    virtual void readFilm(Film& film) = 0;

    /// Mean radiance alone (RGB, of samples() samples), which may be much cheaper than the film.
    virtual void readMean(Image& mean);
    virtual Aovs aovs() = 0;
    virtual RenderStats stats() const = 0;
};

inline void Renderer::readMean(Image& mean)
{
    Film film;
    readFilm(film);
    mean = film.mean();
}

}  // namespace core
