// See bvh_builder.h.
#include "core/trace/bvh_builder.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/base/parallel.h"

namespace core::bvh {
namespace {

using shared::uvec4;

constexpr size_t kTaskSize = 1u << 12;  // references below which one task builds the whole subtree
// Stich et al.'s alpha: overlap area over the area of the region worth a spatial split
constexpr float kMinOverlap = 1e-5f;
// Fewer references share a few leaves: not worth a scale of their own.
constexpr size_t kMinRegion = 64;
// How many times smaller than the whole the small ones' box must be in a split of scales. Scenes
// without far geometry then have next to none: their trees are built for what is seen, and 16 or 64
// change no count of tests by a thousandth.
constexpr float kMinStep = 16;
constexpr float kEqualCosts = 1e-3f;

bool partsScales(SplitKind kind)
{
    return kind == SplitKind::size || kind == SplitKind::reach;
}

uint32_t leafReference(size_t count, size_t firstSlot)
{
    return shared::kBvhLeaf | static_cast<uint32_t>(count) << shared::kBvhCountShift |
           static_cast<uint32_t>(firstSlot);
}

}  // namespace

Error tooLarge(size_t triangles)
{
    return Error("the scene has " + std::to_string(triangles) +
                 " triangles: more than the acceleration structure can address (" +
                 std::to_string(kMaxReferences) + ") — use a smaller scene");
}

void BuildProgress::add(size_t references)
{
    const size_t done = done_.fetch_add(references) + references;
    if (!callback_) return;
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock.owns_lock()) return;
    // Duplicates can make it more than one.
    const double fraction = std::min(1.0, static_cast<double>(done) / static_cast<double>(total_));
    if (fraction < reported_ + 0.01) return;
    reported_ = fraction;
    callback_(fraction);
}

Builder::Builder(const Mesh& mesh, const Subset& subset, const BvhOptions& options,
                 BuildProgress& progress, std::stop_token stop)
    : mesh_(mesh), subset_(subset), options_(options), progress_(progress), stop_(std::move(stop))
{
    bounds_ = makeReferences();
}

void Builder::build(const Grid& grid, uint32_t depth)
{
    grid_ = grid;
    depth_ = depth;
    top_ = buildTask({0, subset_.count, capacity_}, bounds_, depth, {grid, bounds_.box.halfArea()});
    references_.reset();
}

RangeBounds Builder::makeReferences()
{
    const size_t n = subset_.count;
    capacity_ =
        n + static_cast<size_t>(std::max(0.0f, options_.duplicateBudget) * static_cast<float>(n));
    if (n > kMaxReferences) throw tooLarge(n);
    capacity_ = std::min<size_t>(capacity_, kMaxReferences);
    // Not value-initialised: the room for duplicates should cost memory only once it is used.
    references_.reset(static_cast<Reference*>(::operator new (
        std::max<size_t>(capacity_, 1) * sizeof(Reference), std::align_val_t{alignof(Reference)})));
    parallelFor(n, 1u << 14, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const uint32_t triangle = subset_.at(i);
            references_[i] = Reference::make(boundsOf(mesh_, triangle), triangle);
        }
    });
    return boundsOf(all().first(n));
}

/// Whether so few levels are left that only halving keeps the depth bound.
bool Builder::mustHalve(size_t count, uint32_t depth) const
{
    const uint32_t levels = static_cast<uint32_t>(std::bit_width(count)) + 1;
    return depth + levels >= options_.maxDepth;
}

/// Instances are leaves of their own, and are not cut.
bool Builder::holdsInstances(const Range& range)
{
    if (mesh_.instances.empty()) return false;
    const std::span<const Reference> references = span(range);
    return std::any_of(references.begin(), references.end(),
                       [&](const Reference& r) { return mesh_.instance(r.triangle()) != nullptr; });
}

/// A region with a grid of its own for references that are too small for the present one, or where
/// rays are to begin. Not for the root of the whole.
std::optional<Builder::Region> Builder::finerRegion(const Range& range, const RangeBounds& bounds,
                                                    uint32_t depth, const Region& region) const
{
    if (range.size() < kMinRegion || depth == 0 || mustHalve(range.size(), depth + 1) ||
        !(region.begins || region.grid.isCoarseFor(bounds.box, range.size(), subset_.count)))
        return std::nullopt;
    return Region{Grid(bounds.box), bounds.box.halfArea()};
}

