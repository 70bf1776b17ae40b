// The 16-bit grid on which the boxes of a Bvh lie, and its sums. Private to bvh*.cpp.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/trace/bvh.h"
#include "core/trace/bvh_split.h"
#include "shared/intersect.h"

namespace core::bvh {

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
        const float size = bounds.extent();
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

    /// The longest edge of a cell.
    float cell() const { return 1.0f / std::min({scale[0], scale[1], scale[2]}); }

    /// Whether `count` references that fill the box are too small for this grid. Of a surface of n
    /// triangles each has some 1 / sqrt(n) of its extent; boxes are rounded up by a cell, so with s
    /// cells to the triangle a ray through the box makes some 2 / s + 1 / s^2 tests too many. A
    /// finer grid costs about two on the way in and out. But kernels that can change grids take 2 %
    /// longer for all rays: a small part of `all` references must have it far worse.
    bool isCoarseFor(const Box& box, size_t count, size_t all) const
    {
        constexpr float kFiner = 16;  // times, or there is no point
        if (box.empty() || cell() < kFiner * Grid(box).cell()) return false;
        const float cells = count >= all / 64 ? 2.0f : 0.25f;
        return box.extent() <= cells * cell() * std::sqrt(static_cast<float>(count));
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

/// Whether a reference leads to a change of grid.
inline bool changesGrid(uint32_t reference)
{
    return reference >= shared::kBvhChange && reference != shared::kBvhDone;
}

/// The reference to the change of grid that begins at a node.
inline uint32_t gridReference(size_t node)
{
    return shared::kBvhChange | static_cast<uint32_t>(node);
}

inline shared::uvec4 floatWord(const glm::vec3& v, uint32_t w)
{
    return {shared::floatAsUint(v.x), shared::floatAsUint(v.y), shared::floatAsUint(v.z), w};
}

/// The vector in such a word.
inline glm::vec3 vectorIn(const shared::uvec4& word)
{
    return {shared::uintAsFloat(word.x), shared::uintAsFloat(word.y), shared::uintAsFloat(word.z)};
}

/// The node of a way (see Bvh), as two words: to `root`, whose boxes lie on `grid`.
inline void writeWay(shared::uvec4* words, const Grid& grid, uint32_t root)
{
    words[0] = floatWord(grid.low, root);
    words[1] = floatWord(grid.scale, shared::kBvhDone);
}

/// The node of a way back to what lies on `grid`; `kind` is kBvhDone, or kBvhWorld out of an
/// instance.
inline void writeWayBack(shared::uvec4* words, const Grid& grid, uint32_t kind)
{
    words[0] = floatWord(grid.low, shared::kBvhDone);
    words[1] = floatWord(grid.scale, kind);
}

/// The two nodes of a change of grid (see Bvh), as four words: the way to `root`, whose boxes lie
/// on `finer`, and the way back to what lies on `grid`.
inline void writeGridChange(shared::uvec4* words, const Grid& finer, const Grid& grid,
                            uint32_t root)
{
    writeWay(words, finer, root);
    writeWayBack(words + 2, grid, shared::kBvhDone);
}

/// Fills depth and cost of the whole from its parts.
inline void sumUp(Bvh& bvh)
{
    Box bounds{load(bvh.still.low), load(bvh.still.high)};
    const bool joined = !bvh.still.slots.empty() && !bvh.moving.slots.empty();
    if (bounds.empty()) bounds = Box{};
    if (!bvh.moving.slots.empty()) bounds.grow(Box{load(bvh.moving.low), load(bvh.moving.high)});
    const double area = static_cast<double>(bounds.halfArea());
    const double cost = bvh.still.cost + bvh.moving.cost + (joined ? area : 0);
    bvh.cost = area > 0 ? static_cast<float>(cost / area) : 0.0f;
    bvh.depth = std::max({bvh.still.depth, bvh.moving.depth, 1u});
}

}  // namespace core::bvh
