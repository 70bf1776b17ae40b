// See rough_light.h.
#include "core/many_lights/rough_light.h"

#include <algorithm>

#include "core/completion/row_weights.h"
#include "core/many_lights/shadow_packets.h"
#include "core/many_lights/sphere_bound.h"

namespace core::many_lights {

namespace {

// Of pairs: radius over distance, and cosine of half the cone of their lights. The authors' .03 and
// .99 make it cost more than the second pass, without better pictures.
constexpr float kSeparation = 0.1f;
constexpr float kParallel = 0.9f;
constexpr float kDarkest = 0.01f;  // of the mean of a slice: what its darkest receivers count as
// Where next to nothing is seen of what a slice would get with nothing in between, receivers count
// as if they got this part of that: an error in proportion to nothing would make the second pass
// ask for every light by itself.
constexpr double kUnlit = 0.2, kNextToNothing = 1e-3;
constexpr size_t kBatch = 4096;  // rays traced together

bool separated(const SlicePairs& pairs, const PixelNode& p, const LightNode& l, LightKind kind)
{
    if (!l.isLeaf() && l.cosHalf <= kParallel) return false;
    const float radius = p.radius();
    if (kind == LightKind::directional)
        return radius <= kSeparation * pairs.job->receivers.accel->world().radius;
    const float lights = sphereRadius(l, kind);
    const float distance = glm::distance(p.query.position, 0.5f * (l.low + l.high));
    return kSeparation * (distance - lights - radius) > std::max(lights, radius);
}

}  // namespace

bool RoughLight::find(SlicePairs& pairs, bool keepsFound, Pcg32& random,
                      const std::stop_token& stop)
{
    const std::span<const PixelNode> nodes = pairs.pixels.nodes();
    light_.assign(nodes.size(), 0);
    open_ = 0;
    probes_.clear();
    found_.clear();
    firstFound_.assign(keepsFound ? nodes.size() : 0, ~0u);
    size_t steps = 0;
    for (pairs.pushRoots(); !pairs.waiting.empty();) {
        const Pair pair = pairs.waiting.back();
        pairs.waiting.pop_back();
        if (++steps % kBatch == 0 && stop.stop_requested()) return false;
        const PixelNode& p = nodes[pair.pixels];
        const LightNode& l = pairs.tree->nodes[pair.lights];
        if ((p.isLeaf() && l.isLeaf()) || separated(pairs, p, l, pair.kind)) {
            probe(pairs, pair, random);
            if (probes_.size() >= kBatch) finishProbes(pairs, keepsFound);
        } else if (!l.isLeaf() && (p.isLeaf() || l.cosHalf <= kParallel ||
                                   sphereRadius(l, pair.kind) >= p.radius())) {
            pairs.splitLights(pair);
        } else {
            pairs.splitPixels(pair);
        }
    }
    finishProbes(pairs, keepsFound);
    for (uint32_t i = 0; i < light_.size(); ++i) {
        if (nodes[i].isLeaf()) continue;
        light_[i + 1] += light_[i];
        light_[nodes[i].right] += light_[i];
    }
    return !stop.stop_requested();
}

void RoughLight::probe(SlicePairs& pairs, const Pair& pair, Pcg32& random)
{
    const IndexRange& rows = pairs.pixels.nodes()[pair.pixels].rows;
    const uint32_t row = rows.begin + drawBelow(rows.size(), random);
    Probe probe{pair.pixels, row, pairs.representative(pairs.tree->nodes[pair.lights]), 0, 0};
    pairs.rows.weigh(probe.column, pairs.job->gather, {row, row + 1}, pairs.weights);
    probe.weight = pairs.weights[row];
    if (probe.weight > 0) probes_.push_back(probe);
}

void RoughLight::finishProbes(SlicePairs& pairs, bool keepsFound)
{
    ShadowPackets packets(*pairs.job->receivers.accel, pairs.rows);
    for (Probe& p : probes_) packets.add(ShadowTarget(p.column), p.row, &p.visible, 1);
    packets.flush();
    pairs.rays += probes_.size();
    for (const Probe& p : probes_) {
        const IndexRange row{p.row, p.row + 1};
        pairs.weights[p.row] = p.weight;
        pairs.rows.clear(row);
        pairs.rows.add(p.column, *pairs.job->lights, row, pairs.weights);
        const auto light = double(shared::luminance(pairs.rows.radiance(p.row)));
        open_ += light * pairs.pixels.nodes()[p.pixels].rows.size() / pairs.rows.count();
        if (p.visible != 0) light_[p.pixels] += light;
        if (!keepsFound) continue;
        found_.push_back({p.column, light, firstFound_[p.pixels]});
        firstFound_[p.pixels] = static_cast<uint32_t>(found_.size() - 1);
    }
    probes_.clear();
}

void RoughLight::thresholds(const SlicePairs& pairs, float error, std::vector<float>& out) const
{
    const std::span<const PixelNode> nodes = pairs.pixels.nodes();
    double mean = 0;
    for (uint32_t i = 0; i < light_.size(); ++i)
        if (nodes[i].isLeaf()) mean += light_[i] / pairs.rows.count();
    const double darkest =
        std::max(double(kDarkest) * mean, kUnlit * (open_ - mean / kNextToNothing));
    out.resize(light_.size());
    for (size_t i = light_.size(); i-- > 0;) {
        const PixelNode& node = nodes[i];
        out[i] = node.isLeaf() ? error * static_cast<float>(std::max(light_[i], darkest))
                               : std::min(out[i + 1], out[node.right]);
    }
}

}  // namespace core::many_lights
