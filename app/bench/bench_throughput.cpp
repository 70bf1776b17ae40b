// Interleaved rounds and medians, so that other work on the machine affects all alike.
#include "app/bench/bench_throughput.h"

#include <algorithm>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/base/log.h"
#include "app/bench/bench_clock.h"
#include "app/bench/bench_rays.h"
#include "app/files/load.h"
#include "app/files/params_json.h"
#include "app/files/stats.h"
#include "app/methods/methods.h"
#include "core/base/check.h"

namespace app {

namespace {

using Json = nlohmann::ordered_json;

constexpr int kMinRounds = 5, kMaxRounds = 101;

/// One figure: `run` does `amount` of work and returns the seconds.
struct Figure {
    std::string name;
    double amount = 0;
    std::function<double()> run;
    std::vector<double> seconds;

    double rate() const { return amount / median(seconds); }
};

/// Runs all figures in turns, at least five times and until each had `seconds`. The first round, in
/// which drivers compile, does not count.
void measure(std::vector<Figure>& figures, double seconds, Log& log)
{
    double slowest = 0;
    for (Figure& f : figures) slowest = std::max(slowest, f.run());
    const int rounds =
        std::clamp(static_cast<int>(seconds / std::max(slowest, 1e-4)), kMinRounds, kMaxRounds);
    for (int round = 0; round < rounds; ++round) {
        for (Figure& f : figures) f.seconds.push_back(f.run());
        log.progress("measuring", (round + 1.0) / rounds);
    }
}

/// The figures of one set of rays, by name: the GPU's and Embree's two.
Json measureRays(const std::string& set, std::span<const gpu::DeviceRay> rays, gpu::GpuRays& device,
                 bool software, const core::EmbreeRays& embree, double seconds, Log& log)
{
    const bool any = set == "any";
    std::vector<gpu::DeviceHit> hits(rays.size());
    device.setRays(rays);
    const double amount = static_cast<double>(rays.size());
    const auto trace = [&] { return any ? device.traceAny() : device.traceClosest(); };
    std::vector<Figure> figures;
    figures.push_back(
        {"vulkan", amount, [&] { return software ? onHost([&] { trace(); }) : trace(); }, {}});
    figures.push_back(
        {any ? "rtcOccluded1" : "rtcIntersect1",
         amount,
         [&] {
             return onHost([&] { any ? embree.any1(rays, hits) : embree.closest1(rays, hits); });
         },
         {}});
    figures.push_back(
        {any ? "rtcOccluded16" : "rtcIntersect16",
         amount,
         [&] {
             return onHost([&] { any ? embree.any16(rays, hits) : embree.closest16(rays, hits); });
         },
         {}});
    measure(figures, seconds, log);
    Json json{{"rays", rays.size()}, {"rounds", figures[0].seconds.size()}};
    for (const Figure& f : figures) json[f.name] = f.rate();
    json["ratio1"] = figures[0].rate() / figures[1].rate();
    json["ratio16"] = figures[0].rate() / figures[2].rate();
    return json;
}

/// Whole samples per second of a method's renderers on the devices that have it, in turns.
Json measureSamples(std::shared_ptr<const core::World> world, const core::View& view,
                    int deviceIndex, bool software, double seconds, Log& log)
{
    struct Made {
        DeviceKind device;
        std::unique_ptr<core::Renderer> renderer;
    };
    std::vector<Made> all;
    const std::string_view method = view.params.id();
    for (const DeviceKind device : {DeviceKind::vulkan, DeviceKind::cpu})
        if (whyNot(method, device).empty())
            all.push_back({device, makeRenderer(method, {device, deviceIndex})});
    std::vector<Figure> figures;
    for (Made& made : all) {
        core::Renderer& r = *made.renderer;
        r.setWorld(world, {});
        r.setView(view, core::Start::anew);
        r.advance({.samples = 2}, {});  // compiles, and lets the device choose its kernel
        const bool onHostClock = software || made.device == DeviceKind::cpu;
        figures.push_back({std::string(core::enumName(made.device)),
                           static_cast<double>(view.size.x) * view.size.y,
                           [&r, onHostClock] {
                               if (onHostClock) return onHost([&r] { r.advance({}, {}); });
                               const double start = r.stats().renderSeconds;
                               r.advance({}, {});
                               return r.stats().renderSeconds - start;
                           },
                           {}});
    }
    measure(figures, seconds, log);
    Json json;
    for (const Figure& f : figures) json[f.name] = f.rate();
    return json;
}

}  // namespace

int benchThroughput(const ThroughputOptions& options, std::ostream& out)
{
    Log log(false);
    SceneOptions scene = options.scene;
    scene.load.instancing = core::Instancing::flat;  // which Embree is given here
    const LoadedWorld loaded = loadWorld(scene, 0, log.callback());
    const core::World& world = *loaded.world;
    if (world.cameras.empty())
        throw core::Error("bench throughput: the scene has no camera — give one that has");
    const core::Camera& camera = world.cameras.front();
    const glm::uvec2 size = core::sizeForWidth(camera, options.width);
    const gpu::DeviceOptions deviceOptions{.index = options.deviceIndex, .validation = false};

    gpu::Device device(deviceOptions);
    const bool software = device.isSoftware();
    Json sets = Json::object(), ratios = Json::object(), rates = Json::object();
    {
        const core::EmbreeRays embree(loaded.world);
        const BenchRays rays = makeBenchRays(world, embree, camera, size.x, size.y);
        gpu::GpuRays traced(device, world, false);
        const std::pair<const char*, const std::vector<gpu::DeviceRay>*> all[] = {
            {"primary", &rays.primary}, {"bounce", &rays.bounce}, {"any", &rays.shadow}};
        for (const auto& [name, set] : all) {
            if (set->empty())
                throw core::Error(
                    "bench throughput: no ray of the view hits anything — another camera?");
            log.line(std::string("tracing ") + name + " rays");
            const Json json =
                measureRays(name, *set, traced, software, embree, options.seconds, log);
            ratios[name] = json["ratio1"];
            rates[name] = json["vulkan"];
            sets[name] = json;
        }
    }
    log.line("rendering");
    const Json samples = measureSamples(loaded.world, {camera, size, options.params},
                                        options.deviceIndex, software, options.seconds, log);
    out << jsonLines(
        {{"schema", 1},
         {"command", "bench throughput"},
         {"scene", options.scene.file.string()},
         {"triangles", world.triangles.size()},
         {"device", device.info().name},
         {"driver", device.info().driver},
         {"cores", cores()},
         {"clock", software ? "cpu seconds / cores" : "cpu seconds / cores; gpu: device time"},
         {"size", {size.x, size.y}},
         {"method", std::string(options.params.id())},
         {"params", paramsJson(options.params)},
         {"ratios", ratios},
         {"rays_per_second", rates},
         {"sets", sets},
         {"samples_per_second", samples}});
    return 0;
}

}  // namespace app
