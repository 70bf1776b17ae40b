// The same estimator as the picture's, on Embree, with a seed of its own: what the two have in
// common is bias, of which neither has any, and never noise. Threads: it takes other processors
// only when no other loop wants them (core::runLast) and is meant for a Worker of niceness 10, five
// below the render thread. On two cores, measured with other work on the machine, that slows the
// picture by 1.3 (CPU renderer) to 1.5 times (Vulkan in software) and leaves pictures while moving
// as quick as they were; at equal niceness, in a common pool of threads, it was 2.6 to 3.2 times,
// and at niceness 15 nothing to be seen, but the reference stood still.
#include "app/pictures/reference_job.h"

#include <algorithm>
#include <cmath>

#include "app/pictures/convergence.h"
#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/base/time.h"
#include "core/methods/method.h"

namespace app {

namespace {

constexpr uint64_t kFirst = 4;  // samples of the first one that is handed out
constexpr double kGrowthBetweenReferences = 1.5;
constexpr double kReferenceStepSeconds = 0.2;

/// A seed that no one types: mixed bits with the highest one set (Wang's integer hash, 2007).
uint32_t ownSeed(uint32_t seed)
{
    uint32_t x = seed ^ 0x5eed5eedu;
    x = (x ^ 61u) ^ (x >> 16u);
    x *= 9u;
    x ^= x >> 4u;
    x *= 0x27d4eb2du;
    x ^= x >> 15u;
    return x | 0x80000000u;
}

std::string seedText(const core::AnyParams& params)
{
    const uint32_t* seed = core::findParam<uint32_t>(params, "seed");
    return seed != nullptr ? std::to_string(*seed) : "none";
}

void renderReference(const ReferenceOrder& order, core::Mailbox<Reference>& box,
                     core::JobContext& job)
{
    const auto renderer = core::makeRenderer(order.params.id());
    renderer->setPace({.dispatchSeconds = 0.05});
    const core::Progress progress = [&](const char* stage, double fraction) {
        job.progress(stage, fraction);
        if (job.stopped()) throw core::Error("cancelled", core::ExitCode::interrupted);
    };
    renderer->setWorld(order.world, progress);
    renderer->prepare(order.params, progress);
    renderer->setView({order.camera, order.size, order.params}, core::Start::anew);
    double seconds = 0;
    for (uint64_t done = 0, next = kFirst; done < order.samples;) {
        next = std::min(next, order.samples);
        const core::Clock::time_point start = core::Clock::now();
        while (done < next) {  // in short steps, so that the progress moves
            renderer->advance({static_cast<uint32_t>(next - done), kReferenceStepSeconds},
                              job.stop());
            if (job.stopped()) return;
            const core::RenderProgress now = renderer->progress();
            done = now.samples;
            job.progress("reference", (double(done) + now.fraction) / double(order.samples));
        }
        seconds += core::secondsSince(start);
        core::Estimate estimate = renderer->read(core::Reading::everything);
        auto reference = std::make_shared<Reference>();
        reference->mean = std::move(estimate.mean);
        reference->variance = std::move(estimate.variance);
        reference->noise = referenceNoise(*reference);
        reference->samples = done;
        reference->seconds = seconds;
        reference->origin =
            "rendered here, " + std::string(order.params.id()) + ", seed " + seedText(order.params);
        reference->params.device = DeviceKind::cpu;
        reference->params.method = order.params;
        reference->params.sppLimit = order.samples;
        box.publish(job.generation(), std::move(reference));
        next = static_cast<uint64_t>(std::ceil(kGrowthBetweenReferences * double(done)));
    }
}

}  // namespace

core::Worker::Job referenceJob(ReferenceOrder order, std::shared_ptr<core::Mailbox<Reference>> box)
{
    CHECK(order.world != nullptr && order.size.x > 0 && order.size.y > 0);
    if (uint32_t* seed = core::findParam<uint32_t>(order.params, "seed")) *seed = ownSeed(*seed);
    return [order = std::move(order), box = std::move(box)](core::JobContext& job) {
        core::runLast([&] { renderReference(order, *box, job); });
    };
}

}  // namespace app
