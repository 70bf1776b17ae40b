// Emitters as values: direct sampling of triangles, punctual lights and the sun disk, and the map
// between directions and the environment image. Nothing here reads the scene; lights.h draws from
// what the scene stores, environments too.
#ifndef REKINDLE_SHARED_EMITTER_H
#define REKINDLE_SHARED_EMITTER_H

#include "lang.h"
#include "layout.h"
#include "warp.h"

SHARED_BEGIN

SHARED_CONST float kDistant = 1.0e30f;  // distance of what is infinitely far

/// A direction towards an emitter. Area kinds: radiance = Le, pdf in solid angle given the emitter.
/// Kinds without extent (point, spot, directional): pdf = 0 and radiance = irradiance at normal
/// incidence, so that the reflected radiance is f * cos * radiance. barycentrics: of the second and
/// third vertex of a triangle.
struct EmitterSample {
    vec3 wi;
    float distance;
    vec3 radiance;
    float pdf;
    vec2 barycentrics;
};

SHARED_FN EmitterSample emptyEmitterSample()
{
    EmitterSample s;
    s.wi = vec3(0.0f, 0.0f, 1.0f);
    s.distance = 0.0f;
    s.radiance = vec3(0.0f);
    s.pdf = 0.0f;
    s.barycentrics = vec2(0.0f);
    return s;
}

// --- triangles ---------------------------------------------------------------------------------

// Uniform in area. Uniform in solid angle (Arvo 1995) was measured against it on the Cornell lamp:
// it costs four times as much, and takes away a variance of 1e-4 to 9e-3 of the squared mean on the
// floor and 0.02 on the walls, little beside that of visibility and bounces; where it would pay,
// next to the lamp, directions of the BSDF win.

/// Solid-angle density at p of the triangle a, b, c for the direction wi that meets it at
/// `distance`: 1/area, converted. 0 where the triangle is degenerate or seen exactly edge-on. p is
/// there for samplers that need it.
SHARED_FN float pdfTriangleEmitter(vec3 a, vec3 b, vec3 c, vec3 /*p*/, vec3 wi, float distance)
{
    float projected = abs(dot(cross(b - a, c - a), wi));  // 2 * area * cos
    float pdf = 2.0f * distance * distance / projected;
    return projected > 0.0f && pdf < 1.0e30f ? pdf : 0.0f;
}

/// A point of a triangle light as seen from p. False when p is behind it (unless kEmitterTwoSided),
/// in its plane, or when it has no area.
SHARED_FN bool sampleTriangleEmitter(Emitter e, vec3 p, vec2 u, OUT(EmitterSample) s)
{
    s = emptyEmitterSample();
    vec3 toA = e.a - p;
    vec3 ab = e.b - e.a;
    vec3 ac = e.c - e.a;
    vec2 uv = sampleTriangle(u);
    vec3 d = toA + uv.x * ab + uv.y * ac;
    float square = dot(d, d);
    if (!(square > 0.0f)) {
        return false;
    }
    float inverse = 1.0f / sqrt(square);
    s.wi = d * inverse;
    s.distance = square * inverse;
    float facing = -dot(cross(ab, ac), s.wi);
    if (!(facing > 0.0f || (e.kind & kEmitterTwoSided) != 0u)) {
        return false;
    }
    s.pdf = pdfTriangleEmitter(e.a, e.b, e.c, p, s.wi, s.distance);
    s.radiance = e.radiance;
    s.barycentrics = uv;
    return s.pdf > 0.0f;
}

// --- lights without extent ---------------------------------------------------------------------

/// Point, spot and directional lights. False where they give nothing.
SHARED_FN bool samplePunctual(Emitter e, vec3 p, OUT(EmitterSample) s)
{
    s = emptyEmitterSample();
    uint kind = e.kind & 0xffu;
    if (kind == kEmitterDirectional) {
        s.wi = e.b;
        s.distance = kDistant;
        s.radiance = e.radiance;
        return true;
    }
    vec3 d = e.a - p;
    float square = dot(d, d);
    if (!(square > 1.0e-30f)) {
        return false;
    }
    float inverse = 1.0f / sqrt(square);
    s.wi = d * inverse;
    s.distance = square * inverse;
    float strength = inverse * inverse;
    if (kind == kEmitterSpot) {
        // KHR_lights_punctual: the square of a ramp in the cosine.
        float ramp = clamp(-dot(s.wi, e.b) * e.scale + e.offset, 0.0f, 1.0f);
        strength *= ramp * ramp;
    }
    s.radiance = e.radiance * strength;
    return strength > 0.0f;
}

// --- sun ---------------------------------------------------------------------------------------

/// A direction inside the sun's disk.
SHARED_FN bool sampleSun(Emitter e, vec2 u, OUT(EmitterSample) s)
{
    s = emptyEmitterSample();
    if (!(e.scale > 0.0f)) {
        return false;
    }
    s.wi = toWorld(makeFrame(e.b), sampleCone(u, e.scale));
    s.distance = kDistant;
    s.radiance = e.radiance;
    s.pdf = pdfCone(e.scale);
    return true;
}

/// Density of sampleSun; 0 outside the disk. 1 - cos is taken from the chord, which does not
/// cancel.
SHARED_FN float pdfSun(Emitter e, vec3 wi)
{
    vec3 chord = wi - e.b;
    return 0.5f * dot(chord, chord) <= e.scale && e.scale > 0.0f ? pdfCone(e.scale) : 0.0f;
}

// --- environment -------------------------------------------------------------------------------

/// Latitude-longitude coordinates in [0,1): row 0 is +Y, u = 0 looks to -Z, u = 0.25 to +X.
SHARED_FN vec2 environmentUv(vec3 d)
{
    float across = sqrt(d.x * d.x + d.z * d.z);
    float u = across > 0.0f ? atan(d.x, -d.z) * (0.5f * kInvPi) : 0.0f;
    u = u < 0.0f ? u + 1.0f : u;
    float v = atan(across, d.y) * kInvPi;
    return vec2(min(u, kOneMinusEpsilon), min(v, kOneMinusEpsilon));
}

SHARED_FN vec3 environmentDirection(vec2 uv)
{
    float phi = 2.0f * kPi * uv.x;
    float theta = kPi * uv.y;
    float across = sin(theta);
    return vec3(across * sin(phi), cos(theta), -across * cos(phi));
}

SHARED_END

#endif
