// See pair_samples.h.
#include "core/many_lights/pair_samples.h"

#include <algorithm>

namespace core::many_lights {

namespace {

using glm::vec3;

constexpr std::array<vec3, 8> kCorners{vec3(1, 1, 1),   vec3(1, -1, -1),  vec3(-1, 1, -1),
                                       vec3(-1, -1, 1), vec3(-1, -1, -1), vec3(-1, 1, 1),
                                       vec3(1, -1, 1),  vec3(1, 1, -1)};

/// Of a node from those of its children; `at(member)` is where a member lies.
template <class At>
Outermost outermostOf(const Outermost& left, const Outermost& right, const At& at)
{
    Outermost out;
    for (size_t c = 0; c < kCorners.size(); ++c)
        out[c] = glm::dot(kCorners[c], at(left[c])) >= glm::dot(kCorners[c], at(right[c]))
                     ? left[c]
                     : right[c];
    return out;
}

Outermost only(uint32_t member)
{
    Outermost out;
    out.fill(member);
    return out;
}

/// Bits of k < 2^n backwards, for `size` = 2^n: what comes one after the other lies far apart.
uint32_t reversed(uint32_t k, uint32_t size)
{
    uint32_t out = 0;
    for (uint32_t low = 1, high = size / 2; high > 0; low *= 2, high /= 2)
        if ((k & low) != 0) out |= high;
    return out;
}

/// A member of stratum k of `count`.
uint32_t fromStratum(uint32_t k, uint32_t count, uint32_t members, Pcg32& random)
{
    const double at = (k + random()) * members / count;
    return std::min(static_cast<uint32_t>(at), members - 1);
}

}  // namespace

NodeLights::NodeLights(const LightTree& tree)
{
    const size_t count = tree.nodes.size();
    first_.resize(count);
    outermost_.resize(count);
    std::vector<vec3> places(count / 2 + kLightKinds);
    for (uint32_t i = 0; i < count; ++i) {
        const LightNode& node = tree.nodes[i];
        first_[i] = static_cast<uint32_t>(lights_.size());
        if (!node.isLeaf()) continue;
        lights_.push_back(node.representative);
        if (node.representative >= places.size()) places.resize(node.representative + size_t(1));
        places[node.representative] = node.low;
    }
    const auto at = [&](uint32_t light) { return places[light]; };
    for (size_t i = count; i-- > 0;) {
        const LightNode& node = tree.nodes[i];
        outermost_[i] = node.isLeaf() ? only(node.representative)
                                      : outermostOf(outermost_[i + 1], outermost_[node.right], at);
    }
}

void outermostRows(const PixelTree& tree, const SliceRows& rows, std::vector<Outermost>& out)
{
    const std::span<const PixelNode> nodes = tree.nodes();
    out.resize(nodes.size());
    const auto at = [&](uint32_t row) {
        return vec3(rows.originX()[row], rows.originY()[row], rows.originZ()[row]);
    };
    for (size_t i = nodes.size(); i-- > 0;)
        out[i] = nodes[i].isLeaf() ? only(nodes[i].rows.begin)
                                   : outermostOf(out[i + 1], out[nodes[i].right], at);
}

void samplePair(const PixelNode& pixels, const Outermost& rows, const LightNode& lights,
                uint32_t node, const NodeLights& nodeLights, Pcg32& random,
                std::span<PairSample> out)
{
    const uint32_t size = pixels.rows.size();
    const Outermost& outer = nodeLights.outermost(node);
    const auto quarter = static_cast<uint32_t>(out.size() / 4);
    for (uint32_t k = 0; k < quarter; ++k) {
        // Strata of either side meet in an order in which they have nothing to do with each other.
        const auto row = [&](uint32_t half) {
            return pixels.rows.begin + fromStratum(2 * k + half, 2 * quarter, size, random);
        };
        const auto light = [&](uint32_t half) {
            const uint32_t stratum = reversed(2 * k + half, 2 * quarter);
            return nodeLights.light(node, fromStratum(stratum, 2 * quarter, lights.count, random));
        };
        const uint32_t corner = 2 * k % 8, other = (3 * k + k / 4 + 1) % 8;
        out[4 * k] = {rows[corner], outer[other]};
        out[4 * k + 1] = {rows[corner + 1], light(0)};
        out[4 * k + 2] = {row(0), outer[k % 8]};
        out[4 * k + 3] = {row(1), light(1)};
    }
}

}  // namespace core::many_lights
