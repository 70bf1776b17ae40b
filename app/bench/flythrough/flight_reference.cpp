// See flight_reference.h.
#include "app/bench/flythrough/flight_reference.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "app/bench/kept_reference.h"
#include "app/files/camera_file.h"
#include "app/files/params_json.h"
#include "core/base/check.h"
#include "core/base/time.h"

namespace app::flight {

namespace {

constexpr uint32_t kSeed = 0xf1196e75;  // one that no flight has
constexpr double kStepSeconds = 0.25;

/// Plain path tracing where the flights look.
core::AnyParams plainParams(const core::AnyParams& params)
{
    core::ReuseParams plain = params.as<core::ReuseParams>();
    plain.reuse = core::ReuseStrategy::discard;
    plain.sampler = core::SamplerKind::independent;
    plain.seed = kSeed;
    return plain;
}

std::string keyOf(const ReferenceOrder& order, const core::World& world)
{
    const core::ReuseParams& p = order.view.params.as<core::ReuseParams>();
    return referenceKey({{"scene", world.scene->hash},
                         {"at", order.at},
                         {"camera", cameraJson(order.view.camera, world.placement)},
                         {"size", {order.view.size.x, order.view.size.y}},
                         {"max-depth", p.maxDepth},
                         {"roulette-depth", p.rouletteDepth},
                         {"jitter", std::string(core::enumName(p.jitter))},
                         {"spp", order.samples}});
}

double meanOf(const core::Image& image)
{
    double sum = 0;
    for (const float x : image.pixels) sum += static_cast<double>(x);
    return sum / static_cast<double>(image.pixels.size());
}

}  // namespace

std::optional<FlightReference> reference(const ReferenceOrder& order, core::Renderer& renderer,
                                         const core::World& world,
                                         const std::function<void(double)>& progress,
                                         std::stop_token stop)
{
    CHECK(order.samples >= 2);
    const std::string key = keyOf(order, world);
    if (const auto kept = readReference(order.file, key, order.view.size, {"", "variance"})) {
        const core::Image& mean = kept->image.layer("");
        return FlightReference{mean, kept->image.layer("variance"), meanOf(mean), kept->seconds,
                               true};
    }
    core::View view = order.view;
    view.params = plainParams(view.params);
    const core::Clock::time_point start = core::Clock::now();
    renderer.setView(view, core::Start::anew);
    for (uint64_t done = 0; done < order.samples; done = renderer.progress().samples) {
        const uint64_t left = std::min<uint64_t>(order.samples - done, 1u << 20u);
        renderer.advance({static_cast<uint32_t>(left), kStepSeconds}, stop);
        if (stop.stop_requested()) return {};
        progress(static_cast<double>(done) / static_cast<double>(order.samples));
    }
    core::Estimate estimate = renderer.read(core::Reading::everything);
    FlightReference r{std::move(estimate.mean), std::move(estimate.variance), 0,
                      core::secondsSince(start), false};
    r.radiance = meanOf(r.mean);
    keepReference(order.file, key, {{"", r.mean}, {"variance", r.variance}}, r.seconds);
    return r;
}

}  // namespace app::flight
