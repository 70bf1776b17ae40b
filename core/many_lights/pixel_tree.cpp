// See pixel_tree.h.
#include "core/many_lights/pixel_tree.h"

#include <algorithm>
#include <cmath>

namespace core::many_lights {

namespace {

using glm::vec3;

constexpr float kMixedNormals = 0.6f;  // diagonal of the normals' box above which they decide

struct Extent {
    vec3 low{1e30f}, high{-1e30f};

    void grow(const vec3& p)
    {
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    int widest() const
    {
        const vec3 d = high - low;
        return d.x >= d.y && d.x >= d.z ? 0 : d.y >= d.z ? 1 : 2;
    }
};

}  // namespace

void PixelTree::build(std::span<const Receiver> receivers, std::span<const uint32_t> chosen)
{
    places_.resize(chosen.size());
    for (uint32_t i = 0; i < chosen.size(); ++i) places_[i] = i;
    nodes_.clear();
    if (chosen.empty()) return;
    struct Work {
        uint32_t parent;  // whose right child this is; ~0: of none
        IndexRange range;
    };
    std::vector<Work> waiting{{~0u, {0, static_cast<uint32_t>(chosen.size())}}};
    while (!waiting.empty()) {
        const Work work = waiting.back();
        waiting.pop_back();
        const auto index = static_cast<uint32_t>(nodes_.size());
        if (work.parent != ~0u) nodes_[work.parent].right = index;
        nodes_.emplace_back().rows = work.range;
        if (work.range.size() < 2) continue;
        const uint32_t middle = split(receivers, chosen, work.range);
        waiting.push_back({index, {middle, work.range.end}});
        waiting.push_back({~0u, {work.range.begin, middle}});
    }
    order_.resize(chosen.size());
    for (size_t i = 0; i < places_.size(); ++i) order_[i] = chosen[places_[i]];
}

/// Returns where the second half begins.
uint32_t PixelTree::split(std::span<const Receiver> receivers, std::span<const uint32_t> chosen,
                          const IndexRange& range)
{
    const std::span<uint32_t> mine(&places_[range.begin], range.size());
    Extent positions, normals;
    for (const uint32_t i : mine) {
        positions.grow(receivers[chosen[i]].position);
        normals.grow(receivers[chosen[i]].normal);
    }
    const bool mixed = glm::distance(normals.low, normals.high) > kMixedNormals;
    const Extent& by = mixed ? normals : positions;
    const int axis = by.widest();
    const float middle = 0.5f * (by.low[axis] + by.high[axis]);
    const auto second = std::stable_partition(mine.begin(), mine.end(), [&](uint32_t i) {
        const Receiver& r = receivers[chosen[i]];
        return (mixed ? r.normal : r.position)[axis] < middle;
    });
    const auto left = static_cast<uint32_t>(second - mine.begin());
    return range.begin + (left == 0 || left == range.size() ? range.size() / 2 : left);
}

void PixelTree::bound(const SliceRows& rows, const GatherSettings& settings)
{
    for (size_t i = nodes_.size(); i-- > 0;) {
        PixelNode& node = nodes_[i];
        if (node.isLeaf())
            boundLeaf(node, rows, settings);
        else
            boundInner(node, rows, nodes_[i + 1], nodes_[node.right]);
    }
}

void PixelTree::boundLeaf(PixelNode& node, const SliceRows& rows,
                          const GatherSettings& settings) const
{
    const uint32_t row = node.rows.begin;
    node.query = rows.queryAt(row, settings);
    node.low = node.high = node.query.position;
    if (rows.isLambert(row))
        node.albedo = rows.largestResponse(row, {}, LightKind::surface);
    else
        node.surface = row;
}

void PixelTree::boundInner(PixelNode& node, const SliceRows& rows, const PixelNode& left,
                           const PixelNode& right) const
{
    node.low = glm::min(left.low, right.low);
    node.high = glm::max(left.high, right.high);
    node.albedo = std::max(left.albedo, right.albedo);
    node.surface = left.surface != ~0u ? left.surface : right.surface;
    node.query = left.query;
    node.query.position = 0.5f * (node.low + node.high);
    vec3 sum(0);
    bool open = false;  // some row may be lit from anywhere
    for (uint32_t row = node.rows.begin; row < node.rows.end; ++row) {
        const vec3 normal = rows.shadingNormal(row);
        open = open || normal == vec3(0);
        sum += normal;
    }
    const float length = glm::length(sum);
    if (open || !(length > 1e-3f * static_cast<float>(node.rows.size()))) {
        node.query.normal = vec3(0);
        return;
    }
    node.query.normal = sum / length;
    float cosHalf = 1;
    for (uint32_t row = node.rows.begin; row < node.rows.end; ++row)
        cosHalf = std::min(cosHalf, glm::dot(node.query.normal, rows.shadingNormal(row)));
    // Outwards by more than the rounding of the dot products.
    node.query.cosHalf = std::clamp(cosHalf - 1e-5f, -1.0f, 1.0f);
    node.query.sinHalf = std::sqrt(1 - node.query.cosHalf * node.query.cosHalf);
}

}  // namespace core::many_lights
