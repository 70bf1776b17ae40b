// See flat_lights.h.
#include "core/many_lights/flat_lights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace core::many_lights {

namespace {

constexpr size_t kAsked = 8192;                     // lights, about
constexpr size_t kPlanes = 64, kLightsOfPlane = 8;  // of the lights, at most; on average, at least
constexpr double kNearlyAll = 0.95;                 // of them
constexpr float kNormalCell = 1 / 256.0f;           // in which normals are one
constexpr float kOffsetCell = 1 / 1024.0f;          // the same of planes, by the size of all
constexpr float kOneNormal = 0.99998f;              // cosine between rows of one piece
constexpr uint32_t kRowsOfPiece = 8;                // on average, at least

/// A plane, as coarsely as planes are told apart.
using Plane = std::array<int, 4>;

Plane planeOf(const LightNode& light, float size)
{
    const float offset = glm::dot(light.axis, light.low) / (size * kOffsetCell);
    const auto cell = [](float x) { return static_cast<int>(std::lround(x)); };
    return {cell(light.axis.x / kNormalCell), cell(light.axis.y / kNormalCell),
            cell(light.axis.z / kNormalCell), cell(offset)};
}

}  // namespace

bool lieInFewPlanes(const LightTree& tree)
{
    const uint32_t root = tree.roots[static_cast<size_t>(LightKind::surface)];
    if (root == shared::kNone) return false;
    const LightNode& all = tree.nodes[root];
    const float size = glm::length(all.high - all.low);
    if (!(size > 0)) return false;
    std::vector<Plane> planes;
    size_t leaves = 0;
    const size_t every = all.count / kAsked + 1;
    for (const LightNode& node : std::span(tree.nodes).subspan(root, 2 * size_t(all.count) - 1))
        if (node.isLeaf() && leaves++ % every == 0) planes.push_back(planeOf(node, size));
    std::ranges::sort(planes);
    std::vector<size_t> sizes;
    for (size_t i = 0; i < planes.size(); ++i) {
        if (i == 0 || planes[i] != planes[i - 1]) sizes.push_back(0);
        ++sizes.back();
    }
    std::ranges::sort(sizes, std::greater());
    size_t most = 0;
    const size_t few = std::min({sizes.size(), kPlanes, planes.size() / kLightsOfPlane});
    for (size_t i = 0; i < few; ++i) most += sizes[i];
    return static_cast<double>(most) >= kNearlyAll * static_cast<double>(planes.size());
}

bool areFewFlatPieces(const PixelTree& tree, const SliceRows& rows)
{
    if (tree.nodes().empty() || tree.nodes()[0].surface != ~0u) return false;
    uint32_t pieces = 1;
    for (uint32_t row = 1; row < rows.count(); ++row)
        if (!(glm::dot(rows.shadingNormal(row - 1), rows.shadingNormal(row)) >= kOneNormal))
            ++pieces;
    return pieces * kRowsOfPiece <= rows.count();
}

}  // namespace core::many_lights
