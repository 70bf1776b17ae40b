// A film that is filled tile by tile in rounds, in which every pixel gets the same number of
// samples: what the progressive Vulkan methods have in common, as core::TiledFilm is on the CPU. A
// round that is cut short goes on where it was; meanwhile the weights in the film tell which pixels
// are ahead.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>

#include "app/gpu/film.h"
#include "app/gpu/first_hits.h"

namespace gpu {

/// The settings of a view of a world; what a method adds to them is left at zero.
shared::FrameData frameOf(const core::World& world, const GpuScene& scene, const core::View& view);

/// Paths after which the 32-bit counters are read: each path adds some 2^8 with sample reuse, and a
/// few rays for each of its vertices.
constexpr uint64_t pathsBetweenDrains(uint32_t maxDepth)
{
    constexpr uint64_t kRaysOfVertex = 8;
    return std::min(uint64_t(1) << 20,
                    (uint64_t(1) << 32) / ((uint64_t(maxDepth) + 1) * kRaysOfVertex));
}

class TiledFilm {
public:
    /// Records what is done with the radiance of a batch once it is there.
    using Then = std::function<void(VkCommandBuffer, const shared::Batch&)>;

    /// Traces a batch, then does what `then` records. Returns when all is done.
    using Trace = std::function<void(const shared::Batch& batch, const Then& then)>;

    explicit TiledFilm(Context& context);

    /// Another scene: nothing is rendered, and nothing can be until begin().
    void drop();

    /// An empty film for a view.
    void reset(const shared::FrameData& data);

    /// From now on batches may be traced; `radiance` (a vec4 per lane) is where they leave what
    /// they find.
    void begin(const Buffer& radiance);

    /// The same for a method whose own kernels add to the film, which is shown to `set`; a lane
    /// takes up to so many paths.
    void begin(DescriptorSet& set, uint32_t pathsOfLane = 1);

    /// As core::Renderer::advance; pieces are batches. `lanes` says how many lanes a batch may have
    /// now, `beforeRound` is called where no round is under way.
    void advance(const core::Budget& budget, const std::stop_token& stop,
                 const std::function<uint32_t()>& lanes, const Trace& trace,
                 const std::function<void()>& beforeRound = {});

    core::RenderProgress progress() const;
    core::Estimate read(core::Reading what);
    core::Aovs aovs(const GpuScene& scene, double seconds);
    /// Those of another view of the scene; the film stays.
    core::Aovs surfaces(const GpuScene& scene, const shared::FrameData& data, core::Sight sight,
                        double seconds);
    void prepareAovs(const GpuScene& scene);

    /// First hits of a view, as aovs(), for which there is no film and will be none before reset().
    core::Aovs look(const GpuScene& scene, const shared::FrameData& data, double seconds);

    /// Sets what has been traced since the last reset, and how long it took.
    void addTo(core::RenderStats& stats) const;

    /// What kernels have counted since the last reset.
    const FrameCounts& counts() const { return counts_; }

    Frame& frame() { return frame_; }
    const Frame& frame() const { return frame_; }
    const Then& accumulate() const { return accumulate_; }

private:
    void clear();
    bool advanceRound(const std::function<bool()>& over, const std::function<uint32_t()>& lanes,
                      const Trace& trace);

    Frame frame_;
    Film film_;
    FirstHits firstHits_;
    const Then accumulate_ = [this](VkCommandBuffer commands, const shared::Batch& batch) {
        film_.accumulate(commands, frame_, batch);
    };
    bool ready_ = false;
    uint32_t pathsOfLane_ = 1;
    uint64_t samples_ = 0, version_ = 0;
    // The round under way: its samples (0: none) and the first tile that has not had them.
    uint32_t roundSamples_ = 0, nextTile_ = 0;
    FrameCounts counts_;
    double renderSeconds_ = 0, readbackSeconds_ = 0;
};

}  // namespace gpu
