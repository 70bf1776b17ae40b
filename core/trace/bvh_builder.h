// Builds one of the trees of a Bvh: recursion, tasks and final layout. Small subtrees are built by
// one task into arrays of their own; the tree above them is kept as tasks, and everything is
// concatenated depth first at the end, so that the layout does not depend on who finished first.
// Private to bvh*.cpp.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <vector>

#include "core/base/check.h"
#include "core/trace/bvh.h"
#include "core/trace/bvh_grid.h"
#include "core/trace/bvh_split.h"

namespace core::bvh {

constexpr size_t kMaxReferences = (1u << 27) - 2;  // what a child reference can address

/// What is said of a scene with more.
Error tooLarge(size_t triangles);

/// The triangles of one tree: first, first + 1, ..., but with a gap.
struct Subset {
    uint32_t first = 0, gap = 0, gapSize = 0;
    size_t count = 0;

    uint32_t at(size_t i) const
    {
        const uint32_t triangle = first + static_cast<uint32_t>(i);
        return triangle < gap ? triangle : triangle + gapSize;
    }
};

/// Reports the fraction of references that are in leaves, a percent at a time.
class BuildProgress {
public:
    BuildProgress(const std::function<void(double)>& callback, size_t total)
        : callback_(callback), total_(std::max<size_t>(total, 1))
    {}

    void add(size_t references);

private:
    const std::function<void(double)>& callback_;
    const size_t total_;
    std::atomic<size_t> done_{0};
    std::mutex mutex_;
    double reported_ = 0;
};

class Builder {
public:
    Builder(const Mesh& mesh, const Subset& subset, const BvhOptions& options,
            BuildProgress& progress, std::stop_token stop);

    /// Bounds of the triangles.
    const Box& box() const { return bounds_.box; }

    /// Builds the tree, `depth` nodes below the root of the whole, which lies on `grid`. Once. What
    /// instances lead to counts as if it were above.
    void build(const Grid& grid, uint32_t depth);

    size_t nodeCount() const;

    /// The finished tree, with nodes numbered from `firstNode` and slots from `firstSlot`, behind
    /// the words that `nodes` begins with (they count as the nodes before). Lets go of it.
    BvhPart layOut(std::vector<shared::uvec4> nodes, uint32_t firstNode, uint32_t firstSlot,
                   uint32_t& root, double& least);

private:
    /// The whole, or a part of it that is of a far smaller scale.
    struct Region {
        Grid grid;            // of its boxes
        float area;           // half the surface of its bounds
        bool begins = false;  // rays are to begin in it: it gets a grid of its own
    };

    /// A finished subtree with node and slot numbers of its own, root reference included.
    struct Chunk {
        std::vector<shared::uvec4> nodes;
        std::vector<uint32_t> slots;
        std::vector<uint32_t> entries;  // words where ways into instances begin
        uint32_t root = shared::kBvhDone;
        uint32_t depth = 0;
        uint32_t gridChanges = 0;
        double cost = 0;   // sum of half areas times tests
        double least = 0;  // the same with the references' own boxes
    };

    /// The tree above the chunks: a node with two children; a change of grid with one; a chunk.
    struct Task {
        std::unique_ptr<Task> child[2];
        Box box[2];
        std::optional<Grid> finer;  // of the child, where the grid changes
        Chunk chunk;                // when there are no children
    };

    struct Decision {
        SplitKind kind = SplitKind::centroid;
        size_t middle = 0;
        Range left, right;
        RangeBounds leftBounds, rightBounds;
    };

    /// Where a tree is appended; the shifts take places in the arrays to numbers in the whole.
    struct Layout {
        std::vector<shared::uvec4>& nodes;
        uint32_t nodeShift;
        std::vector<uint32_t>& slots;
        uint32_t slotShift;
        uint32_t& depth;
        uint32_t& gridChanges;
        double& cost;
        double& least;
    };

    struct Free {
        void operator()(Reference* p) const
        {
            ::operator delete (p, std::align_val_t{alignof(Reference)});
        }
    };

    std::span<Reference> all() { return {references_.get(), capacity_}; }
    std::span<Reference> span(const Range& r) { return all().subspan(r.begin, r.size()); }

    RangeBounds makeReferences();
    bool mustHalve(size_t count, uint32_t depth) const;
    bool holdsInstances(const Range& range);
    std::optional<Region> finerRegion(const Range& range, const RangeBounds& bounds, uint32_t depth,
                                      const Region& region) const;
    Split bestSplit(const Range& range, const RangeBounds& bounds, const Region& region,
                    bool parts);
    bool split(Range range, const RangeBounds& bounds, uint32_t depth, const Region& region,
               Decision& d);
    bool beginsBelow(uint32_t depth) const;
    Region leftRegion(const Decision& d, uint32_t depth, const Region& region) const;
    void shareRoom(const Range& range, Decision& d);
    uint32_t buildInto(Chunk& chunk, const Range& range, const RangeBounds& bounds, uint32_t depth,
                       const Region& region);
    uint32_t buildLeaf(Chunk& chunk, const Range& range, const Box& box);
    uint32_t buildInstance(Chunk& chunk, const InstanceLeaf& instance, uint32_t depth,
                           const Grid& grid);
    std::unique_ptr<Task> buildTask(const Range& range, const RangeBounds& bounds, uint32_t depth,
                                    const Region& region);
    uint32_t append(Layout& out, Task& task, uint32_t depth, const Grid& grid);
    uint32_t appendChunk(Layout& out, const Chunk& chunk);
    template <class T>
    static size_t sizeOf(const Task& task, std::vector<T> Chunk::*array, size_t perNode);

    Mesh mesh_;
    Subset subset_;
    BvhOptions options_;
    BuildProgress& progress_;
    std::stop_token stop_;
    std::unique_ptr<Reference[], Free> references_;
    size_t capacity_ = 0;
    RangeBounds bounds_;
    std::optional<Grid> grid_;
    uint32_t depth_ = 0;
    std::unique_ptr<Task> top_;
};

}  // namespace core::bvh
