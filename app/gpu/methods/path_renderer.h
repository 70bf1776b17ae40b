// The class behind makePathRenderer, for the files that make it up: path.cpp (scene, view, samples)
// and path_read.cpp (what comes back).
#pragma once

#include <array>
#include <chrono>
#include <functional>
#include <map>
#include <tuple>

#include "app/gpu/base/batch_pace.h"
#include "app/gpu/methods/path.h"
#include "app/gpu/scene.h"

namespace gpu {

class PathRenderer final : public core::Renderer {
public:
    explicit PathRenderer(const DeviceOptions& options);

    void setWorld(std::shared_ptr<const core::World> world,
                  const core::Progress& progress) override;
    void setView(const core::View& view, core::Start start) override;
    void advance(const core::Budget& budget, std::stop_token stop) override;
    core::RenderProgress progress() const override;
    void setPace(const core::Pace& pace) override { pace_ = pace; }
    core::Estimate read(core::Reading what) override;
    core::Aovs aovs() override;
    core::RenderStats stats() const override;

private:
    struct Kernels {
        Pipeline bounce, megakernel, aov;
    };

    /// Which kernel is faster, for one scene and one kind of work.
    struct Choice {
        uint64_t lanes = 0;  // traced in this view
        bool made = false, wavefront = true;
    };
    /// What the choice depends on: specialization, depth, strategy, and whether the image is small.
    using WorkKind = std::tuple<Specialization, uint32_t, core::Strategy, bool>;

    void makeBuffers();
    const Pipeline& kernel(Pipeline Kernels::*which);
    void warmUp(const Pipeline& fresh);
    bool takeChoice();
    void chooseKernel();
    bool advanceRound(const std::function<bool()>& over);
    void readMean(core::Image& mean);
    void readFilm(core::Estimate& estimate);
    uint64_t pixelSamples(size_t pixel) const;
    uint32_t lanesNow() const;
    std::string workOf(const char* kernel, const shared::Batch& batch) const;
    double tracePaths(const shared::Batch& batch, bool keep);
    double traceByBounces(shared::Batch batch, bool keep);
    void accumulate(VkCommandBuffer commands, const shared::Batch& batch);
    const Buffer& outputBuffer(uint64_t bytes);
    void dispatch(VkCommandBuffer commands, const Pipeline& pipeline, const Bindings& bindings,
                  const shared::Batch& batch, uint32_t lanes);
    void drainCounters();
    void clearCounters();
    void bindAll(uint32_t binding, const Buffer& buffer);
    uint32_t tileCount() const
    {
        return frame_.tilesPerRow * ((frame_.settings.imageHeight + 7) / 8);
    }

    Device device_;
    KernelLayout layout_;
    // They differ in which buffer of paths is read and which is written
    std::array<Bindings, 2> bindings_;
    Pipeline accumulate_, mean_;
    std::map<Specialization, Kernels> kernels_;
    Kernels* kernelsNow_ = nullptr;
    Specialization specialization_;  // that these are for
    Kernels* current_ = nullptr;     // the same, once the view is ready for work
    std::unique_ptr<GpuScene> scene_;
    std::shared_ptr<const core::World> world_;
    std::array<Buffer, 2> states_;
    Buffer radiance_, queues_, frameBuffer_, counters_, output_;
    std::array<Buffer, 3> film_;
    shared::FrameData frame_{};
    core::PathParams params_;
    core::Pace pace_;
    BatchPace batchPace_;
    std::map<WorkKind, Choice> choices_;  // for the present scene
    Choice* choice_ = nullptr;
    bool wavefront_ = true;
    uint64_t samples_ = 0, version_ = 0;
    // The round under way: its samples (0: none) and the first tile that has not had them.
    uint32_t roundSamples_ = 0, nextTile_ = 0;
    core::RenderStats stats_;
    core::FilmCounters filmCounters_;
};

}  // namespace gpu
