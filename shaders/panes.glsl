// Connections through panes, for kernels that trace them.
#include "traverse.glsl"
#include "shared/connection.h"

/// Whether a connection that has met a surface in that slot comes to its end nonetheless, through panes, by which it is
/// dimmed; counts its rays.
bool comesThrough(uint slot, uint seed, inout ShadowRay shadow, inout uint rays)
{
    // Whatever blocks, blocks: only from a pane it is of use to look for the nearest surface.
    if (!mayBePane(scene, slot)) return false;
    Hit hit;
    bool meets = true;
    bool goes = true;
    while (meets && goes) {
        ++rays;
        meets = traceClosest(Ray(shadow.origin, 0.0, shadow.direction, shadow.tMax), seed, hit);
        if (meets) goes = passPane(scene, hit, shadow);
    }
    return !meets;
}
