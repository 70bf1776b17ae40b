// Recursion, tasks and final layout of the BVH builder; see bvh.h. Small subtrees are built by one
// task into arrays of their own; the tree above them is kept as tasks, and everything is
// concatenated depth first at the end, so that the layout does not depend on who finished first.
#include "core/trace/bvh.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <mutex>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include "core/base/check.h"
#include "core/trace/bvh_grid.h"
#include "core/trace/bvh_split.h"

namespace core {
namespace {

using bvh::Box;
using bvh::Float4;
using bvh::Grid;
using bvh::Range;
using bvh::RangeBounds;
using bvh::Reference;
using bvh::Split;
using shared::uvec4;

constexpr size_t kTaskSize = 1u << 12;  // references below which one task builds the whole subtree
constexpr size_t kMaxReferences = 1u << 27;  // what a child reference can address
// Stich et al.'s alpha: overlap area over scene area worth a spatial split
constexpr float kMinOverlap = 1e-5f;

/// A finished subtree with node and slot numbers of its own, root reference included.
struct Chunk {
    std::vector<uvec4> nodes;
    std::vector<uint32_t> slots;
    uint32_t root = shared::kBvhDone;
    uint32_t depth = 0;
    double cost = 0;   // sum of half areas times tests
    double least = 0;  // the same with the references' own boxes
};

/// The tree above the chunks.
struct TaskNode {
    std::unique_ptr<TaskNode> child[2];
    Box box[2];
    Chunk chunk;  // when there are no children
};

uint32_t leafReference(size_t count, size_t firstSlot)
{
    return shared::kBvhLeaf | static_cast<uint32_t>(count) << shared::kBvhCountShift |
           static_cast<uint32_t>(firstSlot);
}

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

    void add(size_t references)
    {
        const size_t done = done_.fetch_add(references) + references;
        if (!callback_) return;
        const std::unique_lock lock(mutex_, std::try_to_lock);
        if (!lock.owns_lock()) return;
        // Duplicates can make it more than one.
        const double fraction =
            std::min(1.0, static_cast<double>(done) / static_cast<double>(total_));
        if (fraction < reported_ + 0.01) return;
        reported_ = fraction;
        callback_(fraction);
    }

private:
    const std::function<void(double)>& callback_;
    const size_t total_;
    std::atomic<size_t> done_{0};
    std::mutex mutex_;
    double reported_ = 0;
};

class Builder {
public:
    Builder(const bvh::Mesh& mesh, const Subset& subset, const BvhOptions& options,
            BuildProgress& progress, std::stop_token stop)
        : mesh_(mesh), subset_(subset), options_(options), progress_(progress),
          stop_(std::move(stop))
    {
        bounds_ = makeReferences();
    }

    const Box& box() const { return bounds_.box; }

    /// Builds the tree, `depth` nodes below the root of the whole. Once.
    void build(const Grid& grid, uint32_t depth)
    {
        grid_ = &grid;
        depth_ = depth;
        sceneArea_ = bounds_.box.halfArea();
        top_ = buildTask({0, subset_.count, capacity_}, bounds_, depth);
        references_.reset();
    }

    size_t nodeCount() const { return sizeOf(*top_, &Chunk::nodes, 2) / 2; }

    /// The finished tree, with nodes numbered from `firstNode` and slots from `firstSlot`, behind
    /// the words that `nodes` begins with (they count as the nodes before). Lets go of it.
    BvhPart layOut(std::vector<uvec4> nodes, uint32_t firstNode, uint32_t firstSlot, uint32_t& root,
                   double& least)
    {
        std::vector<uint32_t> slots;
        nodes.reserve(nodes.size() + sizeOf(*top_, &Chunk::nodes, 2));
        slots.reserve(sizeOf(*top_, &Chunk::slots, 0));
        BvhPart part;
        part.low = bvh::asVec3(bounds_.box.low);
        part.high = bvh::asVec3(bounds_.box.high);
        Layout out{nodes,      firstNode - static_cast<uint32_t>(nodes.size() / 2),
                   slots,      firstSlot,
                   part.depth, part.cost,
                   least};
        root = append(out, *top_, depth_);
        top_.reset();
        part.nodes = std::move(nodes);
        part.slots = std::move(slots);
        return part;
    }

private:
    struct Decision {
        size_t middle = 0;
        Range left, right;
        RangeBounds leftBounds, rightBounds;
    };

