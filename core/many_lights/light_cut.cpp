// See light_cut.h.
#include "core/many_lights/light_cut.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace core::many_lights {

namespace {

using glm::vec3;

/// Rounding must not make a bound of what is none.
constexpr float kSlack = 1.0001f;

/// By spread a light counts as no nearer than this part of its distance: lights within it would
/// have no order otherwise.
constexpr float kNearest = 0.25f;

// Bounds are found for several nodes at a time, in loops without branches and calls that compilers
// make vectors of: hence components in place of vectors, and both sides of every choice.

/// An orthonormal frame as components; `n` is its third axis.
struct Axes {
    float x[3], y[3], n[3];
};

[[gnu::always_inline]] inline Axes axesAround(float nx, float ny, float nz)
{
    const float s = nz >= 0 ? 1.0f : -1.0f, a = -1 / (s + nz), b = nx * ny * a;
    return {{1 + s * nx * nx * a, s * b, -s * nx}, {b, s + ny * ny * a, -ny}, {nx, ny, nz}};
}

/// A box by its centre, relative to the query's position, and its half size.
struct Box {
    float cx, cy, cz, hx, hy, hz;
};

[[gnu::always_inline]] inline float along(const float (&a)[3], const Box& box)
{
    return a[0] * box.cx + a[1] * box.cy + a[2] * box.cz;
}

[[gnu::always_inline]] inline float reach(const float (&a)[3], const Box& box)
{
    return std::abs(a[0]) * box.hx + std::abs(a[1]) * box.hy + std::abs(a[2]) * box.hz;
}

/// Largest cosine between the third axis and a direction to a point of the box; 0 when all are
/// behind.
[[gnu::always_inline]] inline float largestCosine(const Axes& axes, const Box& box)
{
    const float far = along(axes.n, box) + reach(axes.n, box);
    const float x = std::max(0.0f, std::abs(along(axes.x, box)) - reach(axes.x, box));
    const float y = std::max(0.0f, std::abs(along(axes.y, box)) - reach(axes.y, box));
    const float cosine = far / std::sqrt(x * x + y * y + far * far);
    return far > 0 ? cosine : 0.0f;
}

/// Cosine of an angle less a half angle, for cosines of 0 or more of the former: 1 inside the cone,
/// never below 0.
[[gnu::always_inline]] inline float cosineBeyond(float cosine, float cosHalf, float sinHalf)
{
    const float sine = std::sqrt(std::max(0.0f, 1 - cosine * cosine));
    const float beyond = std::min(1.0f, std::max(0.0f, cosine * cosHalf + sine * sinHalf));
    return (int(cosine >= cosHalf) | int(cosHalf <= 0)) != 0 ? 1.0f : beyond;
}

constexpr uint32_t kLanes = 8;

/// Nodes side by side, all of lights at places.
struct Lanes {
    template <class T> using Each = std::array<T, kLanes>;
    Each<float> lowX, lowY, lowZ, highX, highY, highZ, axisX, axisY, axisZ, cosHalf, sinHalf;
    Each<float> importance, clamp2;

    void set(uint32_t i, const LightNode& node, LightKind kind, float clampDistance)
    {
        lowX[i] = node.low.x;
        lowY[i] = node.low.y;
        lowZ[i] = node.low.z;
        highX[i] = node.high.x;
        highY[i] = node.high.y;
        highZ[i] = node.high.z;
        axisX[i] = -node.axis.x;
        axisY[i] = -node.axis.y;
        axisZ[i] = -node.axis.z;
        cosHalf[i] = kind == LightKind::surface ? node.cosHalf : -1.0f;
        sinHalf[i] = node.sinHalf;
        importance[i] = node.importance;
        clamp2[i] = kind == LightKind::surface ? clampDistance * clampDistance : 0.0f;
    }
};

/// A query with what is the same for all nodes.
struct Receiving {
    explicit Receiving(const CutQuery& query)
        : px(query.position.x), py(query.position.y), pz(query.position.z),
          axes(axesAround(query.normal.x, query.normal.y,
                          query.normal == vec3(0) ? 1.0f : query.normal.z)),
          // A cone of all directions where light may come from anywhere.
          cosHalf(query.normal == vec3(0) ? -1.0f : query.cosHalf), sinHalf(query.sinHalf),
          spread(query.spread)
    {}

