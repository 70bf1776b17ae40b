// One walk from the root settles the structure and notes the leaves with their boxes; whether these
// hold the triangles is then asked of all leaves at once. See bvh_check.h.
#include "core/trace/bvh_check.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "core/base/parallel.h"
#include "core/scene/instances.h"
#include "core/trace/bvh_grid.h"
#include "core/trace/bvh_instances.h"
#include "core/trace/bvh_traverse.h"

namespace core {
namespace {

using bvh::Box;
using bvh::Grid;
using shared::uvec4;

bool contains(const IndexRange& range, uint32_t index)
{
    return index >= range.begin && index < range.end;
}

bool isGrid(const Grid& grid)
{
    bool fine = true;
    for (int a = 0; a < 3; ++a)
        fine =
            fine && std::isfinite(grid.low[a]) && std::isfinite(grid.scale[a]) && grid.scale[a] > 0;
    return fine;
}

/// The cells that all boxes on a way down have in common, as a record has them.
struct Cells {
    uint32_t grid;  // index of it
    glm::uvec3 box{0xffff0000u};

    /// Those of a record, too.
    Cells within(const uvec4& record) const
    {
        Cells cells = *this;
        for (int a = 0; a < 3; ++a)
            cells.box[a] = std::max(box[a] & 0xffffu, record[a] & 0xffffu) |
                           std::min(box[a] >> 16, record[a] >> 16) << 16;
        return cells;
    }
    bool holds(const uvec4& record) const
    {
        bool inside = true;
        for (int a = 0; a < 3; ++a)
            inside = inside && (record[a] & 0xffffu) >= (box[a] & 0xffffu) &&
                     record[a] >> 16 <= box[a] >> 16;
        return inside;
    }
};

/// A grid, and the cells of the one around that lead to it.
struct GridLevel {
    Grid grid;
    Cells around{shared::kNone};  // its grid kNone: nothing is around
};

/// A tree of the hierarchy: which of all nodes, slots and triangles may be its own.
struct Tree {
    IndexRange nodes, slots, triangles;
    IndexRange without{};  // of the triangles
    bool ofWorld = true;   // may have instances

    bool mayHold(uint32_t triangle) const
    {
        return contains(triangles, triangle) && !contains(without, triangle);
    }
};

class Check {
public:
    Check(const Bvh& bvh, const bvh::Mesh& mesh, const BvhOptions& options)
        : bvh_(bvh), mesh_(mesh), options_(options), usedNodes_(bvh.nodeCount()),
          usedSlots_(bvh.slotCount()), ways_(options.prototypes.size(), shared::kNone),
          depths_(options.prototypes.size())
    {}

    bool run() { return sizesFit() && factsFit() && worldFits() && prototypesFit() && allUsed(); }

private:
    struct Leaf {
        uint32_t slot, count;
        Cells cells;
    };

    bool sizesFit();
    bool factsFit() const;
    bool worldFits();
    bool prototypesFit();
    bool allUsed();
    bool leavesHold();

    bool walk(const Tree& tree, uint32_t reference, uint32_t parent, uint32_t depth,
              const Cells& cells);
    bool walkNode(const Tree& tree, uint32_t node, uint32_t depth, const Cells& cells);
    bool walkChange(const Tree& tree, uint32_t node, uint32_t depth, const Cells& cells);
    bool takeInstance(const Tree& tree, uint32_t node, uint32_t depth, const Cells& cells);
    bool takeLeaf(const Tree& tree, uint32_t reference, const Cells& cells);
    bool takeNodes(const Tree& tree, uint32_t first, uint32_t count);
    bool repeatsRoot(uint32_t node) const;
    bool leadsBack(const uvec4* words, const Cells& cells, uint32_t kind) const;
    uint32_t prototypeOf(uint32_t instance) const;
    Cells enter(const Grid& grid, const Cells& around);
    bool hold(Cells cells, const Box& box) const;