/// The cheapest of all kinds; none where the references cannot be told apart. Where rays may begin
/// in a part, `parts`, one may lie within the rest.
Split Builder::bestSplit(const Range& range, const RangeBounds& bounds, const Region& region,
                         bool parts)
{
    const size_t n = range.size();
    Split best = findObjectSplit(span(range), bounds);
    const float overlap = intersection(best.left, best.right).halfArea();
    const bool mayCut = range.room() > 0 && n > options_.leafSize &&
                        (best.axis < 0 || overlap > kMinOverlap * region.area) &&
                        !holdsInstances(range);
    if (n >= kMinRegion) {
        // Where a plane parts them as well, it is still two scales that are parted.
        const auto consider = [&](const Split& split) {
            if (split.cost <= best.cost * (1 + kEqualCosts) &&
                kMinStep * split.left.extent() <= bounds.box.extent())
                best = split;
        };
        consider(findSizeSplit(span(range), bounds));
        if (parts) consider(findReachSplit(span(range), bounds));
    }
    if (mayCut) {
        const Split spatial = findSpatialSplit(mesh_, span(range), bounds.box);
        if (spatial.cost < best.cost) best = spatial;
    }
    return best;
}

/// Splits a range in two, or leaves it (false) where a leaf is cheaper or allowed and the only way.
bool Builder::split(Range range, const RangeBounds& bounds, uint32_t depth, const Region& region,
                    Decision& d)
{
    const size_t n = range.size();
    const Split best =
        mustHalve(n, depth) ? Split{} : bestSplit(range, bounds, region, beginsBelow(depth));
    if (n <= options_.leafSize && !holdsInstances(range)) {
        const float area = bounds.box.halfArea();
        const float leafCost = options_.triangleCost * static_cast<float>(n) * area;
        if (best.axis < 0 || leafCost <= area + options_.triangleCost * best.cost) return false;
    }
    d.kind = best.kind;
    if (best.axis >= 0 && best.kind == SplitKind::space) {
        Range grown = range;
        d.middle = partitionSpace(mesh_, all(), grown, best, d.leftBounds, d.rightBounds);
        const bool cut = d.middle > grown.begin && d.middle < grown.end;
        range = grown;
        if (!cut) d = Decision{};
    } else if (best.axis >= 0) {
        d.middle = range.begin + partitionObjects(span(range), best, d.leftBounds, d.rightBounds);
    }
    if (d.middle <= range.begin || d.middle >= range.end) {
        d.kind = SplitKind::centroid;
        d.middle = range.begin + partitionMedian(span(range), bounds, d.leftBounds, d.rightBounds);
    }
    shareRoom(range, d);
    return true;
}

/// Whether rays may begin below a node: see entryOf.
bool Builder::beginsBelow(uint32_t depth) const
{
    return depth == depth_ && options_.moving.empty();
}

/// What a split of scales sets apart has an area of its own to judge overlaps by. At the root rays
/// begin in there, so that those inside do not come across what surrounds it: of a dome, which no
/// box keeps away from its middle, some twenty nodes.
Builder::Region Builder::leftRegion(const Decision& d, uint32_t depth, const Region& region) const
{
    if (!partsScales(d.kind)) return region;
    return {region.grid, d.leftBounds.box.halfArea(), beginsBelow(depth)};
}

/// Gives both sides free room in proportion to their cost; the right side moves up behind the left
/// one's. Two scales share it by their numbers: where rays are among the small ones, the area of
/// the large ones is no measure of what they meet.
void Builder::shareRoom(const Range& range, Decision& d)
{
    const size_t leftCount = d.middle - range.begin, rightCount = range.end - d.middle;
    const bool scales = partsScales(d.kind);
    const auto weight = [&](size_t count, const Box& box) {
        return static_cast<double>(count) * (scales ? 1.0 : static_cast<double>(box.halfArea()));
    };
    const double left = weight(leftCount, d.leftBounds.box);
    const double right = weight(rightCount, d.rightBounds.box);
    const double share = left > 0 ? left / (left + right) : 0.5;
    const size_t leftRoom = static_cast<size_t>(static_cast<double>(range.room()) * share);
    d.left = {range.begin, d.middle, d.middle + leftRoom};
    d.right = {d.middle + leftRoom, d.middle + leftRoom + rightCount, range.capacity};
    const size_t moved = std::min(leftRoom, rightCount);
    std::copy_n(references_.get() + d.middle, moved, references_.get() + d.right.end - moved);
}