    void bound(const Lanes& lanes, std::array<float, kLanes>& bounds) const
    {
        for (uint32_t i = 0; i < kLanes; ++i) {
            const Box box{0.5f * (lanes.lowX[i] + lanes.highX[i]) - px,
                          0.5f * (lanes.lowY[i] + lanes.highY[i]) - py,
                          0.5f * (lanes.lowZ[i] + lanes.highZ[i]) - pz,
                          0.5f * (lanes.highX[i] - lanes.lowX[i]),
                          0.5f * (lanes.highY[i] - lanes.lowY[i]),
                          0.5f * (lanes.highZ[i] - lanes.lowZ[i])};
            const float x = std::max(std::abs(box.cx) - box.hx, 0.0f),
                        y = std::max(std::abs(box.cy) - box.hy, 0.0f),
                        z = std::max(std::abs(box.cz) - box.hz, 0.0f);
            const float middle = std::sqrt(x * x + y * y + z * z);
            const float distance = std::max(middle - spread, kNearest * middle);
            const float distance2 = distance * distance;
            const float strength =
                lanes.importance[i] * kSlack / std::max(distance2, lanes.clamp2[i]);
            const Axes leaving = axesAround(lanes.axisX[i], lanes.axisY[i], lanes.axisZ[i]);
            const float cosines =
                cosineBeyond(largestCosine(axes, box), cosHalf, sinHalf) *
                cosineBeyond(largestCosine(leaving, box), lanes.cosHalf[i], lanes.sinHalf[i]);
            bounds[i] = distance2 > 0 ? strength * cosines : strength;
        }
    }

    float px, py, pz;
    Axes axes;
    float cosHalf, sinHalf, spread;
};

float directionalBound(const LightNode& node, const CutQuery& query)
{
    if (query.normal == vec3(0) || node.cosHalf <= 0) return node.importance;
    // Sum of two half angles by taking one cone off after the other.
    const float cosine = std::clamp(-glm::dot(query.normal, node.axis), -1.0f, 1.0f);
    const float cosHalf = node.cosHalf * query.cosHalf - node.sinHalf * query.sinHalf;
    const float sinHalf = node.sinHalf * query.cosHalf + node.cosHalf * query.sinHalf;
    if (cosHalf <= 0 || cosine >= cosHalf) return node.importance;
    const float sine = std::sqrt(std::max(0.0f, 1 - cosine * cosine));
    return node.importance * std::clamp(cosine * cosHalf + sine * sinHalf, 0.0f, 1.0f) * kSlack;
}

/// Inner nodes that wait for their bounds until there are enough for a vector.
class Waiting {
public:
    Waiting(const CutQuery& query, BoundQueue& queue)
        : query_(query), receiving_(query), queue_(queue)
    {}

    void add(const LightNode& node, uint32_t index, LightKind kind)
    {
        if (kind == LightKind::directional) {
            queue_.push(directionalBound(node, query_), {index, kind});
            return;
        }
        lanes_.set(count_, node, kind, query_.clampDistance);
        entries_[count_++] = {index, kind};
        if (count_ == kLanes) flush();
    }

    void flush()
    {
        if (count_ == 0) return;
        std::array<float, kLanes> bounds;
        receiving_.bound(lanes_, bounds);
        for (uint32_t i = 0; i < count_; ++i) queue_.push(bounds[i], entries_[i]);
        count_ = 0;
    }

private:
    const CutQuery& query_;
    Receiving receiving_;
    BoundQueue& queue_;
    Lanes lanes_{};
    std::array<BoundQueue::Entry, kLanes> entries_;
    uint32_t count_ = 0;
};

}  // namespace

float clusterBound(const LightNode& node, LightKind kind, const CutQuery& query)
{
    if (kind == LightKind::directional) return directionalBound(node, query);
    Lanes lanes{};
    lanes.set(0, node, kind, query.clampDistance);
    std::array<float, kLanes> bounds;
    Receiving(query).bound(lanes, bounds);
    return bounds[0];
}

