// The bytes: numbers of fixed size, then the arrays. They are this machine's own; another one makes
// its own files. See bvh_file.h.
#include "core/trace/bvh_file.h"

#include <algorithm>
#include <cstring>

#include "core/base/content_hash.h"
#include "core/trace/bvh_check.h"

namespace core {
namespace {

/// Of a part, without its arrays.
struct PartHead {
    uint64_t nodeWords = 0, slots = 0;
    glm::vec3 low{0}, high{0};
    uint32_t depth = 0, gridChanges = 0;
    double cost = 0;
};
static_assert(sizeof(PartHead) == 56);

/// Of the whole.
struct Head {
    PartHead moving, still;
    uint64_t prototypes = 0;
    glm::vec3 gridLow{0}, gridScale{0};
    uint32_t depth = 0, movingNodes = 0;
    float cost = 0, triangleCost = 0;
    double movingLeast = 0, movingRatio = 0;
};
static_assert(sizeof(Head) == 176);

PartHead headOf(const BvhPart& part)
{
    return {part.nodes.size(), part.slots.size(), part.low, part.high,
            part.depth,        part.gridChanges,  part.cost};
}

/// Copies items to where `to` points, which goes on behind them.
template <class Range> void put(std::byte*& to, const Range& items)
{
    const auto bytes = std::as_bytes(std::span(items.data(), items.size()));
    to = std::copy(bytes.begin(), bytes.end(), to);
}

/// Takes bytes from the front of a span.
class Reader {
public:
    explicit Reader(std::span<const std::byte> bytes) : rest_(bytes) {}

    template <class T> bool take(T& value) { return take(&value, 1); }

    /// False when there are not so many.
    template <class T> bool take(std::vector<T>& items, uint64_t count)
    {
        if (count > rest_.size() / sizeof(T)) return false;
        items.resize(count);
        return take(items.data(), count);
    }

    bool empty() const { return rest_.empty(); }

private:
    template <class T> bool take(T* items, size_t count)
    {
        const size_t bytes = count * sizeof(T);
        if (rest_.size() < bytes) return false;
        if (bytes > 0) std::memcpy(static_cast<void*>(items), rest_.data(), bytes);
        rest_ = rest_.subspan(bytes);
        return true;
    }

    std::span<const std::byte> rest_;
};

bool takePart(Reader& reader, const PartHead& head, BvhPart& part)
{
    std::vector<shared::uvec4> nodes;
    std::vector<uint32_t> slots;
    if (!reader.take(nodes, head.nodeWords) || !reader.take(slots, head.slots)) return false;
    part = {std::move(nodes), std::move(slots), head.low, head.high,
            head.depth,       head.gridChanges, head.cost};
    return true;
}

uint64_t layoutHash()
{
    ContentHash hash;
    constexpr uint32_t kBuilder = 2;  // counted up where it builds other trees than before
    const std::array<uint32_t, 11> layout{shared::kBvhLeaf,
                                          shared::kBvhCountShift,
                                          shared::kBvhCountMask,
                                          shared::kBvhIndexMask,
                                          shared::kBvhChange,
                                          shared::kBvhDone,
                                          shared::kBvhInstance,
                                          shared::kBvhWorld,
                                          shared::kBvhMaxDepth,
                                          sizeof(Head),
                                          kBuilder};
    hash.addValue(layout);
    hash.add(std::as_bytes(std::span(__VERSION__)));  // another compiler may round in another way
    return hash.value();
}

}  // namespace

BvhKey bvhKey(std::span<const glm::vec3> positions, std::span<const WorldTriangle> triangles,
              const BvhOptions& options)
{
    ContentHash hash;
    hash.add(std::as_bytes(positions));
    hash.add(std::as_bytes(triangles));
    hash.add(std::as_bytes(options.prototypes));
    hash.add(std::as_bytes(options.instances));
    hash.addValue(options.leafSize);
    hash.addValue(options.duplicateBudget);
    hash.addValue(options.triangleCost);
    hash.addValue(options.moving);
    hash.addValue(options.reachLow);
    hash.addValue(options.reachHigh);
    hash.addValue(options.maxDepth);
    BvhKey key;
    key.layout = layoutHash();
    key.positions = positions.size();
    key.triangles = triangles.size();
    key.contents = hash.value();
    return key;
}

uint64_t bvhByteCount(const Bvh& bvh)
{
    return sizeof(Head) + bvh.nodeCount() * 2 * sizeof(shared::uvec4) +
           bvh.slotCount() * sizeof(uint32_t) + bvh.prototypeSlots.size() * sizeof(IndexRange);
}

std::vector<std::byte> bvhBytes(const Bvh& bvh)
{
    const Head head{headOf(bvh.moving), headOf(bvh.still), bvh.prototypeSlots.size(),
                    bvh.gridLow,        bvh.gridScale,     bvh.depth,
                    bvh.movingNodes,    bvh.cost,          bvh.triangleCost,
                    bvh.movingLeast,    bvh.movingRatio};
    std::vector<std::byte> bytes(bvhByteCount(bvh));
    std::byte* to = bytes.data();
    put(to, std::span(&head, 1));
    for (const BvhPart* part : {&bvh.moving, &bvh.still}) {
        put(to, part->nodes);
        put(to, part->slots);
    }
    put(to, bvh.prototypeSlots);
    return bytes;
}

std::optional<Bvh> bvhFromBytes(std::span<const std::byte> bytes,
                                std::span<const glm::vec3> positions,
                                std::span<const WorldTriangle> triangles, const BvhOptions& options)
{
    Reader reader(bytes);
    Head head;
    Bvh bvh;
    if (!reader.take(head) || !takePart(reader, head.moving, bvh.moving) ||
        !takePart(reader, head.still, bvh.still) ||
        !reader.take(bvh.prototypeSlots, head.prototypes) || !reader.empty())
        return std::nullopt;
    bvh.gridLow = head.gridLow;
    bvh.gridScale = head.gridScale;
    bvh.depth = head.depth;
    bvh.movingNodes = head.movingNodes;
    bvh.cost = head.cost;
    bvh.triangleCost = head.triangleCost;
    bvh.movingLeast = head.movingLeast;
    bvh.movingRatio = head.movingRatio;
    if (!isSound(bvh, positions, triangles, options)) return std::nullopt;
    return bvh;
}

}  // namespace core
