// Meshes that are stored once, as prototypes in a space of their own, and shown by many instances:
// from the slot of a hit to the triangle as it is stored, and to where it is in the world. The slot
// alone says which instance was hit, so that whatever keeps hits keeps these too.
//
// The table: word 0 is (number of prototypes, 0, 0, 0); then one word per prototype: first slot of
// its first instance; bits by which the slots of its instances are apart; slot of its first
// triangle as it is stored; word of its first instance's matrix. Then the matrices,
// kInstanceMatrixWords each.
#ifndef REKINDLE_SHARED_INSTANCES_H
#define REKINDLE_SHARED_INSTANCES_H

#include "scene.h"

SHARED_BEGIN

/// Where a triangle is stored, and the word of the matrix that takes it to the world; 0: it is
/// there already.
struct StoredTriangle {
    uint slot;
    uint matrix;
};

/// A triangle in the world; w as fetchTriangleVertex has it.
struct Triangle {
    vec4 v0;
    vec4 v1;
    vec4 v2;
};

SHARED_FN StoredTriangle findTriangle(IN(SceneView) scene, uint slot)
{
    StoredTriangle found;
    found.slot = slot;
    found.matrix = 0u;
    if (hasInstances(scene) && slot >= kFirstInstancedSlot) {
        uint low = 1u;  // the last word whose first slot is not behind is here or later,
        uint high = fetchInstanceWord(scene, 0u).x + 1u;  // but before this one
        while (high - low > 1u) {
            const uint middle = (low + high) >> 1u;
            const bool behind = fetchInstanceWord(scene, middle).x > slot;
            low = behind ? low : middle;
            high = behind ? middle : high;
        }
        const uvec4 prototype = fetchInstanceWord(scene, low);
        const uint offset = slot - prototype.x;
        const uint instance = offset >> prototype.y;
        found.slot = prototype.z + (offset - (instance << prototype.y));
        found.matrix = prototype.w + kInstanceMatrixWords * instance;
    }
    return found;
}

SHARED_FN InstanceMatrix fetchInstanceMatrix(IN(SceneView) scene, uint word)
{
    const uvec4 a = fetchInstanceWord(scene, word);
    const uvec4 b = fetchInstanceWord(scene, word + 1u);
    const uvec4 c = fetchInstanceWord(scene, word + 2u);
    InstanceMatrix m;
    m.row0 = vec4(uintAsFloat(a.x), uintAsFloat(a.y), uintAsFloat(a.z), uintAsFloat(a.w));
    m.row1 = vec4(uintAsFloat(b.x), uintAsFloat(b.y), uintAsFloat(b.z), uintAsFloat(b.w));
    m.row2 = vec4(uintAsFloat(c.x), uintAsFloat(c.y), uintAsFloat(c.z), uintAsFloat(c.w));
    return m;
}

SHARED_FN vec3 transformVector(IN(InstanceMatrix) m, vec3 v)
{
    return vec3(dot(xyz(m.row0), v), dot(xyz(m.row1), v), dot(xyz(m.row2), v));
}

SHARED_FN vec3 transformPoint(IN(InstanceMatrix) m, vec3 p)
{
    return transformVector(m, p) + vec3(m.row0.w, m.row1.w, m.row2.w);
}

SHARED_FN Triangle fetchTriangle(IN(SceneView) scene, StoredTriangle stored)
{
    Triangle t;
    t.v0 = fetchTriangleVertex(scene, stored.slot, 0u);
    t.v1 = fetchTriangleVertex(scene, stored.slot, 1u);
    t.v2 = fetchTriangleVertex(scene, stored.slot, 2u);
    if (FEATURE(kFeatureInstances) && stored.matrix != 0u) {
        const InstanceMatrix m = fetchInstanceMatrix(scene, stored.matrix);
        t.v0 = vec4(transformPoint(m, xyz(t.v0)), t.v0.w);
        t.v1 = vec4(transformPoint(m, xyz(t.v1)), t.v1.w);
        t.v2 = vec4(transformPoint(m, xyz(t.v2)), t.v2.w);
    }
    return t;
}

/// The largest number that is added to bring a point to the world.
SHARED_FN float placedBy(IN(InstanceMatrix) m)
{
    return maxComponent(abs(vec3(m.row0.w, m.row1.w, m.row2.w)));
}

/// The same of a stored triangle's points.
SHARED_FN float placedBy(IN(SceneView) scene, StoredTriangle stored)
{
    if (!FEATURE(kFeatureInstances) || stored.matrix == 0u) return 0.0f;
    return placedBy(fetchInstanceMatrix(scene, stored.matrix));
}

/// A unit normal at a stored triangle, in the world: by the matrix of cofactors, and so reversed
/// where it mirrors.
SHARED_FN vec3 placedNormal(IN(SceneView) scene, StoredTriangle stored, vec3 n)
{
    if (!FEATURE(kFeatureInstances) || stored.matrix == 0u) return n;
    const InstanceMatrix m = fetchInstanceMatrix(scene, stored.matrix);
    return normalize(vec3(dot(cross(xyz(m.row1), xyz(m.row2)), n),
                          dot(cross(xyz(m.row2), xyz(m.row0)), n),
                          dot(cross(xyz(m.row0), xyz(m.row1)), n)));
}

/// A tangent at a stored triangle, in the world; in an instance its length is lost.
SHARED_FN vec3 placedTangent(IN(SceneView) scene, StoredTriangle stored, vec3 t)
{
    if (!FEATURE(kFeatureInstances) || stored.matrix == 0u) return t;
    const vec3 placed = transformVector(fetchInstanceMatrix(scene, stored.matrix), t);
    const float length2 = dot(placed, placed);
    return length2 > 0.0f ? placed * inversesqrt(length2) : placed;
}

/// The triangle in a slot, of an instance or not.
SHARED_FN Triangle triangleInSlot(IN(SceneView) scene, uint slot)
{
    return fetchTriangle(scene, findTriangle(scene, slot));
}

SHARED_END

#endif