void lightBounds(const LightTree& tree, const CutQuery& query, std::span<float> bounds)
{
    const Receiving receiving(query);
    Lanes lanes{};
    std::array<uint32_t, kLanes> lights;
    uint32_t count = 0;
    const auto flush = [&] {
        std::array<float, kLanes> found;
        receiving.bound(lanes, found);
        for (uint32_t i = 0; i < count; ++i) bounds[lights[i]] = found[i];
        count = 0;
    };
    for (uint32_t k = 0; k < kLightKinds; ++k) {
        const uint32_t root = tree.roots[k];
        if (root == shared::kNone) continue;
        const auto kind = static_cast<LightKind>(k);
        const size_t size = 2 * size_t(tree.nodes[root].count) - 1;
        for (const LightNode& node : std::span(tree.nodes).subspan(root, size)) {
            if (!node.isLeaf()) continue;
            if (kind == LightKind::directional) {
                bounds[node.representative] = directionalBound(node, query);
                continue;
            }
            lanes.set(count, node, kind, query.clampDistance);
            lights[count++] = node.representative;
            if (count == kLanes) flush();
        }
    }
    flush();
}

void BoundQueue::clear()
{
    heads_.fill(shared::kNone);
    entries_.clear();
    free_ = shared::kNone;
    top_ = size_ = 0;
}

void BoundQueue::push(float bound, const Entry& entry)
{
    const size_t bucket = std::bit_cast<uint32_t>(bound) >> 20 & (kBuckets - 1);
    uint32_t at = free_;
    if (at == shared::kNone) {
        at = static_cast<uint32_t>(entries_.size());
        entries_.emplace_back();
    } else {
        free_ = entries_[at].next;
    }
    entries_[at] = {entry, heads_[bucket]};
    heads_[bucket] = at;
    top_ = std::max(top_, bucket);
    ++size_;
}

BoundQueue::Entry BoundQueue::pop()
{
    while (heads_[top_] == shared::kNone) --top_;
    const uint32_t at = heads_[top_];
    heads_[top_] = entries_[at].next;
    entries_[at].next = free_;
    free_ = at;
    --size_;
    return entries_[at].entry;
}

void cutLightTree(const LightTree& tree, const CutQuery& query, uint32_t clusters,
                  CutMemory& memory, std::vector<LightCluster>& out)
{
    BoundQueue& queue = memory.queue;
    queue.clear();
    out.clear();
    Waiting waiting(query, queue);
    const auto add = [&](uint32_t index, LightKind kind) {
        const LightNode& node = tree.nodes[index];
        if (node.isLeaf()) {
            out.push_back({index, node.representative, 1});
            return;
        }
        waiting.add(node, index, kind);
        __builtin_prefetch(&tree.nodes[node.right]);
    };
    for (uint32_t kind = 0; kind < kLightKinds; ++kind)
        if (tree.roots[kind] != shared::kNone) add(tree.roots[kind], static_cast<LightKind>(kind));
    waiting.flush();
    while (queue.size() > 0 && queue.size() + out.size() < clusters) {
        // Several at a time once there are many: the queue is no more exact than that anyway.
        const size_t most = clusters - queue.size() - out.size();
        const size_t some =
            std::min({most, size_t(kLanes / 2), std::max<size_t>(1, queue.size() / 16)});
        for (size_t i = 0; i < some; ++i) {
            const BoundQueue::Entry top = queue.pop();
            add(top.node + 1, top.kind);
            add(tree.nodes[top.node].right, top.kind);
        }
        waiting.flush();
    }
    queue.forEach([&](const BoundQueue::Entry& entry) {
        const LightNode& node = tree.nodes[entry.node];
        out.push_back({entry.node, node.representative, node.scale});
    });
    std::sort(out.begin(), out.end(),
              [](const LightCluster& a, const LightCluster& b) { return a.node < b.node; });
}

}  // namespace core::many_lights
