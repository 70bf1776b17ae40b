// A bound of what a node of lights brings that looks at distances alone: looser than clusterBound,
// and a fraction of its cost. Where it is small enough no other is needed.
#pragma once

#include <algorithm>

#include "core/many_lights/light_tree.h"

namespace core::many_lights {

/// Of the sphere around a node of lights at a place.
inline float sphereRadius(const LightNode& node, LightKind kind)
{
    return kind == LightKind::directional ? 0 : 0.5f * glm::length(node.high - node.low);
}

/// No less than what the lights of the node together bring to a Lambertian receiver of albedo pi
/// within `radius` of `position`; infinite where they may be in one place.
inline float sphereBound(const LightNode& node, LightKind kind, const glm::vec3& position,
                         float radius, float clampDistance)
{
    if (kind == LightKind::directional) return node.importance;
    const float gap =
        glm::distance(0.5f * (node.low + node.high), position) - sphereRadius(node, kind) - radius;
    const float least = kind == LightKind::surface ? clampDistance : 0.0f;
    const float near = std::max(gap, least) * 0.9999f;  // rounding makes it no less of a bound
    return node.importance / (near * near);
}

}  // namespace core::many_lights
