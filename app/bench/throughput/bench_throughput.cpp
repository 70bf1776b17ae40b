// See bench_throughput.h.
#include "app/bench/throughput/bench_throughput.h"

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/base/log.h"
#include "app/bench/bench_clock.h"
#include "app/bench/throughput/bench_figures.h"
#include "app/bench/throughput/bench_rays.h"
#include "app/files/load.h"
#include "app/files/params_json.h"
#include "app/files/stats.h"
#include "app/methods/methods.h"
#include "core/base/check.h"

namespace app {

namespace {

using Json = nlohmann::ordered_json;

void measure(std::vector<BenchFigure>& figures, double seconds, Log& log)
{
    measureInTurns(figures, seconds, [&log](double done) { log.progress("measuring", done); });
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
    std::vector<BenchFigure> figures;
    figures.push_back({"vulkan",
                       amount,
                       [&] { return software ? onHost([&] { trace(); }) : onCard(trace); },
                       {}});
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
    for (const BenchFigure& f : figures) json[f.name] = f.rate();
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
    std::vector<BenchFigure> figures;
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
                               return onCard([&r] {
                                   const double start = r.stats().renderSeconds;
                                   r.advance({}, {});
                                   return r.stats().renderSeconds - start;
                               });
                           },
                           {}});
    }
    measure(figures, seconds, log);
    Json json;
    for (const BenchFigure& f : figures) json[f.name] = f.rate();
    return json;
}

}  // namespace

int benchThroughput(const ThroughputOptions& options, std::ostream& out)
{
    Log log(false);
    SceneOptions scene = options.scene;
    scene.load.instancing = core::Instancing::flat;  // as Embree is given it here
    const LoadedWorld loaded = loadWorld(scene, 0, log.callback());
    const core::World& world = *loaded.world;
    const core::Camera& camera = world.cameras.front();
    const glm::uvec2 size = core::sizeForWidth(camera, options.width);
    const gpu::DeviceOptions deviceOptions{.index = options.deviceIndex, .validation = false};

    gpu::Device device(deviceOptions);
    const bool software = device.isSoftware();
    Json sets = Json::object(), ratios = Json::object(), rates = Json::object();
    {
        const core::EmbreeRays embree(loaded.world);
        const BenchRays rays = makeBenchRays(world, embree, camera, size.x, size.y);
        if (rays.bounce.empty())
            throw core::Error(options.scene.file.string() +
                              ": no ray of the first camera's view hits anything — bench "
                              "throughput needs a scene whose first camera looks at it");
        gpu::GpuRays traced(device, world, false);
        const std::pair<const char*, const std::vector<gpu::DeviceRay>*> all[] = {
            {"primary", &rays.primary}, {"bounce", &rays.bounce}, {"any", &rays.shadow}};
        for (const auto& [name, set] : all) {
            if (set->empty()) {  // shadow rays alone: from flat lamps none go to them
                log.line("this view has no shadow rays");
                ratios[name] = rates[name] = sets[name] = nullptr;
                continue;
            }
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
