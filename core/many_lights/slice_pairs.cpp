// See slice_pairs.h.
#include "core/many_lights/slice_pairs.h"

#include <algorithm>

#include "core/trace/scene_view.h"

namespace core::many_lights {

namespace {

/// The lights as seen from the middle of the receivers, if their box were larger by the receivers'.
LightNode enlarged(const PixelNode& p, const LightNode& l)
{
    LightNode node = l;
    const glm::vec3 half = 0.5f * (p.high - p.low);
    node.low -= half;
    node.high += half;
    return node;
}

}  // namespace

void SlicePairs::reset(const SliceJob& of, const LightTree& lights,
                       std::span<const Receiver> receivers, std::span<const uint32_t> chosen)
{
    job = &of;
    tree = &lights;
    pixels.build(receivers, chosen);
    rows.reset(sceneView(of.receivers.accel->world()), receivers, pixels.order());
    pixels.bound(rows, of.gather);
    weights.assign(rows.count(), 0);
    rays = entries = 0;
}

void SlicePairs::pushRoots()
{
    waiting.clear();
    if (pixels.nodes().empty()) return;
    for (uint32_t kind = 0; kind < kLightKinds; ++kind)
        if (tree->roots[kind] != shared::kNone)
            waiting.push_back({0, tree->roots[kind], static_cast<LightKind>(kind)});
}

float SlicePairs::bound(const PixelNode& p, const Pair& pair) const
{
    return clusterBound(enlarged(p, tree->nodes[pair.lights]), pair.kind, p.query);
}

float SlicePairs::responseOf(const PixelNode& p, const Pair& pair) const
{
    if (p.surface == ~0u) return p.albedo;
    const LightNode node = enlarged(p, tree->nodes[pair.lights]);
    return std::max(p.albedo, rows.largestResponse(p.surface, node, pair.kind));
}

}  // namespace core::many_lights
