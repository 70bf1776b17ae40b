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
#include "core/trace/bvh_split.h"

namespace core {
namespace {

using bvh::Box;
using bvh::Float4;
using bvh::Range;
using bvh::RangeBounds;
using bvh::Reference;
using bvh::Split;
using shared::uvec4;

constexpr size_t kTaskSize = 1u << 12;  // references below which one task builds the whole subtree
constexpr size_t kMaxReferences = 1u << 27;  // what a child reference can address
constexpr float kGridCells = 65533.0f;       // leaves one cell of rounding on either side
constexpr float kGridSlack = 0.02f;          // cells; covers the rounding of the ray's side
// Stich et al.'s alpha: overlap area over scene area worth a spatial split
constexpr float kMinOverlap = 1e-5f;

/// World to grid cells, in double so that only the ray's side rounds.
struct Grid {
    glm::vec3 low{0}, scale{1};

    explicit Grid(const Box& bounds)
    {
        if (bounds.empty()) return;
        const Float4 e = bounds.high - bounds.low;
        // A flat axis gets cells in proportion to the other axes and to its place, so that neither
        // the scale overflows nor a cell is finer than rounding can tell.
        const float size = std::max({e[0], e[1], e[2]});
        float place = 0;
        for (int a = 0; a < 3; ++a) {
            place = std::max({place, std::abs(bounds.low[a]), std::abs(bounds.high[a])});
        }
        const float floorExtent = std::max({size / 65536.0f, place * 1e-6f, 1e-30f});
        for (int a = 0; a < 3; ++a) {
            const float extent = std::max(e[a], floorExtent);
            scale[a] = kGridCells / extent;
            low[a] = bounds.low[a] - extent / kGridCells;
        }
    }
    uint32_t cell(float x, int axis, bool up) const
    {
        const double q = (static_cast<double>(x) - static_cast<double>(low[axis])) *
                         static_cast<double>(scale[axis]);
        const double slack = static_cast<double>(kGridSlack);
        const double rounded = up ? std::ceil(q + slack) : std::floor(q - slack);
        return static_cast<uint32_t>(std::clamp(rounded, 0.0, 65535.0));
    }
    uvec4 record(const Box& box, uint32_t reference) const
    {
        uvec4 r(0, 0, 0, reference);
        if (box.empty()) return r;
        for (int a = 0; a < 3; ++a)
            r[a] = cell(box.low[a], a, false) | (cell(box.high[a], a, true) << 16);
        return r;
    }
};

/// A finished subtree with node and slot numbers of its own, root reference included.
struct Chunk {
    std::vector<uvec4> nodes;
    std::vector<uint32_t> slots;
    uint32_t root = shared::kBvhDone;
    uint32_t depth = 0;
    double cost = 0;  // sum of half areas times tests
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

class Builder {
public:
    Builder(const bvh::Mesh& mesh, const BvhOptions& options,
            const std::function<void(double)>& progress, std::stop_token stop)
        : mesh_(mesh), options_(options), progress_(progress), stop_(std::move(stop))
    {}

