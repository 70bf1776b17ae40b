// The work on ranges of references inside the BVH builder: finding an object or a spatial split,
// and carrying it out. A reference is a triangle with the bounds of all or a part of it.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>

#include "core/scene/world.h"

namespace core::bvh {

using Float4 = float __attribute__((vector_size(16)));
using Int4 = int32_t __attribute__((vector_size(16)));

inline Float4 minimum(Float4 a, Float4 b)
{
    return a < b ? a : b;
}
inline Float4 maximum(Float4 a, Float4 b)
{
    return a > b ? a : b;
}

constexpr float kHuge = 3.0e38f;

/// Bounds; the fourth lane is not part of it. Starts empty.
struct Box {
    Float4 low{kHuge, kHuge, kHuge, kHuge};
    Float4 high{-kHuge, -kHuge, -kHuge, -kHuge};

    void grow(Float4 p)
    {
        low = minimum(low, p);
        high = maximum(high, p);
    }
    void grow(const Box& b)
    {
        low = minimum(low, b.low);
        high = maximum(high, b.high);
    }
    bool empty() const { return !(low[0] <= high[0] && low[1] <= high[1] && low[2] <= high[2]); }
    /// Length of the longest edge; negative when empty.
    float extent() const
    {
        const Float4 e = high - low;
        return std::max({e[0], e[1], e[2]});
    }
    /// Half the surface; 0 when empty.
    float halfArea() const
    {
        const Float4 e = high - low;
        return empty() ? 0.0f : e[0] * (e[1] + e[2]) + e[1] * e[2];
    }
};

inline Box intersection(const Box& a, const Box& b)
{
    return {maximum(a.low, b.low), minimum(a.high, b.high)};
}

/// 32 bytes. The triangle sits in the fourth lane of `low`, offset so that as a float it is a
/// normal number: arithmetic on the lane is then meaningless but not slow.
struct Reference {
    Float4 low, high;

    static constexpr uint32_t kTag = 0x40000000u;
    static Reference make(const Box& box, uint32_t triangle)
    {
        Reference r{box.low, box.high};
        r.low[3] = std::bit_cast<float>(triangle + kTag);
        r.high[3] = 0;
        return r;
    }
    uint32_t triangle() const { return std::bit_cast<uint32_t>(low[3]) - kTag; }
    Float4 centroidTwice() const { return low + high; }
    Box box() const { return {low, high}; }
};

/// Bounds of references and of their (doubled) centroids.
struct RangeBounds {
    Box box, centroids;

    void grow(const Reference& r)
    {
        box.grow(r.box());
        centroids.grow(r.centroidTwice());
    }
    void grow(const RangeBounds& b)
    {
        box.grow(b.box);
        centroids.grow(b.centroids);
    }
};

/// References [begin, end) of the builder's array, with free room up to `capacity` for duplicates.
struct Range {
    size_t begin = 0, end = 0, capacity = 0;

    size_t size() const { return end - begin; }
    size_t room() const { return capacity - end; }
};

/// Into sets of references by their centroids, or by their sizes, or by how far they reach from
/// where most of them are, or by a plane that cuts them.
enum class SplitKind { centroid, size, reach, space };

/// A candidate: cost is leftArea * leftCount + rightArea * rightCount. axis < 0: none found.
struct Split {
    float cost = kHuge;
    SplitKind kind = SplitKind::centroid;
    int axis = -1;                // of a split by size or reach 0
    int bin = 0;                  // all but space: the left side holds the bins below
    float origin = 0, scale = 0;  // centroid: bin = (doubled centroid - origin) * scale
    float plane = 0;              // space: where it cuts
    int largest = 0;              // size, reach: exponentOf the largest
    Float4 centre{};              // reach: from where it counts
    size_t leftCount = 0, rightCount = 0;
    Box left, right;
};

constexpr int kBins = 16;  // at most

/// A length as a power of two, counted as floats do.
inline int exponentOf(float length)
{
    return static_cast<int>(std::bit_cast<uint32_t>(std::max(length, 0.0f)) >> 23);
}

/// How far a box reaches from a place, along the axis where that is farthest.
inline float reachOf(const Box& box, Float4 centre)
{
    const Float4 d = maximum(centre - box.low, box.high - centre);
    return std::max({d[0], d[1], d[2]});
}

/// The bin of a reference in a split by size or reach. The last one holds those with the exponent
/// `largest`, each one before half as large ones.
inline int scaleBin(const Reference& r, const Split& split)
{
    const float length =
        split.kind == SplitKind::size ? r.box().extent() : reachOf(r.box(), split.centre);
    return std::clamp(kBins - 1 - (split.largest - exponentOf(length)), 0, kBins - 1);
}

/// An instance as a tree holds it, in the place of a triangle.
struct InstanceLeaf {
    Box box;
    std::array<shared::uvec4, 4> words;  // how it is entered: see Bvh
    float cost = 0;                      // of a ray through it, in tests of pairs of boxes
};

/// What the splits read besides references. Numbers of triangles go on with those of instances.
struct Mesh {
    std::span<const glm::vec3> positions;
    std::span<const WorldTriangle> triangles;
    std::span<const InstanceLeaf> instances{};

    /// Null for a triangle.
    const InstanceLeaf* instance(uint32_t number) const
    {
        return number < triangles.size() ? nullptr : &instances[number - triangles.size()];
    }
};

inline Float4 load(const glm::vec3& v)
{
    return Float4{v.x, v.y, v.z, 0};
}

/// Bounds of a triangle or instance.
Box boundsOf(const Mesh& mesh, uint32_t number);

/// Bounds of all references of a range.
RangeBounds boundsOf(std::span<const Reference> references);

/// Best split of the references into two sets by centroid.
Split findObjectSplit(std::span<const Reference> references, const RangeBounds& bounds);

/// Best split into small references, on the left, and large ones, by powers of two of the extent.
Split findSizeSplit(std::span<const Reference> references, const RangeBounds& bounds);

/// Best split into those near the median of the centroids, on the left, and those that reach
/// farther, by powers of two: a room and the dome around it, also where the room's walls are larger
/// than the triangles of the dome.
Split findReachSplit(std::span<const Reference> references, const RangeBounds& bounds);

/// Best split of the box by a plane; references across it go to both sides. Not for instances.
Split findSpatialSplit(const Mesh& mesh, std::span<const Reference> references, const Box& bounds);

/// Carries out a split other than by space; returns where the right side begins.
size_t partitionObjects(std::span<Reference> references, const Split& split, RangeBounds& left,
                        RangeBounds& right);

/// Carries out a spatial split on `all[range]`, appending the parts of cut references to its end
/// (range.end grows, at most to range.capacity; references that find no room, or that cost less
/// whole, stay whole on one side). Returns where the right side begins.
size_t partitionSpace(const Mesh& mesh, std::span<Reference> all, Range& range, const Split& split,
                      RangeBounds& left, RangeBounds& right);

/// Splits in the middle of the order of centroids along the widest axis: always possible from two
/// references on.
size_t partitionMedian(std::span<Reference> references, const RangeBounds& bounds,
                       RangeBounds& left, RangeBounds& right);

/// Bounds of the part of a triangle between two planes perpendicular to `axis`, cut to `box`;
/// conservative.
Box clipTriangle(const Mesh& mesh, uint32_t triangle, const Box& box, int axis, float low,
                 float high);

}  // namespace core::bvh
