#include "core/methods/sky_slot.h"

#include "core/base/check.h"

namespace core {

void SkySlot::forget()
{
    asked_.reset();
    regions_.reset();
    taken_.reset();
}

/// Where regions pay, they are those that are made in any case.
bool SkySlot::isKnown(SkySampling sampling, const World& world) const
{
    return sampling == SkySampling::whole || world.environmentEmitter == shared::kNone ||
           regions_ != nullptr || asked_ == sampling;
}

void SkySlot::make(SkySampling sampling, const Accel& accel)
{
    const bool always = sampling == SkySampling::regions;
    regions_ = makeSkyRegions(accel, always ? SkyNeed::always : SkyNeed::hidden);
    asked_ = sampling;
}

std::shared_ptr<const SkyRegions> SkySlot::take(SkySampling sampling, const Accel& accel)
{
    if (!isKnown(sampling, accel.world())) make(sampling, accel);
    taken_ = sampling == SkySampling::whole ? nullptr : regions_;
    return taken_;
}

std::shared_ptr<const SkyRegions> SkySlot::take(SkySampling sampling,
                                                const std::shared_ptr<const World>& world)
{
    CHECK(world != nullptr);
    if (!isKnown(sampling, *world)) make(sampling, Accel(world));
    taken_ = sampling == SkySampling::whole ? nullptr : regions_;
    return taken_;
}

void SkySlot::addTo(RenderStats& stats) const
{
    if (!taken_) return;
    stats.details.push_back({"sky_regions", static_cast<double>(taken_->count)});
    stats.details.push_back({"sky_seconds", taken_->seconds});
}

}  // namespace core