/// Builds a subtree into `chunk`; returns its reference.
uint32_t Builder::buildInto(Chunk& chunk, const Range& range, const RangeBounds& bounds,
                            uint32_t depth, const Region& region)
{
    const size_t node = chunk.nodes.size();
    if (const auto finer = finerRegion(range, bounds, depth, region)) {
        chunk.nodes.resize(node + 4);
        ++chunk.gridChanges;
        const uint32_t root = buildInto(chunk, range, bounds, depth + 1, *finer);
        writeGridChange(&chunk.nodes[node], finer->grid, region.grid, root);
        return gridReference(node / 2);
    }
    Decision d;
    if (range.size() == 1) {
        const InstanceLeaf* instance = mesh_.instance(references_[range.begin].triangle());
        if (instance != nullptr) return buildInstance(chunk, *instance, depth, region.grid);
    }
    if (range.size() == 1 || !split(range, bounds, depth, region, d))
        return buildLeaf(chunk, range, bounds.box);
    chunk.nodes.resize(node + 2);
    chunk.depth = std::max(chunk.depth, depth + 1);
    chunk.cost += static_cast<double>(bounds.box.halfArea());
    const uint32_t left =
        buildInto(chunk, d.left, d.leftBounds, depth + 1, leftRegion(d, depth, region));
    const uint32_t right = buildInto(chunk, d.right, d.rightBounds, depth + 1, region);
    chunk.nodes[node] = region.grid.record(d.leftBounds.box, left);
    chunk.nodes[node + 1] = region.grid.record(d.rightBounds.box, right);
    return static_cast<uint32_t>(node / 2);
}

uint32_t Builder::buildLeaf(Chunk& chunk, const Range& range, const Box& box)
{
    const size_t first = chunk.slots.size();
    const double triangleCost = static_cast<double>(options_.triangleCost);
    for (const Reference& r : span(range)) {
        chunk.slots.push_back(r.triangle());
        chunk.least += static_cast<double>(r.box().halfArea()) * triangleCost;
    }
    chunk.cost +=
        static_cast<double>(box.halfArea()) * static_cast<double>(range.size()) * triangleCost;
    return leafReference(range.size(), first);
}

/// The way into an instance and back to what lies on `grid`.
uint32_t Builder::buildInstance(Chunk& chunk, const InstanceLeaf& instance, uint32_t depth,
                                const Grid& grid)
{
    const size_t node = chunk.nodes.size();
    chunk.nodes.insert(chunk.nodes.end(), instance.words.begin(), instance.words.end());
    chunk.nodes.resize(node + 6);
    writeWayBack(&chunk.nodes[node + 4], grid, shared::kBvhWorld);
    chunk.depth = std::max(chunk.depth, depth);
    chunk.cost += static_cast<double>(instance.box.halfArea() * instance.cost);
    chunk.entries.push_back(static_cast<uint32_t>(node));
    return gridReference(node / 2);
}

std::unique_ptr<Builder::Task> Builder::buildTask(const Range& range, const RangeBounds& bounds,
                                                  uint32_t depth, const Region& region)
{
    auto task = std::make_unique<Task>();
    if (stop_.stop_requested()) return task;
    if (range.size() > kTaskSize) {
        if (const auto finer = finerRegion(range, bounds, depth, region)) {
            task->finer = finer->grid;
            task->child[0] = buildTask(range, bounds, depth + 1, *finer);
            return task;
        }
    }
    Decision d;
    if (range.size() <= kTaskSize || !split(range, bounds, depth, region, d)) {
        task->chunk.nodes.reserve(range.size());
        task->chunk.slots.reserve(range.size() + range.room() / 2);
        if (range.size() > 0)
            task->chunk.root = buildInto(task->chunk, range, bounds, depth, region);
        task->chunk.nodes.shrink_to_fit();
        task->chunk.slots.shrink_to_fit();
        progress_.add(range.size());
        return task;
    }
    task->chunk.cost = static_cast<double>(bounds.box.halfArea());
    task->box[0] = d.leftBounds.box;
    task->box[1] = d.rightBounds.box;
    const Region left = leftRegion(d, depth, region);
    parallelInvoke([&] { task->child[0] = buildTask(d.left, d.leftBounds, depth + 1, left); },
                   [&] { task->child[1] = buildTask(d.right, d.rightBounds, depth + 1, region); });
    return task;
}

