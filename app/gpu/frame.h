// Set 1 of the kernels: what stays fixed between two changes of the view, and the counters.
#pragma once

#include "app/gpu/base/kernel.h"
#include "core/image/film.h"
#include "core/methods/reuse_figures.h"

namespace gpu {

/// What kernels have counted since the last clearCounters(), in numbers that do not overflow.
struct FrameCounts {
    core::FilmCounters film;
    uint64_t rays = 0;
    core::ReuseFigures reuse;
};

class Frame {
public:
    Frame(Device& device, const SharedLayouts& layouts);

    /// Takes the settings of a view. Counters stay as they are.
    void write(const shared::FrameData& data);
    const shared::FrameData& data() const { return data_; }

    uint32_t width() const { return data_.settings.imageWidth; }
    uint32_t height() const { return data_.settings.imageHeight; }
    uint32_t tileRows() const { return (height() + 7) / 8; }
    uint32_t tileCount() const { return data_.tilesPerRow * tileRows(); }

    /// Moves what the device has counted (in 32 bits) into `counts`.
    void drainCounters(FrameCounts& counts);
    /// Forgets what the device has counted since the last drain.
    void clearCounters() { setCounters({}); }
    /// What it has counted since, and the same set to something else.
    shared::Counters counters() const;
    void setCounters(const shared::Counters& counters);

    const DescriptorSet& set() const { return set_; }

private:
    shared::FrameData data_{};
    Buffer uniforms_, counters_;
    DescriptorSet set_;
};

}  // namespace gpu
