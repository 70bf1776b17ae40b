// Frames, area-preserving maps from the unit square with densities and inverses, octahedral
// packing. All round maps go through the concentric disk (Shirley & Chiu 1997) and an equal-area
// lift (Lambert's azimuthal map), which keeps strata compact and needs two short polynomials
// instead of sine and cosine.
#ifndef REKINDLE_SHARED_WARP_H
#define REKINDLE_SHARED_WARP_H

#include "lang.h"

SHARED_BEGIN

/// Orthonormal frame with third column n (unit): Duff et al., "Building an Orthonormal Basis,
/// Revisited", 2017.
SHARED_FN mat3 makeFrame(vec3 n)
{
    float s = n.z >= 0.0f ? 1.0f : -1.0f;
    float a = -1.0f / (s + n.z);
    float b = n.x * n.y * a;
    return mat3(vec3(1.0f + s * n.x * n.x * a, s * b, -s * n.x), vec3(b, s + n.y * n.y * a, -n.y),
                n);
}

SHARED_FN vec3 toLocal(mat3 frame, vec3 v)
{
    return vec3(dot(frame[0], v), dot(frame[1], v), dot(frame[2], v));
}

SHARED_FN vec3 toWorld(mat3 frame, vec3 v)
{
    return frame[0] * v.x + frame[1] * v.y + frame[2] * v.z;
}

// --- disk --------------------------------------------------------------------------------------

/// cos and sin of t * pi/4 for t in [-1,1]; errors below 1e-7.
SHARED_FN vec2 octantCosSin(float t)
{
    float x = t * t;
    float c = 1.0f +
              x * (-0.3084251369f + x * (0.01585434395f + x * (-0.000325991887f + x * 3.5663e-6f)));
    float s =
        t * (0.7853981634f + x * (-0.08074551219f +
                                  x * (0.002490394570f + x * (-3.657620418e-5f + x * 3.1336e-7f))));
    return vec2(c, s);
}

/// Uniform on the unit disk, concentric. The density is 1/pi.
SHARED_FN vec2 sampleDisk(vec2 u)
{
    float a = 2.0f * u.x - 1.0f;
    float b = 2.0f * u.y - 1.0f;
    bool wide = abs(a) > abs(b);
    float r = wide ? a : b;
    float t = wide ? b : a;
    vec2 cs = r * octantCosSin(t / (r == 0.0f ? 1.0f : r));
    return wide ? cs : vec2(cs.y, cs.x);
}

SHARED_FN float pdfDisk()
{
    return kInvPi;
}

/// The u that sampleDisk maps to p.
SHARED_FN vec2 inverseDisk(vec2 p)
{
    bool wide = abs(p.x) > abs(p.y);
    float major = wide ? p.x : p.y;
    float minor = wide ? p.y : p.x;
    float r = length(p) * (major < 0.0f ? -1.0f : 1.0f);
    float t = major == 0.0f ? 0.0f : atan(minor / major) * (4.0f * kInvPi);
    vec2 ab = wide ? vec2(r, r * t) : vec2(r * t, r);
    return 0.5f * ab + vec2(0.5f);
}

// --- directions about +z -----------------------------------------------------------------------

/// The hemisphere with density cos/pi, from a point of the unit disk (Malley).
SHARED_FN vec3 cosineHemisphereFromDisk(vec2 p)
{
    return vec3(p.x, p.y, sqrt(max(0.0f, 1.0f - dot(p, p))));
}

SHARED_FN vec3 sampleCosineHemisphere(vec2 u)
{
    return cosineHemisphereFromDisk(sampleDisk(u));
}

SHARED_FN float pdfCosineHemisphere(vec3 w)
{
    return max(w.z, 0.0f) * kInvPi;
}

SHARED_FN vec2 inverseCosineHemisphere(vec3 w)
{
    return inverseDisk(vec2(w.x, w.y));
}

/// Uniform in the cone of directions whose cosine with +z is at least 1 - oneMinusCos (which may
/// reach 2, the sphere). The argument is not the cosine, so that narrow cones keep their precision.
SHARED_FN vec3 sampleCone(vec2 u, float oneMinusCos)
{
    vec2 p = sampleDisk(u);
    float height = dot(p, p) * oneMinusCos;
    float stretch = sqrt(max(0.0f, oneMinusCos * (2.0f - height)));
    return vec3(p.x * stretch, p.y * stretch, 1.0f - height);
}

/// Density inside the cone.
SHARED_FN float pdfCone(float oneMinusCos)
{
    return 0.5f * kInvPi / oneMinusCos;
}

