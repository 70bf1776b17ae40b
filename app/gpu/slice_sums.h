// Sums of completed slices on the device: one kernel, one submission per batch
// (core/many_lights/slice_queue.h).
#pragma once

#include "app/gpu/base/batch_pace.h"
#include "app/gpu/context.h"
#include "app/gpu/scene.h"
#include "core/methods/many_lights.h"

namespace gpu {

/// What the kernel is specialised on.
struct GatherConstants {
    static constexpr uint32_t kFirst = 0;
    uint32_t features = 0xffffffffu;  // number 0: lang.h
    uint32_t numbers = 0;             // shared::kSpecializeNumbers
    uint32_t shape = 0;               // shared::kSpecializeShape
};

class SliceSums final : public core::ManyLightsDevice {
public:
    /// Throws core::Error (noDevice) when no device is suitable.
    explicit SliceSums(const DeviceOptions& options);

    void setWorld(std::shared_ptr<const core::World> world,
                  const core::Progress& progress) override;
    void prepare(const core::many_lights::SumRules& rules) override;
    void setPace(const core::Pace& pace) override
    {
        seconds_ = context_.paceFor(pace).dispatchSeconds;
    }
    void addTo(core::RenderStats& stats) const override;

    uint64_t batchEntries() const override;
    double sum(std::span<const core::many_lights::SlicePiece> pieces,
               const core::many_lights::SumRules& rules, std::span<glm::vec3> radiance) override;

private:
    /// An array of the batch, as it is put together and on the device.
    template <class T> struct Array {
        uint32_t binding;
        const char* name;
        VkFormat format;
        std::vector<T> items{};
        Buffer buffer{};
    };
    /// Grows the buffer, if need be.
    void makeRoom(Buffer& buffer, uint32_t binding, const char* name, uint64_t bytes,
                  VkFormat format);
    template <class T> void upload(Array<T>& array);
    void append(const core::many_lights::SlicePiece& piece, bool numbers);
    GatherConstants constantsFor(const core::many_lights::SumRules& rules) const;
    uint32_t laneEntries() const;
    uint32_t lanesOf(uint64_t entries) const;
    double dispatch(const core::many_lights::SumRules& rules, const char* what);

    Context context_;  // first: everything below is made on its device
    Kernel<shared::GatherRules, GatherConstants> kernel_;
    DescriptorSet set_;
    std::unique_ptr<GpuScene> scene_;
    std::shared_ptr<const core::World> world_;
    Array<shared::SliceGroup> groups_;
    Array<shared::ReceiverRecord> receivers_;
    Array<shared::LightRecord> lights_;
    Array<glm::vec4> details_;
    Array<uint32_t> values_;
    Buffer gathered_;
    std::vector<glm::vec4> found_;
    core::many_lights::SumRules rules_;  // prepared for
    BatchPace pace_;
    double seconds_ = 0.1, compileSeconds_ = 0, readbackSeconds_ = 0;
};

}  // namespace gpu
