// See flight_pilot.h.
#include "app/bench/flight_pilot.h"

#include "app/bench/bench_clock.h"

namespace app::flight {

Pilot::Pilot(const Target& target)
    : renderer_(makeRenderer(core::ReuseParams::kMethod, target)), hostClock_(worksOnHost(target))
{}

void Pilot::setWorld(std::shared_ptr<const core::World> world, const core::Progress& progress)
{
    renderer_->setWorld(std::move(world), progress);
}

const char* Pilot::clock() const
{
    return hostClock_ ? "cpu seconds / cores" : "device time";
}

std::optional<Landing> Pilot::fly(const Flight& flight, const Plan& plan, std::stop_token stop)
{
    Landing landing;
    for (uint32_t i = 0; i < plan.frames; ++i) {
        const core::Camera camera = flight.before(plan.step, plan.frames - 1 - i);
        renderer_->setView({camera, size_, plan.params},
                           i == 0 ? core::Start::anew : core::Start::moved);
        const core::RenderStats before = renderer_->stats();
        const double seconds = onHost([&] { renderer_->advance({.samples = plan.samples}, stop); });
        if (stop.stop_requested()) return {};
        const core::RenderStats after = renderer_->stats();
        landing.rays = static_cast<double>(after.rays - before.rays);
        landing.seconds = hostClock_ ? seconds : after.renderSeconds - before.renderSeconds;
    }
    landing.picture = renderer_->read(core::Reading::mean).mean;
    return landing;
}

}  // namespace app::flight
