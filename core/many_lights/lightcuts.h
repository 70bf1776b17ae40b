// Lightcuts: B. Walter, S. Fernandez, A. Arbree, K. Bala, M. Donikian, D. Greenberg, "Lightcuts: A
// Scalable Approach to Illumination" (2005). Every receiver has a cut of its own through the light
// tree: the node with the largest bound is split until none can err by more than a part of what the
// receiver gets. A representative's shadow ray serves all nodes that it stands for. What differs:
// nodes of neighbouring receivers are split together, several at a time, so that rays fill packets;
// errors are compared as luminances; and of surfaces and lights other than Lambert's the bound is
// an estimate.
#pragma once

#include "core/many_lights/light_tree.h"
#include "core/many_lights/shadow_packets.h"
#include "core/many_lights/slice_lighter.h"

namespace core::many_lights {

/// A node of one receiver's cut.
struct CutEntry {
    float bound;  // of its luminance, whatever is in between; 0 for single lights, which are exact
    uint32_t node;
    LightKind kind;
    glm::vec3 unit;  // what its representative brings, visibility included, over its importance
};

/// Cuts for a few receivers at a time; keeps its memory: one per thread.
class LightcutGroup {
public:
    static constexpr uint32_t kRows = 16;

    /// Everything is kept by reference.
    LightcutGroup(const SliceJob& job, const LightTree& tree, uint32_t clusters, float error)
        : job_(job), tree_(tree), clusters_(clusters), error_(error)
    {}

    /// Makes the cuts of some rows, at most kRows; what was added to them is lost. Returns false
    /// once `stop` is requested.
    bool run(SliceRows& rows, IndexRange range, const std::stop_token& stop);

    // Of the k-th of the rows.
    std::span<const CutEntry> cut(uint32_t k) const { return states_[k].cut; }
    glm::vec3 radiance(uint32_t k) const;
    /// Shadow rays of the last run.
    uint64_t rays() const { return rays_; }

private:
    struct State {
        uint32_t row = 0;
        CutQuery query;
        std::vector<CutEntry> cut;  // first a heap of nodes that may be split, then the others
        size_t open = 0;            // size of the heap
        double total = 0;           // luminance of all
    };
    /// A representative to be seen.
    struct Pending {
        uint32_t state;
        CutEntry entry;
        Column column;
        float weight;
        uint64_t visible;
    };

    bool split(SliceRows& rows, uint32_t k);
    void ask(const SliceRows& rows, uint32_t k, uint32_t node, LightKind kind, float bound);
    void answer(SliceRows& rows);
    void insert(State& state, const CutEntry& entry);
    float boundOf(const SliceRows& rows, const State& state, uint32_t node, LightKind kind) const;

    const SliceJob& job_;
    const LightTree& tree_;
    uint32_t clusters_;
    float error_;
    std::array<State, kRows> states_;
    std::vector<Pending> pending_;
    std::vector<float> weights_;
    uint64_t rays_ = 0;
};

class Lightcuts final : public SliceLighter {
public:
    /// Keeps the tree by reference. A cut has `clusters` nodes at most; a node may err by `error`
    /// times what its receiver gets.
    Lightcuts(const LightTree& tree, uint32_t clusters, float error)
        : tree_(tree), clusters_(clusters), error_(error)
    {}

    bool light(const SliceJob& job, std::span<const Receiver> receivers,
               std::span<const uint32_t> chosen, uint32_t slice, const std::stop_token& stop,
               std::span<glm::vec3> radiance, SliceStats& stats) const override;

private:
    const LightTree& tree_;
    uint32_t clusters_;
    float error_;
};

}  // namespace core::many_lights