    const Bvh& bvh_;
    const bvh::Mesh& mesh_;
    const BvhOptions& options_;
    std::vector<uint8_t> usedNodes_, usedSlots_;
    std::vector<bvh::InstanceLeaf> instances_;
    std::vector<uint8_t> usedInstances_;
    std::vector<InstanceSlots> slots_;  // of each prototype's instances
    std::vector<uint32_t> ways_;        // the node that leads to each prototype's root
    std::vector<uint32_t> depths_;      // of the deepest instance of each prototype
    std::vector<GridLevel> grids_;
    std::vector<Leaf> leaves_;
    uint32_t changesOfMoving_ = 0, changes_ = 0;
    uint32_t deepest_ = 0;
};

/// The arrays among themselves: what may be relied on from here on.
bool Check::sizesFit()
{
    const size_t moving = bvh_.moving.nodes.size(), still = bvh_.still.nodes.size();
    const size_t nodes = bvh_.nodeCount(), slots = bvh_.slotCount();
    const size_t prototypes = options_.prototypes.size();
    if (moving % 2 != 0 || still % 2 != 0 || nodes == 0 || slots == 0) return false;
    if (nodes > shared::kBvhIndexMask || slots > shared::kBvhIndexMask) return false;
    if (bvh_.movingNodes > moving / 2 || (bvh_.movingNodes == 0) != (moving == 0)) return false;
    if (bvh_.moving.slots.empty() != options_.moving.empty()) return false;
    if (bvh_.moving.slots.empty() != (moving == 0)) return false;
    if (bvh_.prototypeSlots.size() != prototypes) return false;
    size_t next = bvh_.moving.slots.size();  // one behind the other
    for (const IndexRange& range : bvh_.prototypeSlots) {
        if (range.begin != next || range.end <= range.begin || range.end > slots) return false;
        next = range.end;
    }
    if (prototypes == 0) return true;
    auto found = instanceSlots(options_.prototypes, bvh_.prototypeSlots);
    if (!found) return false;
    slots_ = *std::move(found);
    instances_ = bvh::makeInstanceLeaves(mesh_, options_);
    usedInstances_.resize(instances_.size());
    return true;
}

/// What is said of the whole and of its parts.
bool Check::factsFit() const
{
    const auto isCount = [](double x) { return std::isfinite(x) && x >= 0; };
    const auto isFine = [&](const BvhPart& part) {
        const auto isPlace = [](float x) { return std::isfinite(x); };
        bool fine = isCount(part.cost) && part.depth <= shared::kBvhMaxDepth;
        for (int a = 0; a < 3; ++a) fine = fine && isPlace(part.low[a]) && isPlace(part.high[a]);
        return fine;
    };
    return isFine(bvh_.moving) && isFine(bvh_.still) && bvh_.depth <= shared::kBvhMaxDepth &&
           isCount(static_cast<double>(bvh_.cost)) && bvh_.triangleCost == options_.triangleCost &&
           isCount(bvh_.movingLeast) && isCount(bvh_.movingRatio) &&
           isGrid({bvh_.gridLow, bvh_.gridScale});
}

/// The trees of what moves and of what rests, one of which may hold the root of both.
bool Check::worldFits()
{
    const auto flat = static_cast<uint32_t>(options_.prototypes.empty()
                                                ? mesh_.triangles.size()
                                                : options_.prototypes.front().triangles.begin);
    const auto room = static_cast<uint32_t>(bvh_.moving.nodes.size() / 2);
    const auto nodes = static_cast<uint32_t>(bvh_.nodeCount());
    const auto slots = static_cast<uint32_t>(bvh_.slotCount());
    const auto movingSlots = static_cast<uint32_t>(bvh_.moving.slots.size());
    const uint32_t stillSlots =
        bvh_.prototypeSlots.empty() ? movingSlots : bvh_.prototypeSlots.back().end;
    const Tree moving{{0, bvh_.movingNodes}, {0, movingSlots}, options_.moving, {}, false};
    const Tree still{{room, nodes}, {stillSlots, slots}, {0, flat}, options_.moving};
    const Cells all = enter({bvh_.gridLow, bvh_.gridScale}, {shared::kNone});
    const bool joined = room > 0 && bvh_.still.nodes.size() > 0;
    if (!joined) return walkNode(room > 0 ? moving : still, 0, 0, all);
    const uvec4* root = bvh_.node(0);
    return takeNodes(moving, 0, 1) && walk(moving, root[0].w, 0, 1, all.within(root[0])) &&
           walk(still, root[1].w, 0, 1, all.within(root[1]));
}

/// The trees that instances have led to.
bool Check::prototypesFit()
{
    const Tree still{{static_cast<uint32_t>(bvh_.moving.nodes.size() / 2),
                      static_cast<uint32_t>(bvh_.nodeCount())},
                     {},
                     {}};
    for (size_t p = 0; p < ways_.size(); ++p) {
        const uint32_t way = ways_[p];
        if (way == shared::kNone || !takeNodes(still, way, 1)) return false;
        const uvec4* words = bvh_.node(way);
        const Grid grid(bvh::vectorIn(words[0]), bvh::vectorIn(words[1]));
        const Tree tree{
            still.nodes, bvh_.prototypeSlots[p], options_.prototypes[p].triangles, {}, false};
        if (words[1].w != shared::kBvhDone || !isGrid(grid) ||
            !walk(tree, words[0].w, way, depths_[p] + 1, enter(grid, {shared::kNone})))
            return false;
    }
    return true;
}

/// Every node, slot and instance that there is has been met, and every triangle is where it is said
/// to be.
bool Check::allUsed()
{
    const auto isUsed = [](uint8_t used) { return used != 0; };
    const auto room = static_cast<std::ptrdiff_t>(bvh_.moving.nodes.size() / 2);
    return std::all_of(usedNodes_.begin(), usedNodes_.begin() + bvh_.movingNodes, isUsed) &&
           std::all_of(usedNodes_.begin() + room, usedNodes_.end(), isUsed) &&
           std::ranges::all_of(usedSlots_, isUsed) && std::ranges::all_of(usedInstances_, isUsed) &&
           changesOfMoving_ == bvh_.moving.gridChanges && changes_ == bvh_.still.gridChanges &&
           deepest_ <= shared::kBvhMaxDepth && leavesHold();
}

/// Whether the leaves' boxes hold the corners of their triangles. Of a triangle that is in several
/// leaves each corner is in one of them at least.
bool Check::leavesHold()
{
    std::vector<uint8_t> found(mesh_.triangles.size());  // corners: a bit for each
    parallelFor(leaves_.size(), 1 << 10, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const Leaf& leaf = leaves_[i];
            for (uint32_t slot = leaf.slot; slot < leaf.slot + leaf.count; ++slot) {
                const uint32_t triangle = bvh_.triangle(slot);
                const WorldTriangle& t = mesh_.triangles[triangle];
                const uint32_t vertices[3] = {t.v0, t.v1, t.v2};
                uint32_t corners = 0;
                for (uint32_t k = 0; k < 3; ++k) {
                    const bvh::Float4 p = bvh::load(mesh_.positions[vertices[k]]);
                    if (hold(leaf.cells, {p, p})) corners |= 1u << k;
                }
                std::atomic_ref(found[triangle])
                    .fetch_or(static_cast<uint8_t>(corners), std::memory_order_relaxed);
            }
        }
    });
    return std::ranges::all_of(found, [](uint8_t bits) { return bits == 7; });
}

