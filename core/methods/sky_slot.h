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
    /// environment is to be drawn as a whole.
    std::shared_ptr<const SkyRegions> take(SkySampling sampling, const Accel& accel);

    /// The same where there is no hierarchy for the CPU: one is built where it is needed, and let
    /// go. The regions are the same.
    std::shared_ptr<const SkyRegions> take(SkySampling sampling,
                                           const std::shared_ptr<const World>& world);

    /// What was taken last.
    const SkyRegions* taken() const { return taken_.get(); }

    /// How many there are and how long it took to make them, where there are some.
    void addTo(RenderStats& stats) const;

private:
    bool isKnown(SkySampling sampling, const World& world) const;
    void make(SkySampling sampling, const Accel& accel);

    std::optional<SkySampling> asked_;  // what regions_ were made for
    std::shared_ptr<const SkyRegions> regions_, taken_;
};

}  // namespace core
