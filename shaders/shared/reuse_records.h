// What sample reuse keeps of a pixel from one frame to the next, as it lies in memory. Nothing of a
// surface model is stored: where light comes from is kept as a place on a triangle, so that an old
// sample can be looked at from a first hit that has moved, and what the surfaces there make of it
// is evaluated anew.
#ifndef REKINDLE_SHARED_REUSE_RECORDS_H
#define REKINDLE_SHARED_REUSE_RECORDS_H

#include "rgbe.h"
#include "scene.h"
#include "warp.h"

SHARED_BEGIN

// Which share alpha of the new integral old samples answer for (reuseShare in reuse_view.h).
SHARED_CONST uint kReuseDiscard = 0u;
SHARED_CONST uint kReuseNaive = 1u;  // no samples are kept but the mean of the pixel
SHARED_CONST uint kReuseReweighting = 2u;
SHARED_CONST uint kReuseMis = 3u;
SHARED_CONST uint kReuseRa = 4u;

SHARED_CONST uint kReuseJitters = 1u;  // first hits lie anywhere in the pixel, not at its centre
SHARED_CONST uint kReuseFollows = 2u;  // adds to a picture that has begun; else begins it

/// How samples are reused; the same for all pixels. Each pass takes one new path per pixel (n = 1).
struct ReuseSettings {
    uint strategy;
    uint candidates;   // k: directions among which each of them is resampled
    uint records;      // K: samples kept per pixel
    uint lights;       // the same of connections to emitters
    float cap;         // of the nominal number N of samples that the kept ones stand for
    float protection;  // eta: how much a sample's brightness counts when the store is cut down
    uint flags;        // kReuseJitters, kReuseFollows
    uint sizeBefore;   // of the picture that left the history: width in 16 bits, height above
};

/// The first hit of a pixel and how much history it has.
struct ReusePixel {
    uint slot;  // of the triangle; kNone: nothing is hit
    vec2 barycentrics;
    float nominal;  // N: does not depend on what was sampled
};

/// A sample of the light that comes to a first hit from one direction. `slot` and `place` say
/// where the ray ended: a triangle and barycentrics (packNumbers), or (kNone) a direction (packOct)
/// in which nothing is met. `u` is the absolute weight: per area on a triangle, per solid angle
/// without. `radiance` (packRgbe) leaves the place for the first hit. Where that depends on the
/// direction it is found anew (kReuseEvaluated) from emission, which is looked up, and from two
/// pieces of light that arrive at the place: from an emitter and from the path's continuation, each
/// as a direction (packOct) and radiance (packRgbe) over its density, MIS weights as they were.
struct ReuseSample {
    uint slot;
    uint place;
    float u;  // 0: there is no sample here
    uint radiance;
    uint lightDirection;
    uint lightRadiance;
    uint nextDirection;  // kFrozenRadiance: the radiance leaves for the first hit as it is
    uint nextRadiance;
};
SHARED_CONST uint kReuseSampleWords = 2u;

// packRgbe makes it of nothing below 1e38.
SHARED_CONST uint kReuseEvaluated = 0xffffffffu;

// packOct never makes it. A path that goes on by a delta lobe has no other direction to be
// evaluated in.
SHARED_CONST uint kFrozenRadiance = 0x80008000u;

/// A connection of a first hit to an emitter that was found open: the random numbers by which its
/// point is drawn again. `v` is its weight in the space of these numbers.
struct ReuseLight {
    uint emitter;
    uint numbers;  // 2 x 16 bits
    float v;       // 0: there is none here
};

SHARED_FN ReuseSample noReuseSample()
{
    ReuseSample r;
    r.slot = kNone;
    r.place = 0u;
    r.u = 0.0f;
    r.radiance = 0u;
    r.lightDirection = 0u;
    r.lightRadiance = 0u;
    r.nextDirection = 0u;
    r.nextRadiance = 0u;
    return r;
}

/// What a new path and a new connection have brought to a pixel, from one kernel to the next. The
/// sample's weight times its integrand is `scale` times `around`; that of the connection `light.v`
/// times `direct`.
struct ReuseNew {
    ReuseSample record;  // to be kept; of weight 0 where it cannot be
    ReuseLight light;
    float scale;  // what old samples leave to the new one
    vec3 around;  // what the path alone would estimate, where there was one candidate
    vec3 direct;
};
SHARED_CONST uint kReuseNewWords = 5u;

SHARED_FN ReuseNew noReuseNew()
{
    ReuseNew n;
    n.record = noReuseSample();
    n.light.emitter = 0u;
    n.light.numbers = 0u;
    n.light.v = 0.0f;
    n.scale = 0.0f;
    n.around = vec3(0.0f);
    n.direct = vec3(0.0f);
    return n;
}