size_t Builder::nodeCount() const
{
    return sizeOf(*top_, &Chunk::nodes, 2) / 2;
}

BvhPart Builder::layOut(std::vector<uvec4> nodes, uint32_t firstNode, uint32_t firstSlot,
                        uint32_t& root, double& least)
{
    std::vector<uint32_t> slots;
    nodes.reserve(nodes.size() + sizeOf(*top_, &Chunk::nodes, 2));
    slots.reserve(sizeOf(*top_, &Chunk::slots, 0));
    BvhPart part;
    part.low = asVec3(bounds_.box.low);
    part.high = asVec3(bounds_.box.high);
    Layout out{nodes,      firstNode - static_cast<uint32_t>(nodes.size() / 2),
               slots,      firstSlot,
               part.depth, part.gridChanges,
               part.cost,  least};
    root = append(out, *top_, depth_, *grid_);
    top_.reset();
    part.nodes = std::move(nodes);
    part.slots = std::move(slots);
    return part;
}

/// Appends a task's nodes and slots and returns its reference in the whole.
uint32_t Builder::append(Layout& out, Task& task, uint32_t depth, const Grid& grid)
{
    out.cost += task.chunk.cost;
    out.least += task.chunk.least;
    out.gridChanges += task.chunk.gridChanges + (task.finer ? 1u : 0u);
    out.depth = std::max({out.depth, depth, task.chunk.depth});
    if (!task.child[0]) return appendChunk(out, task.chunk);
    const size_t node = out.nodes.size();
    const uint32_t number = static_cast<uint32_t>(node / 2) + out.nodeShift;
    if (task.finer) {
        out.nodes.resize(node + 4);
        const uint32_t root = append(out, *task.child[0], depth + 1, *task.finer);
        writeGridChange(&out.nodes[node], *task.finer, grid, root);
        return gridReference(number);
    }
    out.nodes.resize(node + 2);
    for (size_t i = 0; i < 2; ++i) {
        const uint32_t reference = append(out, *task.child[i], depth + 1, grid);
        out.nodes[node + i] = grid.record(task.box[i], reference);
        task.child[i].reset();
    }
    out.depth = std::max(out.depth, depth + 1);
    return number;
}

uint32_t Builder::appendChunk(Layout& out, const Chunk& chunk)
{
    const uint32_t firstNode = static_cast<uint32_t>(out.nodes.size() / 2) + out.nodeShift;
    const uint32_t firstSlot = static_cast<uint32_t>(out.slots.size()) + out.slotShift;
    const auto relocate = [&](uint32_t reference) {
        if (reference == shared::kBvhDone) return reference;
        const bool node = (reference & shared::kBvhLeaf) == 0 || changesGrid(reference);
        return reference + (node ? firstNode : firstSlot);
    };
    const size_t firstWord = out.nodes.size();
    for (uvec4 record : chunk.nodes) {
        record.w = relocate(record.w);
        out.nodes.push_back(record);
    }
    for (const uint32_t entry : chunk.entries)  // their last components are no references
        std::copy_n(&chunk.nodes[entry], 6, &out.nodes[firstWord + entry]);
    out.slots.insert(out.slots.end(), chunk.slots.begin(), chunk.slots.end());
    return relocate(chunk.root);
}

/// Sum of the sizes of one of the chunks' arrays, plus `perNode` for every node above them.
template <class T>
size_t Builder::sizeOf(const Task& task, std::vector<T> Chunk::*array, size_t perNode)
{
    size_t sum = (task.chunk.*array).size();
    if (task.child[0]) sum += task.finer ? 2 * perNode : perNode;
    for (const auto& child : task.child) {
        if (child) sum += sizeOf(*child, array, perNode);
    }
    return sum;
}

}  // namespace core::bvh
