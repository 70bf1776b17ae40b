// See guiding_reference.h.
#include "app/bench/guiding/guiding_reference.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "app/bench/kept_reference.h"
#include "app/files/camera_file.h"
#include "core/base/check.h"
#include "core/base/time.h"

namespace app::guiding {

namespace {

constexpr uint32_t kSeeds[] = {0x9d1de001, 0x9d1de002};  // of the halves
constexpr double kStepSeconds = 0.25;

/// Guided path tracing as it is by default, whatever is measured: of the parameters only the depth
/// decides what the true picture is, and others may be biased.
core::GuidedParams trueParams(const ReferenceOrder& order)
{
    core::GuidedParams p;
    p.maxDepth = order.view.params.as<core::GuidedParams>().maxDepth;
    return p;
}

/// What is seen; how it is found does not matter.
std::string keyOf(const ReferenceOrder& order, const core::World& world)
{
    return referenceKey({{"method", "guided, as it is by default"},
                         {"scene", world.scene->hash},
                         {"at", order.at},
                         {"camera", cameraJson(order.view.camera, world.placement)},
                         {"size", {order.view.size.x, order.view.size.y}},
                         {"max-depth", order.view.params.as<core::GuidedParams>().maxDepth},
                         {"spp", order.samples}});
}

std::optional<core::Image> render(core::Renderer& renderer, const core::View& view,
                                  uint32_t samples, const std::function<void(double)>& progress,
                                  const std::stop_token& stop)
{
    renderer.setView(view, core::Start::anew);
    for (uint64_t done = 0; done < samples; done = renderer.progress().samples) {
        progress(static_cast<double>(done) / samples);
        renderer.advance({static_cast<uint32_t>(samples - done), kStepSeconds}, stop);
        if (stop.stop_requested()) return {};
    }
    return renderer.read(core::Reading::mean).mean;
}

}  // namespace

core::Image blurred(const core::Image& image)
{
    core::Image result(image.width, image.height, image.channels);
    for (uint32_t y = 0; y < image.height; ++y)
        for (uint32_t x = 0; x < image.width; ++x) {
            const uint32_t x0 = std::max(x, 1u) - 1, x1 = std::min(x + 2, image.width),
                           y0 = std::max(y, 1u) - 1, y1 = std::min(y + 2, image.height);
            const auto count = static_cast<float>((x1 - x0) * (y1 - y0));
            for (uint32_t v = y0; v < y1; ++v)
                for (uint32_t u = x0; u < x1; ++u)
                    for (uint32_t c = 0; c < image.channels; ++c)
                        result.at(x, y)[c] += image.at(u, v)[c] / count;
        }
    return result;
}

std::optional<GuidingReference> reference(const ReferenceOrder& order, core::Renderer& renderer,
                                          const core::World& world,
                                          const std::function<void(double)>& progress,
                                          std::stop_token stop)
{
    CHECK(order.samples >= 2 && order.samples % 2 == 0);
    const std::string key = keyOf(order, world);
    if (const auto kept = readReference(order.file, key, order.view.size, {"", "variance"})) {
        const core::Image& mean = kept->image.layer("");
        return GuidingReference{mean, kept->image.layer("variance"), blurred(mean), kept->seconds,
                                true};
    }
    const core::Clock::time_point start = core::Clock::now();
    core::GuidedParams params = trueParams(order);
    core::View view = order.view;
    core::Image halves[2];
    for (uint32_t i = 0; i < 2; ++i) {
        params.seed = kSeeds[i];
        view.params = params;
        auto half = render(
            renderer, view, order.samples / 2, [&](double part) { progress((i + part) / 2); },
            stop);
        if (!half) return {};
        halves[i] = std::move(*half);
    }
    GuidingReference r{halves[0], halves[1], {}, core::secondsSince(start), false};
    for (size_t i = 0; i < r.mean.pixels.size(); ++i) {
        const float a = halves[0].pixels[i], b = halves[1].pixels[i];
        r.mean.pixels[i] = (a + b) / 2;
        r.variance.pixels[i] = (a - b) * (a - b) / 4;
    }
    r.level = blurred(r.mean);
    keepReference(order.file, key, {{"", r.mean}, {"variance", r.variance}}, r.seconds);
    return r;
}

}  // namespace app::guiding
