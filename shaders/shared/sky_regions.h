// Where the sky is seen from a place: next-event estimation in a room draws the environment as it
// shines through the windows, not the whole of it. Places are regions, leaves of kd-trees over
// points that paths come to, one tree for each dominant axis of the normal; a region holds a table
// over the unit square from which the environment is drawn (its primary sample space), so that a
// cell of the table is a part of the sky that shines as much as any other, and inside a cell
// directions still follow the environment. In the manner of A. Atanasov et al., "Adaptive
// Environment Sampling on CPU and GPU" (SIGGRAPH Talks 2018); what differs: primary sample space in
// place of tiles of the image, the normal, and tables that are made before the first sample
// (core/trace/sky_regions.h), a function of the scene alone.
#ifndef REKINDLE_SHARED_SKY_REGIONS_H
#define REKINDLE_SHARED_SKY_REGIONS_H

#include "layout.h"
#include "scene.h"

SHARED_BEGIN

// Words: the first two hold six roots. A reference is the index of a node's word, or that of a
// region's first word with the highest bit set. A node: where its plane is (as a float), its axis,
// the reference below the plane and that above. A region: a word with the share of the environment
// among the choices of an emitter, the CDF over rows of cells, one over the cells of each row;
// upper ends only. Region 0 means none: the environment as a whole.
SHARED_CONST uint kSkyRegionBit = 0x80000000u;
SHARED_CONST uint kSkyRoots = 6u;
SHARED_CONST uint kSkyRootWords = 2u;
SHARED_CONST uint kSkySide = 16u;  // cells of a table in a row
SHARED_CONST uint kSkyCdfWords = kSkySide / 4u;
SHARED_CONST uint kSkyRegionWords = 1u + kSkyCdfWords * (1u + kSkySide);

/// The tree for a surface whose normal is n: 0 to 5 for +x, -x, +y, -y, +z, -z, by its largest
/// component.
SHARED_FN uint skyRoot(vec3 n)
{
    const vec3 a = abs(n);
    if (a.x >= a.y && a.x >= a.z) return n.x < 0.0f ? 1u : 0u;
    if (a.y >= a.z) return n.y < 0.0f ? 3u : 2u;
    return n.z < 0.0f ? 5u : 4u;
}

/// The region at p of surfaces that look towards n; 0 where there is none.
SHARED_FN uint findSkyRegion(IN(SceneView) scene, vec3 p, vec3 n)
{
    const uint root = skyRoot(n);
    uint reference = fetchSkyRegions(scene, root >> 2u)[root & 3u];
    while ((reference & kSkyRegionBit) == 0u) {
        const uvec4 node = fetchSkyRegions(scene, reference);
        const float x = node.y == 0u ? p.x : (node.y == 1u ? p.y : p.z);
        reference = x < uintAsFloat(node.x) ? node.z : node.w;
    }
    return reference & ~kSkyRegionBit;
}

/// With what probability an emitter that is chosen in a region is the environment.
SHARED_FN float skyShare(IN(SceneView) scene, uint region)
{
    return uintAsFloat(fetchSkyRegions(scene, region).x);
}

/// Inverts a CDF of kSkySide parts; u is stretched inside the part.
SHARED_FN uint pickSkyPart(IN(SceneView) scene, uint word, INOUT(float) u, OUT(float) pmf)
{
    float low = 0.0f;
    uint part = 0u;
    vec4 ends = uintBitsToFloat(fetchSkyRegions(scene, word));
    while (u >= ends.w && part + 4u < kSkySide) {
        low = ends.w;
        part += 4u;
        ends = uintBitsToFloat(fetchSkyRegions(scene, word + (part >> 2u)));
    }
    float high = ends.x;
    if (u >= ends.x) {
        low = u >= ends.z ? ends.z : (u >= ends.y ? ends.y : ends.x);
        high = u >= ends.z ? ends.w : (u >= ends.y ? ends.z : ends.y);
        part += u >= ends.z ? 3u : (u >= ends.y ? 2u : 1u);
    }
    pmf = high - low;
    u = pmf > 0.0f ? min((u - low) / pmf, kOneMinusEpsilon) : 0.5f;
    return part;
}

/// Probability of a part of such a CDF.
SHARED_FN float pmfSkyPart(IN(SceneView) scene, uint word, uint part)
{
    const float high = uintAsFloat(fetchSkyRegions(scene, word + (part >> 2u))[part & 3u]);
    if (part == 0u) return high;
    const uint before = part - 1u;
    return high - uintAsFloat(fetchSkyRegions(scene, word + (before >> 2u))[before & 3u]);
}

/// Turns uniform numbers into those that lead the environment's CDF to what the region sees;
/// returns their density.
SHARED_FN float warpToSky(IN(SceneView) scene, uint region, INOUT(vec2) u)
{
    float row;
    float cell;
    const uint y = pickSkyPart(scene, region + 1u, u.y, row);
    const uint x = pickSkyPart(scene, region + 1u + kSkyCdfWords * (1u + y), u.x, cell);
    u = min((vec2(float(x), float(y)) + u) * (1.0f / float(kSkySide)), vec2(kOneMinusEpsilon));
    return row * cell * float(kSkySide * kSkySide);
}

/// Density of the numbers that warpToSky makes.
SHARED_FN float skyDensity(IN(SceneView) scene, uint region, vec2 u)
{
    const uint last = kSkySide - 1u;
    const uint x = min(uint(u.x * float(kSkySide)), last);
    const uint y = min(uint(u.y * float(kSkySide)), last);
    return pmfSkyPart(scene, region + 1u, y) *
           pmfSkyPart(scene, region + 1u + kSkyCdfWords * (1u + y), x) * float(kSkySide * kSkySide);
}

SHARED_END

#endif