/// Whether nodes exist, of that tree, and have not been met before.
bool Check::takeNodes(const Tree& tree, uint32_t first, uint32_t count)
{
    for (uint32_t node = first; node < first + count; ++node) {
        if (!contains(tree.nodes, node) || usedNodes_[node] != 0) return false;
        usedNodes_[node] = 1;
    }
    return true;
}

/// What a reference of node `parent` leads to; `depth` nodes are above it. Children are numbered
/// behind their parents, as refits demand.
bool Check::walk(const Tree& tree, uint32_t reference, uint32_t parent, uint32_t depth,
                 const Cells& cells)
{
    if (reference == shared::kBvhDone || depth > shared::kBvhMaxDepth) return false;
    const bool changes = bvh::changesGrid(reference);
    if (!changes && (reference & shared::kBvhLeaf) != 0) return takeLeaf(tree, reference, cells);
    // Of a node the reference is the number: nothing is masked when it is followed.
    const uint32_t node = changes ? reference & shared::kBvhIndexMask : reference;
    if (node <= parent || !contains(tree.nodes, node)) return false;
    if (!changes) return walkNode(tree, node, depth, cells);
    // A way consists of two nodes at least, which do not lie in two arrays.
    if (!contains(tree.nodes, node + 1)) return false;
    return bvh_.node(node)[1].w == shared::kBvhInstance ? takeInstance(tree, node, depth, cells)
                                                        : walkChange(tree, node, depth, cells);
}

/// A root over a single child has it twice, the second time in a box of one corner.
bool Check::repeatsRoot(uint32_t node) const
{
    const uvec4* children = bvh_.node(node);
    const uvec4& second = children[1];
    return node == 0 && children[0].w == second.w && second.x == 0 && second.y == 0 &&
           second.z == 0;
}

