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

    /// Makes the regions that views ask for with `sampling` in the accelerated world, if they are
    /// wanted and there are none yet. Learning takes longer than a frame of an animation may, so
    /// what moves has regions only where they are asked for by name. When `progress` throws,
    /// everything is as it was.
    void prepare(SkySampling sampling, const Accel& accel, const Progress& progress = {});

    /// The same where there is no hierarchy for the CPU: one is built where it is needed, quickly,
    /// and let go. Only rays that meet an edge may find others.
    void prepare(SkySampling sampling, const std::shared_ptr<const World>& world,
                 const Progress& progress = {});

    /// The regions that prepare() makes; null where the environment is to be drawn as a whole.
    std::shared_ptr<const SkyRegions> take(SkySampling sampling, const Accel& accel);
    std::shared_ptr<const SkyRegions> take(SkySampling sampling,
                                           const std::shared_ptr<const World>& world);

    /// What was taken last.
    const SkyRegions* taken() const { return taken_.get(); }

    /// How many there are and how long it took to make them, where there are some.
    void addTo(RenderStats& stats) const;

private:
    static bool isWanted(SkySampling sampling, const World& world);
    bool isKnown(SkySampling sampling) const;
    void make(SkySampling sampling, const Accel& accel, const Progress& progress);

    std::optional<SkySampling> asked_;  // what regions_ were made for
    std::shared_ptr<const SkyRegions> regions_, taken_;
};

}  // namespace core