    std::span<Reference> all() { return {references_.get(), capacity_}; }
    std::span<Reference> span(const Range& r) { return all().subspan(r.begin, r.size()); }

    RangeBounds makeReferences()
    {
        const size_t n = subset_.count;
        capacity_ = n + static_cast<size_t>(std::max(0.0f, options_.duplicateBudget) *
                                            static_cast<float>(n));
        if (capacity_ > kMaxReferences) {
            throw Error("the scene has " + std::to_string(n) +
                        " triangles: more than the acceleration structure can "
                        "address (" +
                        std::to_string(kMaxReferences) + " with duplicates) — use a smaller scene");
        }
        // Not value-initialised: the room for duplicates should cost memory only once it is used.
        references_.reset(static_cast<Reference*>(
            ::operator new (std::max<size_t>(capacity_, 1) * sizeof(Reference),
                            std::align_val_t{alignof(Reference)})));
        tbb::parallel_for(tbb::blocked_range<size_t>(0, n, 1u << 14),
                          [&](const tbb::blocked_range<size_t>& part) {
                              for (size_t i = part.begin(); i < part.end(); ++i) {
                                  const uint32_t triangle = subset_.at(i);
                                  references_[i] =
                                      Reference::make(bvh::boundsOf(mesh_, triangle), triangle);
                              }
                          });
        return bvh::boundsOf(all().first(n));
    }

    /// Whether so few levels are left that only halving keeps the depth bound.
    static bool mustHalve(size_t count, uint32_t depth)
    {
        const uint32_t levels = static_cast<uint32_t>(std::bit_width(count)) + 1;
        return depth + levels >= shared::kBvhMaxDepth;
    }

    /// Splits a range in two, or leaves it (false) where a leaf is cheaper or allowed and the only
    /// way.
    bool split(Range range, const RangeBounds& bounds, uint32_t depth, Decision& d)
    {
        const size_t n = range.size();
        const bool halve = mustHalve(n, depth);
        Split object = halve ? Split{} : bvh::findObjectSplit(span(range), bounds);
        Split best = object;
        bool spatial = false;
        if (!halve && range.room() > 0 && n > options_.leafSize) {
            const float overlap = bvh::intersection(object.left, object.right).halfArea();
            if (object.axis < 0 || overlap > kMinOverlap * sceneArea_) {
                const Split candidate = bvh::findSpatialSplit(mesh_, span(range), bounds.box);
                spatial = candidate.axis >= 0 && candidate.cost < object.cost;
                if (spatial) best = candidate;
            }
        }
        if (n <= options_.leafSize) {
            const float area = bounds.box.halfArea();
            const float leafCost = options_.triangleCost * static_cast<float>(n) * area;
            if (best.axis < 0 || leafCost <= area + options_.triangleCost * best.cost) return false;
        }
        if (spatial) {
            Range grown = range;
            d.middle = bvh::partitionSpace(mesh_, all(), grown, best, d.leftBounds, d.rightBounds);
            spatial = d.middle > grown.begin && d.middle < grown.end;
            range = grown;
            if (!spatial) d = Decision{};
        } else if (best.axis >= 0) {
            d.middle =
                range.begin + bvh::partitionObjects(span(range), best, d.leftBounds, d.rightBounds);
        }
        if (d.middle <= range.begin || d.middle >= range.end) {
            d.middle = range.begin +
                       bvh::partitionMedian(span(range), bounds, d.leftBounds, d.rightBounds);
        }
        shareRoom(range, d);
        return true;
    }

