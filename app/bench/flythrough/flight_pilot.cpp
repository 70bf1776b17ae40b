// See flight_pilot.h.
#include "app/bench/flythrough/flight_pilot.h"

#include "app/bench/bench_clock.h"

namespace app::flight {

Pilot::Pilot(const Target& target)
    : renderer_(makeRenderer(core::ReuseParams::kMethod, target)), hostClock_(worksOnHost(target))
{}

void Pilot::setWorld(std::shared_ptr<const core::World> world, const core::Progress& progress,
                     const std::optional<Play>& play)
{
    world_ = std::move(world);
    play_ = play;
    renderer_->setWorld(world_, progress);
}

/// The scene as it is so many frames before the end.
std::shared_ptr<const core::World> Pilot::worldBefore(uint32_t frames) const
{
    return frames == 0 ? world_
                       : core::poseWorld(world_, play_->end - frames / play_->framesPerSecond);
}

const char* Pilot::clock() const
{
    return hostClock_ ? "cpu seconds / cores" : "device time";
}

std::optional<Landing> Pilot::fly(const Flight& flight, const Plan& plan, std::stop_token stop)
{
    Landing landing;
    for (uint32_t i = 0; i < plan.frames; ++i) {
        const uint32_t left = plan.frames - 1 - i;
        const core::Camera camera = flight.before(plan.step, left);
        if (play_) renderer_->setWorld(worldBefore(left), {});
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