/// What a pass has found at one pixel. Light that comes to the first hit is found in two ways:
/// `around`, in directions of the surface model, and `direct`, by connections to emitters.
struct ReuseSums {
    vec3 seen;           // towards the camera without any scattering
    vec3 around;         // by old samples and new
    vec3 aroundSquares;  // of what single paths would have brought, on average
    vec3 direct;
    vec3 directSquares;
    vec3 plain;       // by the new path and connection alone
    float weightSum;  // of v, of all samples of directions
    float nominal;    // N of the history; 0 without
};

SHARED_FN ReuseSums noReuseSums()
{
    ReuseSums s;
    s.seen = vec3(0.0f);
    s.around = vec3(0.0f);
    s.aroundSquares = vec3(0.0f);
    s.direct = vec3(0.0f);
    s.directSquares = vec3(0.0f);
    s.plain = vec3(0.0f);
    s.weightSum = 0.0f;
    s.nominal = 0.0f;
    return s;
}

/// Adds what is new to what old samples of nominal number `s.nominal` have brought.
SHARED_FN void addReuseNew(INOUT(ReuseSums) s, ReuseNew n)
{
    const float share = 1.0f / (s.nominal + 1.0f);
    s.around += n.scale * n.around;
    s.aroundSquares += share * n.around * n.around;
    s.direct += n.light.v * n.direct;
    s.directSquares += n.light.v * n.direct * n.direct;
    s.plain = n.around + n.direct;
    s.weightSum += n.scale;
}

/// Radiance by old samples and new.
SHARED_FN vec3 reusedRadiance(IN(ReuseSums) s)
{
    return s.seen + s.around + s.direct;
}

/// Radiance by the new path alone.
SHARED_FN vec3 plainRadiance(IN(ReuseSums) s)
{
    return s.seen + s.plain;
}

/// Mean square of the radiance that single paths find, for the variance that is told.
SHARED_FN vec3 reusedSquares(IN(ReuseSums) s)
{
    const vec3 mean = reusedRadiance(s);
    return mean * mean + max(s.aroundSquares - s.around * s.around, vec3(0.0f)) +
           max(s.directSquares - s.direct * s.direct, vec3(0.0f));
}

/// How much a sample matters when the store is cut down: its weight v, and what it brings (u F)
/// beside what the pixel has on average. Any score keeps the rest unbiased.
SHARED_FN float reuseScore(ReuseSettings settings, float v, float brings, vec3 mean)
{
    return v + settings.protection * brings / max(luminance(mean), 1.0e-30f);
}

SHARED_FN uvec4 packReusePixel(ReusePixel p)
{
    return uvec4(p.slot, floatAsUint(p.barycentrics.x), floatAsUint(p.barycentrics.y),
                 floatAsUint(p.nominal));
}

SHARED_FN ReusePixel unpackReusePixel(uvec4 w)
{
    ReusePixel p;
    p.slot = w.x;
    p.barycentrics = vec2(uintAsFloat(w.y), uintAsFloat(w.z));
    p.nominal = uintAsFloat(w.w);
    return p;
}

/// The words of a sample: the first is enough where radiance is not evaluated.
SHARED_FN uvec4 packReusePlace(ReuseSample r)
{
    return uvec4(r.slot, r.place, floatAsUint(r.u), r.radiance);
}

SHARED_FN uvec4 packReuseArriving(ReuseSample r)
{
    return uvec4(r.lightDirection, r.lightRadiance, r.nextDirection, r.nextRadiance);
}

SHARED_FN ReuseSample unpackReuseSample(uvec4 place, uvec4 arriving)
{
    ReuseSample r;
    r.slot = place.x;
    r.place = place.y;
    r.u = uintAsFloat(place.z);
    r.radiance = place.w;
    r.lightDirection = arriving.x;
    r.lightRadiance = arriving.y;
    r.nextDirection = arriving.z;
    r.nextRadiance = arriving.w;
    return r;
}

SHARED_FN uvec4 packLightRecord(ReuseLight r)
{
    return uvec4(r.emitter, r.numbers, floatAsUint(r.v), 0u);
}

SHARED_FN ReuseLight unpackLightRecord(uvec4 w)
{
    ReuseLight r;
    r.emitter = w.x;
    r.numbers = w.y;
    r.v = uintAsFloat(w.z);
    return r;
}

/// Two numbers of [0,1) as 16 bits each, and back: what is drawn is drawn on this grid, so that an
/// emitter's point can be found again.
SHARED_FN uint packNumbers(vec2 u)
{
    return min(uint(u.x * 65536.0f), 65535u) | (min(uint(u.y * 65536.0f), 65535u) << 16u);
}

SHARED_FN vec2 unpackNumbers(uint word)
{
    return vec2((float(word & 0xffffu) + 0.5f) * (1.0f / 65536.0f),
                (float(word >> 16u) + 0.5f) * (1.0f / 65536.0f));
}

#ifdef __cplusplus
static_assert(sizeof(ReuseSample) == 16 * kReuseSampleWords && sizeof(ReusePixel) == 16);
static_assert(sizeof(ReuseSettings) == 32);
#endif

SHARED_END

#endif
