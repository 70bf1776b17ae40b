// Closest and any hit on the flat BVH (core/trace/bvh.h): while-while, with a push and a pop without branches.
//   Aila, Laine, "Understanding the efficiency of ray traversal on GPUs", 2009 (the loop). Three habits of Mesa's CPU
//   device shape it: a masked store or a divergent branch costs more than arithmetic, so the far child is always written
//   above the top of the stack and only the top moves; the body of a loop runs once more after the last lane has left it
//   at its head, so all loops test at their end; min and max of floats cost three instructions, of integers one.
//   The same device leaves every loop once the loops of an invocation have turned 65535 times in sum: a ray takes some
//   hundreds, or thousands in soups of long triangles, so a kernel should not trace more than some tens in a row. Rays
//   that are cut short are counted.
#ifndef REKINDLE_TRAVERSE_GLSL
#define REKINDLE_TRAVERSE_GLSL

#include "frame.glsl"
#include "scene.glsl"
#include "shared/intersect.h"
#include "shared/surface.h"

struct Ray {
    vec3 origin;
    float tMin;
    vec3 direction;
    float tMax;
};

// Steps down from inner nodes until every lane is at a leaf or done: pushes the farther child if both are hit, pops if
// none is. A macro, since an array as an argument would be copied in and out at every step.
#define BVH_STEP_DOWN(grid, node, tMin, tMax)                        \
    do {                                                             \
        uvec4 a = fetchNode(2u * node);                              \
        uvec4 b = fetchNode(2u * node + 1u);                         \
        ivec2 ta = intersectBox(grid, a, tMin, tMax);                \
        ivec2 tb = intersectBox(grid, b, tMin, tMax);                \
        bool hitA = ta.x <= ta.y;                                    \
        bool hitB = tb.x <= tb.y;                                    \
        bool aFirst = hitA && (!hitB || ta.x <= tb.x);               \
        uint popped = stack[top];                                    \
        stack[top + 1] = aFirst ? b.w : a.w;                         \
        top += hitA && hitB ? 1 : (hitA || hitB ? 0 : -1);           \
        node = hitA || hitB ? (aFirst ? a.w : b.w) : popped;         \
    } while ((node & kBvhLeaf) == 0u)

/// The ray in the space of the triangles that it is among: the world or a prototype, whose slots are `offset` away from
/// the slots of the instance, counted from 1 (0: of none).
struct LocalRay {
    vec3 origin;
    vec3 direction;
    uint offset;
    uint instance;
};

/// Follows a change of grid or of space (core/trace/bvh.h): `node` becomes where it leads to, `grid` what lies there;
/// `back` the way back, or kBvhDone where this was one.
void followChange(Ray r, inout uint node, inout LocalRay ray, inout GridRay grid, inout ShearRay shear, out uint back)
{
    uint change = 2u * (node & kBvhIndexMask);
    uvec4 a = fetchNode(change);
    uvec4 b = fetchNode(change + 1u);
    back = a.w == kBvhDone ? kBvhDone : node + 1u;
    if (FEATURE(kFeatureInstances) && b.w != kBvhDone) {
        ray = LocalRay(r.origin, r.direction, 0u, 0u);
        if (b.w == kBvhInstance) {
            uvec4 c = fetchNode(change + 2u);
            uvec4 d = fetchNode(change + 3u);
            vec3 row0 = uintBitsToFloat(a.xyz);
            vec3 row1 = uintBitsToFloat(b.xyz);
            vec3 row2 = uintBitsToFloat(c.xyz);
            ray.origin = vec3(dot(row0, r.origin), dot(row1, r.origin), dot(row2, r.origin)) + uintBitsToFloat(d.xyz);
            ray.direction = vec3(dot(row0, r.direction), dot(row1, r.direction), dot(row2, r.direction));
            ray.offset = c.w;
            ray.instance = d.w;
            back = node + 2u;
            uint root = 2u * (a.w & kBvhIndexMask);
            a = fetchNode(root);
            b = fetchNode(root + 1u);
        }
        shear = makeShearRay(ray.origin, ray.direction);
    }
    node = a.w;
    grid = makeGridRayOf(ray.origin, ray.direction, a, b);
}

/// What makes lanes wait for the others before they go on.
const uint kStops = kFeatureAlpha | kFeatureGridChanges | kFeatureInstances | kFeatureSurroundings;

