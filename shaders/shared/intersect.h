// Rays against the boxes and the triangles of the flat BVH (core/trace/bvh.h), one text for both
// languages.
//   Boxes: slabs on the 16-bit grid; the slack makes them conservative for any origin.
//   Triangles: Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013. The
//   paper permutes the axes of every vertex; here shear and permutation are one 3x3 matrix per ray,
//   since a product by 0 or 1 is exact and a permutation that differs between SIMD lanes is dear.
//   Zero edge functions count as inside, so the paper's fall-back to double precision (which
//   decides between two triangles) is not needed.
#ifndef REKINDLE_SHARED_INTERSECT_H
#define REKINDLE_SHARED_INTERSECT_H

#include "lang.h"

SHARED_BEGIN

/// Words of a child reference: a leaf has bit 31, its triangle count (at most 14) in bits 27..30
/// and its first slot below. From kBvhChange on there is nothing to test: a change of grid or of
/// space (see Bvh) has the number of the node that describes it below these bits, and the last word
/// is kBvhDone.
SHARED_CONST uint kBvhLeaf = 0x80000000u;
SHARED_CONST uint kBvhCountShift = 27u;
SHARED_CONST uint kBvhCountMask = 15u;
SHARED_CONST uint kBvhIndexMask = 0x07ffffffu;
SHARED_CONST uint kBvhChange = 0xf8000000u;
SHARED_CONST uint kBvhDone = 0xffffffffu;  // bottom of the stack; the children of an empty tree
// What the second word of a change holds where it leads into an instance, or back out of one.
SHARED_CONST uint kBvhInstance = 0u;
SHARED_CONST uint kBvhWorld = 1u;
SHARED_CONST uint kBvhStackSize = 64u;  // the builder's depth is at most kBvhMaxDepth
SHARED_CONST uint kBvhMaxDepth = 60u;

/// A ray as boxes see it: t of a grid plane q is q * inverse - offset. The offsets of low and high
/// planes hold the slack, which moves the planes apart whatever the direction.
struct GridRay {
    vec3 inverse;
    vec3 offsetLow;
    vec3 offsetHigh;
};

/// Where rays begin (core::entryOf): at node 0, or, where that one leads to a part of the scene
/// that is far smaller, such as a room on a ground of kilometres, in there, on its own grid. What
/// surrounds the part is looked at last, and only by rays that get there.
struct BvhEntry {
    vec3 gridLow;  // cell = (x - gridLow) * gridScale
    uint node;
    vec3 gridScale;
    uint way;  // the change that leads out to the surroundings; kBvhDone: there are none
    vec3 outerLow;
    uint apart;  // 1: nothing of them is within the grid
    vec3 outerScale;
    uint unused;
    uvec4 surroundings;  // their record, on the outer grid
};

/// A ray as triangles see it: rows of the matrix that maps vertices, relative to the origin, to the
/// plane perpendicular to the major axis (x, y) and to t (z).
struct ShearRay {
    vec3 origin;
    vec3 rowX;
    vec3 rowY;
    vec3 rowZ;
};

/// Whether a ray can be traced at all: finite, with a direction.
SHARED_FN bool isTraceable(vec3 origin, vec3 direction)
{
    float o = abs(origin.x) + abs(origin.y) + abs(origin.z);
    float d = abs(direction.x) + abs(direction.y) + abs(direction.z);
    bool finite = (floatAsUint(o) & 0x7f800000u) != 0x7f800000u &&
                  (floatAsUint(d) & 0x7f800000u) != 0x7f800000u;
    return finite && d > 1e-30f;
}

/// `gridLow`, `gridScale` as Bvh holds them: cell = (x - gridLow) * gridScale.
SHARED_FN GridRay makeGridRay(vec3 origin, vec3 direction, vec3 gridLow, vec3 gridScale)
{
    GridRay r;
    vec3 o = (origin - gridLow) * gridScale;
    vec3 d = direction * gridScale;
    // A vanishing component is replaced by one that moves the ray by less than 1e-6 cells across
    // the whole grid.
    float tiny = 1e-12f * maxComponent(abs(d));
    d.x = abs(d.x) > tiny ? d.x : (d.x < 0.0f ? -tiny : tiny);
    d.y = abs(d.y) > tiny ? d.y : (d.y < 0.0f ? -tiny : tiny);
    d.z = abs(d.z) > tiny ? d.z : (d.z < 0.0f ? -tiny : tiny);
    r.inverse = vec3(1.0f) / d;
    // Rounding of the origin, of the product and of the difference, each half a unit in the last
    // place of |o| or of 2^16; and how far the replaced component takes the ray on its way here.
    vec3 far = abs(o);
    vec3 slack = vec3(0.02f + 1e-12f * maxComponent(far)) + 5e-7f * far;
    r.offsetLow = (o + slack) * r.inverse;
    r.offsetHigh = (o - slack) * r.inverse;
    return r;
}

/// The same for the grid that the two words of a change of grid name.
SHARED_FN GridRay makeGridRayOf(vec3 origin, vec3 direction, uvec4 low, uvec4 scale)
{
    return makeGridRay(origin, direction,
                       vec3(uintAsFloat(low.x), uintAsFloat(low.y), uintAsFloat(low.z)),
                       vec3(uintAsFloat(scale.x), uintAsFloat(scale.y), uintAsFloat(scale.z)));
}

