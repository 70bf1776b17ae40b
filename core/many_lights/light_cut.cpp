// See light_cut.h.
#include "core/many_lights/light_cut.h"

#include <algorithm>
#include <cmath>

namespace core::many_lights {

namespace {

using glm::vec3;

/// Largest cosine between `axis` and a direction from the query's position to a point of the box
/// with this centre (relative to that position) and half size; 0 when all are behind.
float largestCosine(const vec3& axis, const vec3& centre, const vec3& half)
{
    const glm::mat3 frame = shared::makeFrame(axis);
    const auto reach = [&](const vec3& a) { return glm::dot(glm::abs(a), half); };
    const float far = glm::dot(axis, centre) + reach(axis);
    if (!(far > 0)) return 0;
    const float x = std::max(0.0f, std::abs(glm::dot(frame[0], centre)) - reach(frame[0]));
    const float y = std::max(0.0f, std::abs(glm::dot(frame[1], centre)) - reach(frame[1]));
    return far / std::sqrt(x * x + y * y + far * far);
}

/// Cosine of an angle less a half angle, for cosines of 0 or more of the former: 1 inside the cone,
/// never below 0.
float cosineBeyond(float cosine, float cosHalf, float sinHalf)
{
    if (cosine >= cosHalf || cosHalf <= 0) return 1;
    const float sine = std::sqrt(std::max(0.0f, 1 - cosine * cosine));
    return std::clamp(cosine * cosHalf + sine * sinHalf, 0.0f, 1.0f);
}

/// Rounding must not make a bound of what is none.
constexpr float kSlack = 1.0001f;

}  // namespace

float clusterBound(const LightNode& node, LightKind kind, const CutQuery& query)
{
    const bool faces = query.normal != vec3(0);
    if (kind == LightKind::directional) {
        if (!faces || node.cosHalf <= 0) return node.importance;
        // Sum of two half angles by taking one cone off after the other.
        const float cosine = std::clamp(-glm::dot(query.normal, node.axis), -1.0f, 1.0f);
        const float cosHalf = node.cosHalf * query.cosHalf - node.sinHalf * query.sinHalf;
        const float sinHalf = node.sinHalf * query.cosHalf + node.cosHalf * query.sinHalf;
        if (cosHalf <= 0 || cosine >= cosHalf) return node.importance;
        const float sine = std::sqrt(std::max(0.0f, 1 - cosine * cosine));
        return node.importance * std::clamp(cosine * cosHalf + sine * sinHalf, 0.0f, 1.0f) * kSlack;
    }
    const vec3 centre = 0.5f * (node.low + node.high) - query.position;
    const vec3 half = 0.5f * (node.high - node.low);
    const vec3 outside = glm::max(glm::abs(centre) - half, vec3(0));
    const float distance2 = glm::dot(outside, outside);
    const float b2 = kind == LightKind::surface ? query.clampDistance * query.clampDistance : 0.0f;
    const float strength = node.importance * kSlack / std::max(distance2, b2);
    if (!(distance2 > 0)) return strength;
    float bound = strength;
    if (faces)
        bound *=
            cosineBeyond(largestCosine(query.normal, centre, half), query.cosHalf, query.sinHalf);
    if (kind == LightKind::surface && node.cosHalf > 0)
        bound *= cosineBeyond(largestCosine(-node.axis, centre, half), node.cosHalf, node.sinHalf);
    return bound;
}

void cutLightTree(const LightTree& tree, std::span<const VirtualLight> lights,
                  const CutQuery& query, uint32_t clusters, CutMemory& memory,
                  std::vector<LightCluster>& out)
{
    using Entry = CutMemory::Entry;
    const auto less = [](const Entry& a, const Entry& b) {
        return a.bound < b.bound || (a.bound == b.bound && a.node > b.node);
    };
    std::vector<Entry>& heap = memory.heap;
    heap.clear();
    out.clear();
    const auto add = [&](uint32_t index, LightKind kind) {
        const LightNode& node = tree.nodes[index];
        if (node.isLeaf()) {
            out.push_back({index, node.representative, 1});
            return;
        }
        heap.push_back({clusterBound(node, kind, query), index, kind});
        std::push_heap(heap.begin(), heap.end(), less);
    };
    for (uint32_t kind = 0; kind < kLightKinds; ++kind)
        if (tree.roots[kind] != shared::kNone) add(tree.roots[kind], static_cast<LightKind>(kind));
    while (!heap.empty() && heap.size() + out.size() < clusters) {
        std::pop_heap(heap.begin(), heap.end(), less);
        const Entry top = heap.back();
        heap.pop_back();
        add(top.node + 1, top.kind);
        add(tree.nodes[top.node].right, top.kind);
    }
    for (const Entry& entry : heap) {
        const LightNode& node = tree.nodes[entry.node];
        out.push_back({entry.node, node.representative,
                       node.importance / lights[node.representative].importance});
    }
    std::sort(out.begin(), out.end(),
              [](const LightCluster& a, const LightCluster& b) { return a.node < b.node; });
}

}  // namespace core::many_lights
