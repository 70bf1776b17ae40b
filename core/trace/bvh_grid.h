// The 16-bit grid on which the boxes of a Bvh lie, and its sums. Private to bvh*.cpp.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/trace/bvh.h"
#include "core/trace/bvh_split.h"
#include "shared/intersect.h"

namespace core::bvh {

inline Float4 asFloat4(const glm::vec3& v)
{
    return Float4{v.x, v.y, v.z, 0};
}

inline glm::vec3 asVec3(Float4 v)
{
    return {v[0], v[1], v[2]};
}

/// World to grid cells, in double so that only the ray's side rounds.
struct Grid {
    static constexpr float kCells = 65533.0f;  // leaves one cell of rounding on either side
    static constexpr double kSlack = 0.02;     // cells; covers the rounding of the ray's side

    glm::vec3 low{0}, scale{1};

    Grid(glm::vec3 gridLow, glm::vec3 gridScale) : low(gridLow), scale(gridScale) {}

    explicit Grid(const Box& bounds)
    {
        if (bounds.empty()) return;
        const Float4 e = bounds.high - bounds.low;
        // A flat axis gets cells in proportion to the other axes and to its place, so that neither
        // the scale overflows nor a cell is finer than rounding can tell.
        const float size = std::max({e[0], e[1], e[2]});
        float place = 0;
        for (int a = 0; a < 3; ++a) {
            place = std::max({place, std::abs(bounds.low[a]), std::abs(bounds.high[a])});
        }
        const float floorExtent = std::max({size / 65536.0f, place * 1e-6f, 1e-30f});
        for (int a = 0; a < 3; ++a) {
            const float extent = std::max(e[a], floorExtent);
            scale[a] = kCells / extent;
            low[a] = bounds.low[a] - extent / kCells;
        }
    }

    /// Whether the box lies on the grid: outside, its records would not contain it.
    bool holds(const Box& box) const
    {
        if (box.empty()) return true;
        bool inside = true;
        for (int a = 0; a < 3; ++a) {
            inside = inside && place(box.low[a], a) >= kSlack &&
                     place(box.high[a], a) <= 65535.0 - kSlack;
        }
        return inside;
    }

    shared::uvec4 record(const Box& box, uint32_t reference) const
    {
        shared::uvec4 r(0, 0, 0, reference);
        if (box.empty()) return r;
        for (int a = 0; a < 3; ++a)
            r[a] = cell(box.low[a], a, false) | (cell(box.high[a], a, true) << 16);
        return r;
    }

private:
    double place(float x, int axis) const
    {
        return (static_cast<double>(x) - static_cast<double>(low[axis])) *
               static_cast<double>(scale[axis]);
    }
    uint32_t cell(float x, int axis, bool up) const
    {
        const double q = place(x, axis);
        const double rounded = up ? std::ceil(q + kSlack) : std::floor(q - kSlack);
        return static_cast<uint32_t>(std::clamp(rounded, 0.0, 65535.0));
    }
};

/// Fills depth and cost of the whole from its parts.
inline void sumUp(Bvh& bvh)
{
    Box bounds{asFloat4(bvh.still.low), asFloat4(bvh.still.high)};
    const bool joined = !bvh.still.slots.empty() && !bvh.moving.slots.empty();
    if (bounds.empty()) bounds = Box{};
    if (!bvh.moving.slots.empty())
        bounds.grow(Box{asFloat4(bvh.moving.low), asFloat4(bvh.moving.high)});
    const double area = static_cast<double>(bounds.halfArea());
    const double cost = bvh.still.cost + bvh.moving.cost + (joined ? area : 0);
    bvh.cost = area > 0 ? static_cast<float>(cost / area) : 0.0f;
    bvh.depth = std::max({bvh.still.depth, bvh.moving.depth, 1u});
}

}  // namespace core::bvh