/// Both traversals; `anyHit` is a literal, so each is compiled for itself. hit.t holds tMax at first, hit.slot kNone.
/// A hit that needs the alpha test stops its lane, which goes on where it was once all lanes have stopped or are done:
/// the test, which costs as much as several triangles even when no lane wants it, is then run a few times per ray
/// rather than with every triangle.
void traverse(Ray r, uint alphaSeed, bool anyHit, inout Hit hit)
{
    GridRay grid = makeGridRay(r.origin, r.direction, frame.entry.gridLow, frame.entry.gridScale);
    ShearRay shear = makeShearRay(r.origin, r.direction);
    LocalRay ray = LocalRay(r.origin, r.direction, 0u, 0u);
    int nearest = boxBound(r.tMin);
    uint stack[kBvhStackSize];
    stack[0] = kBvhDone;
    stack[1] = frame.entry.way;
    int top = FEATURE(kFeatureSurroundings) ? 1 : 0;
    uint node = FEATURE(kFeatureSurroundings) ? frame.entry.node : 0u;
    bool waits = false;  // for the alpha test of `candidate`
    Hit candidate = hit;
    do {
        do {
            if ((node & kBvhLeaf) == 0u) {
                BVH_STEP_DOWN(grid, node, nearest, boxBound(hit.t));
            }
            if (node < kBvhChange) {
                uint slot = node & kBvhIndexMask;
                uint end = slot + ((node >> kBvhCountShift) & kBvhCountMask);
                do {
                    vec4 v0 = fetchTriangleVertex(scene, slot, 0u);
                    vec4 v1 = fetchTriangleVertex(scene, slot, 1u);
                    vec4 v2 = fetchTriangleVertex(scene, slot, 2u);
                    float t;
                    vec2 barycentrics;
                    bool found = intersectTriangle(shear, v0.xyz, v1.xyz, v2.xyz, r.tMin, hit.t, t, barycentrics);
                    if (FEATURE(kFeatureAlpha)) {
                        waits = found && (floatBitsToUint(v1.w) & kTriangleAlphaBit) != 0u;
                        candidate.t = t;
                        candidate.barycentrics = barycentrics;
                        candidate.slot = slot;
                        found = found && !waits;
                    }
                    hit.t = found ? t : hit.t;
                    hit.barycentrics = found ? barycentrics : hit.barycentrics;
                    hit.slot = found ? slot + ray.offset : hit.slot;
                    ++slot;
                } while (slot < end && !waits);
                bool leafGoesOn = waits && slot < end;
                node = leafGoesOn ? kBvhLeaf | ((end - slot) << kBvhCountShift) | slot : stack[top];
                top -= leafGoesOn ? 0 : 1;
                node = anyHit && hit.slot != kNone ? kBvhDone : node;
            }
        } while (node < kBvhChange && !waits);
        if (FEATURE(kFeatureAlpha)) {
            if (waits) {
                if (alphaPasses(scene, candidate.slot, ray.instance, candidate.barycentrics, alphaSeed)) {
                    hit = candidate;
                    hit.slot += ray.offset;
                }
                node = anyHit && hit.slot != kNone ? kBvhDone : node;
                waits = false;
            }
        }
        if (FEATURE(kFeatureSurroundings)) {
            if (node == frame.entry.way) {
                bool outside = goesOutside(frame.entry, r.origin, r.direction, nearest, boxBound(hit.t), grid);
                node = outside ? frame.entry.surroundings.w : kBvhDone;
                top = 0;
            }
        }
        if (FEATURE(kFeatureGridChanges | kFeatureInstances)) {
            if (node >= kBvhChange && node != kBvhDone) {
                uint back;
                followChange(r, node, ray, grid, shear, back);
                bool enters = back != kBvhDone;
                uint popped = stack[top];
                stack[top + 1] = back;
                top += enters ? (popped != kBvhDone ? 1 : 0) : -1;
                node = enters ? node : popped;
            }
        }
    } while (FEATURE(kStops) && node != kBvhDone);
    if (node != kBvhDone) atomicAdd(counters.cutRays, 1u);
}

/// Nearest hit with tMin < t < tMax, tMin >= 0; false, and `hit` not meaningful, when there is none, or the ray is not
/// finite or has no direction. t counts in lengths of the direction.
bool traceClosest(Ray r, uint alphaSeed, out Hit hit)
{
    hit.t = r.tMax;
    hit.barycentrics = vec2(0.0f);
    hit.slot = kNone;
    if (isTraceable(r.origin, r.direction)) traverse(r, alphaSeed, false, hit);
    return hit.slot != kNone;
}

/// Whether anything lies at tMin < t < tMax; `hit` is then any of it.
bool traceAnyHit(Ray r, uint alphaSeed, out Hit hit)
{
    hit.t = r.tMax;
    hit.barycentrics = vec2(0.0f);
    hit.slot = kNone;
    if (isTraceable(r.origin, r.direction)) traverse(r, alphaSeed, true, hit);
    return hit.slot != kNone;
}

bool traceAny(Ray r, uint alphaSeed)
{
    Hit hit;
    return traceAnyHit(r, alphaSeed, hit);
}

#endif
