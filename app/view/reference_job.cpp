// The same estimator as the picture's, on Embree, with a seed of its own: what the two have in common is bias, of which
// neither has any, and never noise.
#include "app/view/reference_job.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/check.h"
#include "core/methods/methods.h"

namespace app {

namespace {

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

}  // namespace

core::Worker::Job referenceJob(ReferenceOrder order, std::shared_ptr<core::Mailbox<Reference>> box)
{
    return [order = std::move(order), box = std::move(box)](core::JobContext& job) {
        CHECK(order.world != nullptr && order.size.x > 0 && order.size.y > 0);
        const auto renderer = core::makeRenderer("path");
        renderer->setPace({.dispatchSeconds = 0.05, .discardOnStop = true});
        renderer->setWorld(order.world, [&](const char* stage, double fraction) {
            job.progress(stage, fraction);
            if (job.stopped()) throw core::Error("cancelled", core::ExitCode::interrupted);
        });
        core::PathParams params = order.params;
        params.seed = ownSeed(params.seed);
        renderer->setView(order.camera, order.size.x, order.size.y, params);

        double seconds = 0;
        for (uint64_t done = 0, next = 4; done < order.samples && !job.stopped();) {
            next = std::min(next, order.samples);
            const auto start = std::chrono::steady_clock::now();
            // In small steps, so that the progress moves; the image does not depend on them.
            while (done < next && !job.stopped()) {
                renderer->advance(static_cast<uint32_t>(std::min<uint64_t>(next - done, 4)), job.stop());
                done = renderer->samples();
                job.progress("reference", double(done) / double(order.samples));
            }
            seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
            if (job.stopped()) return;
            core::Film film;
            renderer->readFilm(film);
            auto reference = std::make_shared<Reference>();
            reference->mean = film.mean();
            reference->variance = film.varianceOfMean();
            reference->samples = done;
            reference->seconds = seconds;
            reference->origin = "core thread, path, seed " + std::to_string(params.seed);
            box->publish(job.generation(), std::move(reference));
            next = static_cast<uint64_t>(std::ceil(1.5 * double(done)));
        }
    };
}

}  // namespace app
