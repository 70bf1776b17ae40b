// See sky_slot.h.
#include "core/methods/sky_slot.h"

#include "core/base/check.h"
#include "core/scene/moved_pieces.h"

namespace core {

void SkySlot::forget()
{
    asked_.reset();
    regions_.reset();
    taken_.reset();
}

bool SkySlot::isWanted(SkySampling sampling, const World& world)
{
    if (sampling == SkySampling::whole || world.environmentEmitter == shared::kNone) return false;
    return sampling == SkySampling::regions || !mayMove(world);
}

/// Where regions pay, they are those that are made in any case; those that were made in any case
/// may not pay.
bool SkySlot::isKnown(SkySampling sampling) const
{
    return asked_ == sampling || (asked_ == SkySampling::automatic && regions_ != nullptr);
}

void SkySlot::make(SkySampling sampling, const Accel& accel, const Progress& progress)
{
    const bool always = sampling == SkySampling::regions;
    regions_ = makeSkyRegions(accel, always ? SkyNeed::always : SkyNeed::hidden, progress);
    asked_ = sampling;
}

void SkySlot::prepare(SkySampling sampling, const Accel& accel, const Progress& progress)
{
    if (isWanted(sampling, accel.world()) && !isKnown(sampling)) make(sampling, accel, progress);
}

void SkySlot::prepare(SkySampling sampling, const std::shared_ptr<const World>& world,
                      const Progress& progress)
{
    CHECK(world != nullptr);
    if (isWanted(sampling, *world) && !isKnown(sampling))
        make(sampling, Accel(world, progress, {}, AccelQuality::medium), progress);
}

std::shared_ptr<const SkyRegions> SkySlot::take(SkySampling sampling, const Accel& accel)
{
    prepare(sampling, accel);
    return taken_ = isWanted(sampling, accel.world()) ? regions_ : nullptr;
}

std::shared_ptr<const SkyRegions> SkySlot::take(SkySampling sampling,
                                                const std::shared_ptr<const World>& world)
{
    prepare(sampling, world);
    return taken_ = isWanted(sampling, *world) ? regions_ : nullptr;
}

void SkySlot::addTo(RenderStats& stats) const
{
    if (!taken_) return;
    stats.details.push_back({"sky_regions", static_cast<double>(taken_->count)});
    stats.details.push_back({"sky_seconds", taken_->seconds});
}

}  // namespace core