    Bvh build()
    {
        const RangeBounds bounds = makeReferences();
        grid_ = std::make_unique<Grid>(bounds.box);
        sceneArea_ = bounds.box.halfArea();
        const std::unique_ptr<TaskNode> top =
            buildTask({0, mesh_.triangles.size(), capacity_}, bounds, 0);
        references_.reset();
        if (stop_.stop_requested()) return {};
        return assemble(*top, bounds.box);
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
        const size_t n = mesh_.triangles.size();
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
                                  const WorldTriangle& t = mesh_.triangles[i];
                                  Box box;
                                  for (const uint32_t v : {t.v0, t.v1, t.v2}) {
                                      const glm::vec3& p = mesh_.positions[v];
                                      box.grow(Float4{p.x, p.y, p.z, 0});
                                  }
                                  references_[i] = Reference::make(box, static_cast<uint32_t>(i));
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
            for (const Reference& r : span(range)) chunk.slots.push_back(r.triangle());
            chunk.cost += static_cast<double>(bounds.box.halfArea()) *
                          static_cast<double>(range.size()) *
                          static_cast<double>(options_.triangleCost);
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
            report(range.size());
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

    void report(size_t references)
    {
        const size_t done = done_.fetch_add(references) + references;
        if (!progress_) return;
        const std::unique_lock lock(progressMutex_, std::try_to_lock);
        if (!lock.owns_lock()) return;
        // Duplicates can make it more than one.
        const double fraction =
            std::min(1.0, static_cast<double>(done) /
                              static_cast<double>(std::max<size_t>(mesh_.triangles.size(), 1)));
        if (fraction < reported_ + 0.01) return;
        reported_ = fraction;
        progress_(fraction);
    }

    /// Appends a task's nodes and slots and returns its reference in the whole.
    uint32_t append(Bvh& out, TaskNode& task, uint32_t depth, double& cost)
    {
        cost += task.chunk.cost;
        out.depth = std::max({out.depth, depth, task.chunk.depth});
        if (task.child[0]) {
            const size_t node = out.nodes.size();
            out.nodes.resize(node + 2);
            for (size_t i = 0; i < 2; ++i) {
                const uint32_t reference = append(out, *task.child[i], depth + 1, cost);
                out.nodes[node + i] = grid_->record(task.box[i], reference);
                task.child[i].reset();
            }
            out.depth = std::max(out.depth, depth + 1);
            return static_cast<uint32_t>(node / 2);
        }
        const uint32_t firstNode = static_cast<uint32_t>(out.nodes.size() / 2);
        const uint32_t firstSlot = static_cast<uint32_t>(out.slots.size());
        const auto relocate = [&](uint32_t reference) {
            return reference + ((reference & shared::kBvhLeaf) != 0 ? firstSlot : firstNode);
        };
        for (uvec4 record : task.chunk.nodes) {
            record.w = relocate(record.w);
            out.nodes.push_back(record);
        }
        out.slots.insert(out.slots.end(), task.chunk.slots.begin(), task.chunk.slots.end());
        return relocate(task.chunk.root);
    }

    static void count(const TaskNode& task, size_t& nodes, size_t& slots)
    {
        nodes += task.chunk.nodes.size() + (task.child[0] ? 2 : 0);
        slots += task.chunk.slots.size();
        for (const auto& child : task.child) {
            if (child) count(*child, nodes, slots);
        }
    }

    Bvh assemble(TaskNode& top, const Box& bounds)
    {
        Bvh out;
        out.gridLow = grid_->low;
        out.gridScale = grid_->scale;
        size_t nodes = 0, slots = 0;
        count(top, nodes, slots);
        out.nodes.reserve(std::max<size_t>(nodes, 2));
        out.slots.reserve(slots);
        double cost = 0;
        const uint32_t root = append(out, top, 0, cost);
        if (out.nodes.empty()) {  // a single leaf, or nothing
            // Leaves are never empty: the traversal tests a triangle first and counts then. So a
            // single leaf stands twice, the second time in a box of one corner, and nothing at all
            // ends the traversal.
            const uint32_t reference = slots == 0 ? shared::kBvhDone : root;
            out.nodes = {grid_->record(bounds, reference), grid_->record(Box{}, reference)};
            out.depth = 1;
        }
        if (sceneArea_ > 0) out.cost = static_cast<float>(cost / static_cast<double>(sceneArea_));
        if (progress_) progress_(1.0);
        return out;
    }

    struct Free {
        void operator()(Reference* p) const
        {
            ::operator delete (p, std::align_val_t{alignof(Reference)});
        }
    };

    bvh::Mesh mesh_;
    BvhOptions options_;
    const std::function<void(double)>& progress_;
    std::stop_token stop_;
    std::unique_ptr<Reference[], Free> references_;
    size_t capacity_ = 0;
    std::unique_ptr<Grid> grid_;
    float sceneArea_ = 0;
    std::atomic<size_t> done_{0};
    std::mutex progressMutex_;
    double reported_ = 0;
};

}  // namespace

Bvh buildBvh(std::span<const glm::vec3> positions, std::span<const WorldTriangle> triangles,
             const BvhOptions& options, const std::function<void(double)>& progress,
             std::stop_token stop)
{
    CHECK(options.leafSize >= 1 && options.leafSize <= shared::kBvhCountMask - 1);
    return Builder({positions, triangles}, options, progress, std::move(stop)).build();
}

}  // namespace core
