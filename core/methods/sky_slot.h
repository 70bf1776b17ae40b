// The regions of the sky that a renderer draws the environment by, on either device: made when a
// view first asks for them, gone with the world.
#pragma once

#include <memory>
#include <optional>

#include "core/methods/path_params.h"
#include "core/methods/renderer.h"
#include "core/trace/sky_regions.h"

namespace core {

class SkySlot {
public:
    /// Another world, or another pose of it.
    void forget();

    /// Regions for views that ask for `sampling` in the accelerated world; null where the
    /// environment is to be drawn as a whole. Learning takes longer than a frame of an animation
    /// may, so what moves has regions only where they are asked for by name.
    std::shared_ptr<const SkyRegions> take(SkySampling sampling, const Accel& accel);

    /// The same where there is no hierarchy for the CPU: one is built where it is needed, quickly,
    /// and let go. Only rays that meet an edge may find others.
    std::shared_ptr<const SkyRegions> take(SkySampling sampling,
                                           const std::shared_ptr<const World>& world);

    /// What was taken last.
    const SkyRegions* taken() const { return taken_.get(); }

    /// How many there are and how long it took to make them, where there are some.
    void addTo(RenderStats& stats) const;

private:
    static bool isWanted(SkySampling sampling, const World& world);
    bool isKnown(SkySampling sampling) const;
    void make(SkySampling sampling, const Accel& accel);

    std::optional<SkySampling> asked_;  // what regions_ were made for
    std::shared_ptr<const SkyRegions> regions_, taken_;
};

}  // namespace core