    /// Gives both sides free room in proportion to their size; the right side moves up behind the
    /// left one's.
    void shareRoom(const Range& range, Decision& d)
    {
        const size_t leftCount = d.middle - range.begin, rightCount = range.end - d.middle;
        const double leftWeight =
            static_cast<double>(leftCount) * static_cast<double>(d.leftBounds.box.halfArea());
        const double rightWeight =
            static_cast<double>(rightCount) * static_cast<double>(d.rightBounds.box.halfArea());
        const double share = leftWeight > 0 ? leftWeight / (leftWeight + rightWeight) : 0.5;
        const size_t leftRoom = static_cast<size_t>(static_cast<double>(range.room()) * share);
        d.left = {range.begin, d.middle, d.middle + leftRoom};
        d.right = {d.middle + leftRoom, d.middle + leftRoom + rightCount, range.capacity};
        const size_t moved = std::min(leftRoom, rightCount);
        std::copy_n(references_.get() + d.middle, moved, references_.get() + d.right.end - moved);
    }

    /// Builds a subtree into `chunk`; returns its reference.
    uint32_t buildInto(Chunk& chunk, const Range& range, const RangeBounds& bounds, uint32_t depth)
    {
        Decision d;
        if (range.size() == 1 || !split(range, bounds, depth, d)) {
            const size_t first = chunk.slots.size();
            const double triangleCost = static_cast<double>(options_.triangleCost);
            for (const Reference& r : span(range)) {
                chunk.slots.push_back(r.triangle());
                chunk.least += static_cast<double>(r.box().halfArea()) * triangleCost;
            }
            chunk.cost += static_cast<double>(bounds.box.halfArea()) *
                          static_cast<double>(range.size()) * triangleCost;
            return leafReference(range.size(), first);
        }
        const size_t node = chunk.nodes.size();
        chunk.nodes.resize(node + 2);
        chunk.depth = std::max(chunk.depth, depth + 1);
        chunk.cost += static_cast<double>(bounds.box.halfArea());
        const uint32_t left = buildInto(chunk, d.left, d.leftBounds, depth + 1);
        const uint32_t right = buildInto(chunk, d.right, d.rightBounds, depth + 1);
        chunk.nodes[node] = grid_->record(d.leftBounds.box, left);
        chunk.nodes[node + 1] = grid_->record(d.rightBounds.box, right);
        return static_cast<uint32_t>(node / 2);
    }

    std::unique_ptr<TaskNode> buildTask(const Range& range, const RangeBounds& bounds,
                                        uint32_t depth)
    {
        auto task = std::make_unique<TaskNode>();
        if (stop_.stop_requested()) return task;
        Decision d;
        if (range.size() <= kTaskSize || !split(range, bounds, depth, d)) {
            task->chunk.nodes.reserve(range.size());
            task->chunk.slots.reserve(range.size() + range.room() / 2);
            if (range.size() > 0) task->chunk.root = buildInto(task->chunk, range, bounds, depth);
            task->chunk.nodes.shrink_to_fit();
            task->chunk.slots.shrink_to_fit();
            progress_.add(range.size());
            return task;
        }
        task->chunk.cost = static_cast<double>(bounds.box.halfArea());
        task->box[0] = d.leftBounds.box;
        task->box[1] = d.rightBounds.box;
        tbb::parallel_invoke(
            [&] { task->child[0] = buildTask(d.left, d.leftBounds, depth + 1); },
            [&] { task->child[1] = buildTask(d.right, d.rightBounds, depth + 1); });
        return task;
    }

    /// Where a tree is appended; the shifts take places in the arrays to numbers in the whole.
    struct Layout {
        std::vector<uvec4>& nodes;
        uint32_t nodeShift;
        std::vector<uint32_t>& slots;
        uint32_t slotShift;
        uint32_t& depth;
        double& cost;
        double& least;
    };

