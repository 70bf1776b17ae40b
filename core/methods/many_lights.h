// What a device brings to rendering with many lights: the sum. Everything else is the CPU's, so
// that pictures of both differ by rounding alone.
#pragma once

#include "core/many_lights/slice_queue.h"
#include "core/methods/renderer.h"

namespace core {

class ManyLightsDevice : public many_lights::BatchSum {
public:
    /// Takes the scene; slots of receivers are its triangles.
    virtual void setWorld(std::shared_ptr<const World> world, const Progress& progress) = 0;
    /// Makes ready for sums by such rules, whose numbers for gathering do not matter yet.
    virtual void prepare(const many_lights::SumRules& rules) = 0;
    virtual void setPace(const Pace& pace) = 0;
    /// Sets names, memory and what compiling and reading back took.
    virtual void addTo(RenderStats& stats) const = 0;
};

/// Rendering with many lights whose sums are those of `device`.
std::unique_ptr<Renderer> makeManyLights(std::unique_ptr<ManyLightsDevice> device);

}  // namespace core
