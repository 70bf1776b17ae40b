// Absorption within transmissive solids (KHR_materials_volume), one text for GPU and CPU.
#ifndef REKINDLE_SHARED_MEDIUM_H
#define REKINDLE_SHARED_MEDIUM_H

#include "surface.h"

SHARED_BEGIN

// A medium is named by the material of the solid that it fills; kNone: nothing absorbs. A path
// knows the last solid that it has entered and not left: in one within another it is in the inner
// one, and behind that in none until it meets the outer one from within.

/// The medium behind a surface that was reached through `medium`.
SHARED_FN uint mediumBehind(uint medium, IN(SurfacePoint) s, IN(Bsdf) bsdf)
{
    if (!FEATURE(kFeatureVolume) || (bsdf.parts & kBsdfSolid) == 0u) return medium;
    return s.backFace != 0u ? kNone : s.material;
}

/// Absorption in a medium, 1/metre.
SHARED_FN vec3 absorptionOf(IN(SceneView) scene, uint medium)
{
    return medium == kNone ? vec3(0.0f, 0.0f, 0.0f) : xyz(fetchMaterial(scene, medium, 4u));
}

/// What is left of light after a way of finite length through a medium.
SHARED_FN vec3 transmittance(IN(SceneView) scene, uint medium, float distance)
{
    if (!FEATURE(kFeatureVolume) || medium == kNone) return vec3(1.0f, 1.0f, 1.0f);
    return exp(-distance * xyz(fetchMaterial(scene, medium, 4u)));
}

SHARED_END

#endif