    /// Appends a task's nodes and slots and returns its reference in the whole.
    uint32_t append(Layout& out, TaskNode& task, uint32_t depth)
    {
        out.cost += task.chunk.cost;
        out.least += task.chunk.least;
        out.depth = std::max({out.depth, depth, task.chunk.depth});
        const uint32_t firstNode = static_cast<uint32_t>(out.nodes.size() / 2) + out.nodeShift;
        if (task.child[0]) {
            const size_t node = out.nodes.size();
            out.nodes.resize(node + 2);
            for (size_t i = 0; i < 2; ++i) {
                const uint32_t reference = append(out, *task.child[i], depth + 1);
                out.nodes[node + i] = grid_->record(task.box[i], reference);
                task.child[i].reset();
            }
            out.depth = std::max(out.depth, depth + 1);
            return firstNode;
        }
        const uint32_t firstSlot = static_cast<uint32_t>(out.slots.size()) + out.slotShift;
        const auto relocate = [&](uint32_t reference) {
            return reference + ((reference & shared::kBvhLeaf) != 0 ? firstSlot : firstNode);
        };
        for (uvec4 record : task.chunk.nodes) {
            record.w = relocate(record.w);
            out.nodes.push_back(record);
        }
        out.slots.insert(out.slots.end(), task.chunk.slots.begin(), task.chunk.slots.end());
        return task.chunk.root == shared::kBvhDone ? shared::kBvhDone : relocate(task.chunk.root);
    }

    /// Sum of the sizes of one of the chunks' arrays, plus `perNode` for every node above them.
    template <class T>
    static size_t sizeOf(const TaskNode& task, std::vector<T> Chunk::*array, size_t perNode)
    {
        size_t sum = (task.chunk.*array).size() + (task.child[0] ? perNode : 0);
        for (const auto& child : task.child) {
            if (child) sum += sizeOf(*child, array, perNode);
        }
        return sum;
    }

    struct Free {
        void operator()(Reference* p) const
        {
            ::operator delete (p, std::align_val_t{alignof(Reference)});
        }
    };

    bvh::Mesh mesh_;
    Subset subset_;
    BvhOptions options_;
    BuildProgress& progress_;
    std::stop_token stop_;
    std::unique_ptr<Reference[], Free> references_;
    size_t capacity_ = 0;
    RangeBounds bounds_;
    const Grid* grid_ = nullptr;
    uint32_t depth_ = 0;
    float sceneArea_ = 0;
    std::unique_ptr<TaskNode> top_;
};

Subset movingSubset(const BvhOptions& options)
{
    return {options.moving.begin, ~0u, 0, options.moving.size()};
}

/// Options of the moving triangles' tree.
BvhOptions withoutSplits(BvhOptions options)
{
    options.duplicateBudget = 0;
    return options;
}

/// Both trees' bounds and where motion may lead; not further from the triangles than they are
/// large, as the cells grow with it.
Box gridBounds(Box bounds, const BvhOptions& options)
{
    const Box reach{bvh::asFloat4(options.reachLow), bvh::asFloat4(options.reachHigh)};
    if (reach.empty() || bounds.empty()) return bounds;
    const Float4 size = bounds.high - bounds.low;
    const Box near{bounds.low - size, bounds.high + size};
    bounds.grow(bvh::intersection(reach, near));
    return bounds;
}

/// The root of a tree that stands alone but has no node: a single leaf, or nothing. Leaves are
/// never empty: the traversal tests a triangle first and counts then. So a single leaf stands
/// twice, the second time in a box of one corner, and nothing at all ends the traversal.
std::vector<uvec4> rootOver(const Grid& grid, const Box& box, uint32_t reference)
{
    return {grid.record(box, reference), grid.record(Box{}, reference)};
}

/// Takes over the still triangles' tree; returns what a joining root says of it. Its nodes are
/// numbered behind `room` others, its slots behind `firstSlot`.
uvec4 layOutStill(Bvh& out, Builder& builder, const Grid& grid, size_t room, size_t firstSlot)
{
    uint32_t root = shared::kBvhDone;
    double least = 0;
    out.still = builder.layOut({}, static_cast<uint32_t>(room), static_cast<uint32_t>(firstSlot),
                               root, least);
    const bool alone = room == 0;
    if (alone && out.still.nodes.empty()) out.still.nodes = rootOver(grid, builder.box(), root);
    return grid.record(builder.box(), root);
}

/// Takes over the moving triangles' tree with `room` for nodes, under node 0 beside the other tree
/// if `still` is given.
void layOutMoving(Bvh& out, Builder& builder, const Grid& grid, size_t room, const uvec4* still)
{
    uint32_t root = shared::kBvhDone;
    out.movingLeast = 0;
    std::vector<uvec4> begin(still != nullptr ? 2 : 0);
    const uint32_t firstNode = static_cast<uint32_t>(begin.size() / 2);
    out.moving = builder.layOut(std::move(begin), firstNode, 0, root, out.movingLeast);
    std::vector<uvec4> nodes = out.moving.nodes.toVector();
    if (still != nullptr) {
        nodes[0] = grid.record(builder.box(), root);
        nodes[1] = *still;
    } else if (nodes.empty()) {
        nodes = rootOver(grid, builder.box(), root);
    }
    out.movingNodes = static_cast<uint32_t>(nodes.size() / 2);
    nodes.resize(2 * room, uvec4(0));
    out.moving.nodes = std::move(nodes);
    out.movingRatio = out.movingLeast > 0 ? out.moving.cost / out.movingLeast : 1;
}

}  // namespace