/// tMin or tMax for intersectBox: the bits of a float, negative ones as zero.
SHARED_FN int boxBound(float t)
{
    return max(floatBitsToInt(t), 0);
}

/// Where the ray is inside the box of one child record, cut to [tMin, tMax] (as boxBound made
/// them); it misses when x > y. All are bits of floats, compared as integers: that order is the
/// floats' own but for negative ones among themselves, which matter to nobody, since tMin is not
/// negative. Unlike min and max of floats it has no NaN to care for, which on the CPU device costs
/// two more instructions each.
SHARED_FN ivec2 intersectBox(GridRay r, uvec4 child, int tMin, int tMax)
{
    ivec3 a = floatBitsToInt(
        vec3(ivec3(int(child.x & 0xffffu), int(child.y & 0xffffu), int(child.z & 0xffffu))) *
            r.inverse -
        r.offsetLow);
    ivec3 b = floatBitsToInt(
        vec3(ivec3(int(child.x >> 16), int(child.y >> 16), int(child.z >> 16))) * r.inverse -
        r.offsetHigh);
    ivec3 first = min(a, b);
    ivec3 last = max(a, b);
    return ivec2(max(max(first.x, first.y), max(first.z, tMin)),
                 min(min(last.x, last.y), min(last.z, tMax)));
}

/// Whether a ray that has found all there is where it began, the nearest at `tMax`, may find
/// something in the surroundings, nearer than that; `grid` is then the ray on theirs. tMin and tMax
/// as boxBound made them.
SHARED_FN bool goesOutside(BvhEntry entry, vec3 origin, vec3 direction, int tMin, int tMax,
                           INOUT(GridRay) grid)
{
    // A cell from the borders, which is more than the slack.
    const uint inner = 0xfffe0001u;
    const ivec2 within = intersectBox(grid, uvec4(inner, inner, inner, 0u), tMin, 0x7f800000);
    const bool ends = entry.apart != 0u && within.x <= tMin && tMax < within.y;
    grid = makeGridRay(origin, direction, entry.outerLow, entry.outerScale);
    const ivec2 outside = intersectBox(grid, entry.surroundings, tMin, tMax);
    return !ends && outside.x <= outside.y;
}

/// `direction` is not zero and need not be of unit length; t counts in its lengths.
SHARED_FN ShearRay makeShearRay(vec3 origin, vec3 direction)
{
    ShearRay r;
    r.origin = origin;
    vec3 a = abs(direction);
    bool majorX = a.x >= a.y && a.x >= a.z;
    bool majorY = !majorX && a.y >= a.z;
    float inverse = 1.0f / (majorX ? direction.x : (majorY ? direction.y : direction.z));
    vec3 s = -direction * inverse;
    r.rowX =
        majorX ? vec3(s.y, 1.0f, 0.0f) : (majorY ? vec3(0.0f, s.z, 1.0f) : vec3(1.0f, 0.0f, s.x));
    r.rowY =
        majorX ? vec3(s.z, 0.0f, 1.0f) : (majorY ? vec3(1.0f, s.x, 0.0f) : vec3(0.0f, 1.0f, s.y));
    r.rowZ = majorX ? vec3(inverse, 0.0f, 0.0f)
                    : (majorY ? vec3(0.0f, inverse, 0.0f) : vec3(0.0f, 0.0f, inverse));
    return r;
}

/// Both sides of the triangle, tMin < t < tMax. `barycentrics` are the weights of v1 and v2.
/// Outputs are meaningful only when it returns true. A triangle seen edge-on is missed.
SHARED_FN bool intersectTriangle(ShearRay r, vec3 v0, vec3 v1, vec3 v2, float tMin, float tMax,
                                 OUT(float) t, OUT(vec2) barycentrics)
{
    vec3 a = v0 - r.origin;
    vec3 b = v1 - r.origin;
    vec3 c = v2 - r.origin;
    PRECISE float ax = r.rowX.x * a.x + r.rowX.y * a.y + r.rowX.z * a.z;
    PRECISE float ay = r.rowY.x * a.x + r.rowY.y * a.y + r.rowY.z * a.z;
    PRECISE float bx = r.rowX.x * b.x + r.rowX.y * b.y + r.rowX.z * b.z;
    PRECISE float by = r.rowY.x * b.x + r.rowY.y * b.y + r.rowY.z * b.z;
    PRECISE float cx = r.rowX.x * c.x + r.rowX.y * c.y + r.rowX.z * c.z;
    PRECISE float cy = r.rowY.x * c.x + r.rowY.y * c.y + r.rowY.z * c.z;
    // Separately rounded products order as the exact ones do, so the sign is right or zero, and the
    // neighbour across an edge gets exactly the opposite value.
    PRECISE float u = cx * by - cy * bx;
    PRECISE float v = ax * cy - ay * cx;
    PRECISE float w = bx * ay - by * ax;
    float det = u + v + w;
    float inverse = 1.0f / det;
    barycentrics = vec2(v * inverse, w * inverse);
    t = u * inverse * dot(r.rowZ, a) + barycentrics.x * dot(r.rowZ, b) +
        barycentrics.y * dot(r.rowZ, c);
    bool inside = (u >= 0.0f && v >= 0.0f && w >= 0.0f) || (u <= 0.0f && v <= 0.0f && w <= 0.0f);
    return inside && det != 0.0f && t > tMin && t < tMax;
}

SHARED_END

#endif