SHARED_FN vec2 inverseCone(vec3 w, float oneMinusCos)
{
    // 1 - cos without cancellation near the axis: |w - z|^2 / 2.
    float height = 0.5f * (w.x * w.x + w.y * w.y + (1.0f - w.z) * (1.0f - w.z));
    float r = sqrt(min(height / oneMinusCos, 1.0f));
    float across = length(vec2(w.x, w.y));
    return inverseDisk(across > 0.0f ? vec2(w.x, w.y) * (r / across) : vec2(r, 0.0f));
}

SHARED_FN vec3 sampleUniformHemisphere(vec2 u)
{
    return sampleCone(u, 1.0f);
}

SHARED_FN float pdfUniformHemisphere()
{
    return 0.5f * kInvPi;
}

SHARED_FN vec2 inverseUniformHemisphere(vec3 w)
{
    return inverseCone(w, 1.0f);
}

SHARED_FN vec3 sampleSphere(vec2 u)
{
    return sampleCone(u, 2.0f);
}

SHARED_FN float pdfSphere()
{
    return 0.25f * kInvPi;
}

SHARED_FN vec2 inverseSphere(vec3 w)
{
    return inverseCone(w, 2.0f);
}

// --- triangle ----------------------------------------------------------------------------------

/// Uniform barycentric coordinates (of the second and third vertex): Heitz, "A Low-Distortion Map
/// Between Triangle and Square", 2019. The density over the triangle is 1/area.
SHARED_FN vec2 sampleTriangle(vec2 u)
{
    float shift = 0.5f * min(u.x, u.y);
    return u.y > u.x ? vec2(shift, u.y - shift) : vec2(u.x - shift, shift);
}

SHARED_FN float pdfTriangle(float area)
{
    return 1.0f / area;
}

SHARED_FN vec2 inverseTriangle(vec2 barycentrics)
{
    float shift = min(barycentrics.x, barycentrics.y);
    return barycentrics + vec2(shift);
}

// --- octahedral packing ------------------------------------------------------------------------

/// The unit sphere onto [-1,1]^2 (Meyer et al. 2010; Cigolle et al. 2014).
SHARED_FN vec2 octEncode(vec3 d)
{
    float scale = 1.0f / (abs(d.x) + abs(d.y) + abs(d.z));
    vec2 p = vec2(d.x, d.y) * scale;
    vec2 fold = vec2((1.0f - abs(p.y)) * (p.x >= 0.0f ? 1.0f : -1.0f),
                     (1.0f - abs(p.x)) * (p.y >= 0.0f ? 1.0f : -1.0f));
    return d.z < 0.0f ? fold : p;
}

SHARED_FN vec3 octDecode(vec2 p)
{
    float z = 1.0f - abs(p.x) - abs(p.y);
    float t = max(-z, 0.0f);
    return normalize(vec3(p.x + (p.x >= 0.0f ? -t : t), p.y + (p.y >= 0.0f ? -t : t), z));
}

/// A unit vector as 2 x snorm16, x in the low half: angle errors stay below 7e-5.
SHARED_FN uint packOct(vec3 d)
{
    vec2 p = octEncode(d) * 32767.0f;
    int x = int(floor(p.x + 0.5f));
    int y = int(floor(p.y + 0.5f));
    return (uint(x) & 0xffffu) | (uint(y) << 16u);
}

SHARED_FN vec3 unpackOct(uint word)
{
    float x = float(int(word << 16u) >> 16) * (1.0f / 32767.0f);
    float y = float(int(word) >> 16) * (1.0f / 32767.0f);
    return octDecode(vec2(x, y));
}

/// A unit tangent as snorm15 in bits 1..15, snorm16 in bits 16..31; bit 0 is set for handedness -1.
SHARED_FN uint packTangent(vec3 t, float handedness)
{
    vec2 p = octEncode(t);
    int x = int(floor(p.x * 16383.0f + 0.5f));
    int y = int(floor(p.y * 32767.0f + 0.5f));
    return (handedness < 0.0f ? 1u : 0u) | ((uint(x) & 0x7fffu) << 1u) | (uint(y) << 16u);
}

/// Tangent in x, y, z; handedness (1 or -1) in w.
SHARED_FN vec4 unpackTangent(uint word)
{
    float x = float(int(word << 16u) >> 17) * (1.0f / 16383.0f);
    float y = float(int(word) >> 16) * (1.0f / 32767.0f);
    return vec4(octDecode(vec2(x, y)), (word & 1u) != 0u ? -1.0f : 1.0f);
}

SHARED_END

#endif