Bvh buildBvh(std::span<const glm::vec3> positions, std::span<const WorldTriangle> triangles,
             const BvhOptions& options, const std::function<void(double)>& progress,
             std::stop_token stop)
{
    CHECK(options.leafSize >= 1 && options.leafSize <= shared::kBvhCountMask - 1);
    CHECK(options.moving.begin <= options.moving.end && options.moving.end <= triangles.size());
    const bvh::Mesh mesh{positions, triangles};
    const size_t movingCount = options.moving.size(), stillCount = triangles.size() - movingCount;
    const bool joined = movingCount > 0 && stillCount > 0;
    BuildProgress reports(progress, triangles.size());
    Builder moving(mesh, movingSubset(options), withoutSplits(options), reports, stop);
    Builder still(mesh, {0, options.moving.begin, options.moving.size(), stillCount}, options,
                  reports, stop);
    Box bounds = still.box();
    bounds.grow(moving.box());
    const Grid grid(gridBounds(bounds, options));
    if (movingCount > 0) moving.build(grid, joined ? 1 : 0);
    if (stillCount > 0 || movingCount == 0) still.build(grid, joined ? 1 : 0);
    if (stop.stop_requested()) return {};

    Bvh out;
    out.gridLow = grid.low;
    out.gridScale = grid.scale;
    out.triangleCost = options.triangleCost;
    // A tree over other positions of the same triangles has a few more nodes, or a few less.
    const size_t needed = movingCount > 0 ? moving.nodeCount() + 1 : 0;
    const size_t room = needed + needed / 4;
    uvec4 stillRecord(0);
    if (stillCount > 0 || movingCount == 0)
        stillRecord = layOutStill(out, still, grid, room, movingCount);
    if (movingCount > 0) layOutMoving(out, moving, grid, room, joined ? &stillRecord : nullptr);
    bvh::sumUp(out);
    if (progress) progress(1.0);
    return out;
}

std::optional<Bvh> rebuildMoving(const Bvh& bvh, std::span<const glm::vec3> positions,
                                 std::span<const WorldTriangle> triangles,
                                 const BvhOptions& options)
{
    const std::function<void(double)> quiet;
    BuildProgress reports(quiet, triangles.size());
    Builder moving({positions, triangles}, movingSubset(options), withoutSplits(options), reports,
                   {});
    const Grid grid(bvh.gridLow, bvh.gridScale);
    if (!grid.holds(moving.box())) return std::nullopt;
    const bool joined = !bvh.still.slots.empty();
    moving.build(grid, joined ? 1 : 0);
    const size_t room = bvh.moving.nodes.size() / 2;
    if (moving.nodeCount() + 1 > room) return std::nullopt;
    Bvh out = bvh;
    layOutMoving(out, moving, grid, room, joined ? &bvh.moving.nodes[1] : nullptr);
    bvh::sumUp(out);
    return out;
}

}  // namespace core
