// The directions in which paths go on, by the BSDF alone. One of the pairs that path.h may run
// with: a source file or kernel that defines REKINDLE_OWN_DIRECTIONS before it includes path.h
// declares these two functions itself, over whatever else it knows of the vertex (a guide, say),
// and the rest of the estimator stays as it is. In C++ such a file must define REKINDLE_FEATURES,
// too, which makes the functions its own; its `scene` may be of a type that is derived from
// SceneView.
#ifndef REKINDLE_SHARED_DIRECTIONS_H
#define REKINDLE_SHARED_DIRECTIONS_H

#include "vertex.h"

SHARED_BEGIN

/// Draws the direction in which the path goes on (next.wi, in the surface's frame) with
/// next.weight = f cos / pdf. next.pdf is the density in solid angle of *all* ways to draw it, 0
/// for delta lobes. False when the path ends here.
SHARED_FN bool sampleDirection(IN(SceneView), IN(Vertex) vertex, VertexNumbers numbers,
                               OUT(BsdfSample) next)
{
    return sampleLobes(vertex.bsdf, vertex.lobes, vertex.wo, numbers.lobe.x, numbers.bsdf, next);
}

/// Density with which sampleDirection draws a direction (the third argument, in the surface's
/// frame). `bsdfPdf` is that of the BSDF, which the caller has had to evaluate anyway.
SHARED_FN float pdfDirection(IN(SceneView), IN(Vertex), vec3, float bsdfPdf)
{
    return bsdfPdf;
}

SHARED_END

#endif