bool Check::walkNode(const Tree& tree, uint32_t node, uint32_t depth, const Cells& cells)
{
    if (!takeNodes(tree, node, 1)) return false;
    deepest_ = std::max(deepest_, depth + 1);
    const uvec4* children = bvh_.node(node);
    for (uint32_t k = 0; k < (repeatsRoot(node) ? 1u : 2u); ++k) {
        if (!walk(tree, children[k].w, node, depth + 1, cells.within(children[k]))) return false;
    }
    return true;
}

bool Check::leadsBack(const uvec4* words, const Cells& cells, uint32_t kind) const
{
    uvec4 expected[2];
    bvh::writeWayBack(expected, grids_[cells.grid].grid, kind);
    return words[0] == expected[0] && words[1] == expected[1];
}

/// All cells of a grid within those of another one.
Cells Check::enter(const Grid& grid, const Cells& around)
{
    grids_.push_back({grid, around});
    return {static_cast<uint32_t>(grids_.size() - 1)};
}

/// Whether a box lies in the cells, and in those that lead to their grid.
bool Check::hold(Cells cells, const Box& box) const
{
    for (; cells.grid != shared::kNone; cells = grids_[cells.grid].around)
        if (!cells.holds(grids_[cells.grid].grid.record(box, 0))) return false;
    return true;
}

bool Check::walkChange(const Tree& tree, uint32_t node, uint32_t depth, const Cells& cells)
{
    const uvec4* words = bvh_.node(node);
    if (words[1].w != shared::kBvhDone || !takeNodes(tree, node, 2) ||
        !leadsBack(words + 2, cells, shared::kBvhDone))
        return false;
    ++(node < bvh_.moving.nodes.size() / 2 ? changesOfMoving_ : changes_);
    const Grid finer(bvh::vectorIn(words[0]), bvh::vectorIn(words[1]));
    return isGrid(finer) && walk(tree, words[0].w, node, depth + 1, enter(finer, cells));
}

uint32_t Check::prototypeOf(uint32_t instance) const
{
    const auto& all = options_.prototypes;
    const auto it = std::ranges::upper_bound(
        all, instance, {}, [](const Prototype& prototype) { return prototype.instances.begin; });
    return static_cast<uint32_t>(it - all.begin()) - 1;
}

/// The words of an instance are those that the builder would write.
bool Check::takeInstance(const Tree& tree, uint32_t node, uint32_t depth, const Cells& cells)
{
    if (!tree.ofWorld || !takeNodes(tree, node, 3)) return false;
    const uvec4* words = bvh_.node(node);
    const uint32_t way = words[0].w, instance = words[3].w - 1;
    if (instance >= instances_.size() || usedInstances_[instance] != 0) return false;
    usedInstances_[instance] = 1;
    const uint32_t p = prototypeOf(instance);
    if (ways_[p] == shared::kNone) ways_[p] = way;
    const uint32_t first = options_.prototypes[p].instances.begin;
    const uint32_t offset = slots_[p].at(instance - first) - bvh_.prototypeSlots[p].begin;
    const auto expected = wayInto(options_.instances[instance], way, offset, instance + 1);
    depths_[p] = std::max(depths_[p], depth + 1);
    return way == ways_[p] && std::equal(expected.begin(), expected.end(), words) &&
           leadsBack(words + 4, cells, shared::kBvhWorld) && hold(cells, instances_[instance].box);
}

bool Check::takeLeaf(const Tree& tree, uint32_t reference, const Cells& cells)
{
    const uint32_t count = (reference >> shared::kBvhCountShift) & shared::kBvhCountMask;
    const uint32_t first = reference & shared::kBvhIndexMask;
    if (count == 0 || count > options_.leafSize) return false;
    for (uint32_t slot = first; slot < first + count; ++slot) {
        if (!contains(tree.slots, slot) || usedSlots_[slot] != 0 ||
            !tree.mayHold(bvh_.triangle(slot)))
            return false;
        usedSlots_[slot] = 1;
    }
    leaves_.push_back({first, count, cells});
    return true;
}

}  // namespace

bool isSound(const Bvh& bvh, std::span<const glm::vec3> positions,
             std::span<const WorldTriangle> triangles, const BvhOptions& options)
{
    const bvh::Mesh mesh{positions, triangles};
    return Check(bvh, mesh, options).run();
}

}  // namespace core
