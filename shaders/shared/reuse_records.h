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
SHARED_CONST uint kReuseRejection = 5u;  // Rejection-Augmentation: drops what RA would dim
SHARED_CONST uint kReuseRestir = 6u;     // the balance heuristic, of which one sample survives
SHARED_CONST uint kReuseSvgf = 7u;       // as naive, of four pixels, and forgets sooner
SHARED_CONST uint kReuseFull = 8u;       // as many fresh paths as old samples would stand for

SHARED_CONST uint kReuseJitters = 1u;    // first hits lie anywhere in the pixel, not at its centre
SHARED_CONST uint kReuseFollows = 2u;    // adds to a picture that has begun; else begins it
SHARED_CONST uint kReuseAllocates = 4u;  // noisy pixels get more of the paths (reuse_allocation.h)
SHARED_CONST uint kReuseMoves = 8u;      // later frames may be of other poses
SHARED_CONST uint kReuseCarries = 16u;   // pixels hand on remainders (reuse_sums.h)
SHARED_CONST uint kReuseDirects = 32u;   // samples keep their direction (keepsDirections)
// Behind these flags: how many pieces of the scene have moved since the frame before (motion.h).
SHARED_CONST uint kReuseMovedShift = 8u;

/// Whether what is kept of a pixel is the mean of what was seen there, and no samples.
SHARED_FN bool keepsMeans(uint strategy)
{
    return FEATURE(kFeatureKeepsMeans) && (strategy == kReuseNaive || strategy == kReuseSvgf);
}

/// Whether samples are kept.
SHARED_FN bool keepsSamples(uint strategy)
{
    return FEATURE(kFeatureKeepsSamples) && !keepsMeans(strategy) && strategy != kReuseDiscard &&
           strategy != kReuseFull;
}

/// How samples are reused; the same for all pixels.
struct ReuseSettings {
    uint strategy;
    uint counts;       // recordsOf, lightsOf, candidatesOf, pathsOfChunk: 8 bits each
    float rays;        // n: new paths per pixel and pass
    float cap;         // of the nominal number N of samples that the kept ones stand for
    float protection;  // eta: how much a sample's brightness counts when the store is cut down
    uint flags;        // kReuseJitters and others, kReuseMovedShift
    uint
        sizeBefore;  // of the picture that left the history: width - 1 in 16 bits, height - 1 above
    float visibility;  // share of samples whose visibility is asked for again; 1: unbiased
};

/// Whether no approximation is allowed.
SHARED_FN bool isUnbiased(ReuseSettings settings)
{
    return settings.visibility >= 1.0f;
}

/// Whether it is kept over which ways light arrives at the place of a sample, on every surface.
SHARED_FN bool keepsArrivals(ReuseSettings settings)
{
    return FEATURE(kFeatureMoves) && (settings.flags & kReuseMoves) != 0u;
}

/// Whether a pixel hands on what cutting its store down took away, or added.
SHARED_FN bool carriesRemainder(ReuseSettings settings)
{
    return (settings.flags & kReuseCarries) != 0u;
}

/// Whether samples have no place but a direction and what comes from there, unless they end at what
/// shines: the first hit moves by what is left of rounding to pixels, so that from the same
/// direction comes the same. Where nothing moves and it is not asked what lies in between.
SHARED_FN bool keepsDirections(ReuseSettings settings)
{
    return !FEATURE(kFeatureKeepsPlaces) || (settings.flags & kReuseDirects) != 0u;
}

/// Pieces of the scene that have moved since the frame before.
SHARED_FN uint movedPieces(ReuseSettings settings)
{
    return FEATURE(kFeatureMoves) ? settings.flags >> kReuseMovedShift : 0u;
}

SHARED_FN uint packCounts(uint records, uint lights, uint candidates)
{
    return records | (lights << 8u) | (candidates << 16u);
}

/// K: samples kept per pixel.
SHARED_FN uint recordsOf(ReuseSettings settings)
{
    return settings.counts & 0xffu;
}

/// The same of connections to emitters.
SHARED_FN uint lightsOf(ReuseSettings settings)
{
    return (settings.counts >> 8u) & 0xffu;
}

/// k: directions among which a new one is resampled.
SHARED_FN uint candidatesOf(ReuseSettings settings)
{
    return (settings.counts >> 16u) & 0xffu;
}

/// Paths that a lane of a device takes one after the other, of `full`; see packChunk.
SHARED_FN uint pathsOfChunk(ReuseSettings settings)
{
    return max(settings.counts >> 24u, 1u);
}

/// `counts` with that number, below 256.
SHARED_FN uint packChunk(uint counts, uint paths)
{
    return (counts & 0xffffffu) | (paths << 24u);
}

// Below so many samples in its history a pixel gets a path in every pass, however few are asked
// for: each is a large part of the picture.
SHARED_CONST float kReuseYoung = 8.0f;
SHARED_CONST uint kReuseMostRays = 32u;      // of a pixel in one pass
SHARED_CONST uint kReuseMostFresh = 16384u;  // the same of `full`

/// How much history a pixel has. Nothing of it depends on what was sampled.
struct ReuseHistory {
    float nominal;  // N
    float credit;   // of [0,1): what is left of paths that were due to the pixel
    float width;    // GGX width of the narrowest lobe at the first hit; 1 without
};

/// The first hit of a pixel and its history. (While a pass runs on the device, the history's word
/// holds where it is to be found.)
struct ReusePixel {
    uint slot;  // of the triangle; kNone: nothing is hit
    vec2 barycentrics;
    uint history;  // packHistory
};

SHARED_FN uint packCredit(float credit)
{
    return min(uint(credit * 1024.0f), 1023u);
}

SHARED_FN float unpackCredit(uint bits)
{
    return float(bits & 0x3ffu) * (1.0f / 1024.0f);
}

/// The width as its root, so that narrow lobes do not become none.
SHARED_FN uint packHistory(ReuseHistory h)
{
    return uint(h.nominal * 16.0f + 0.5f) | (packCredit(h.credit) << 14u) |
           (uint(sqrt(min(h.width, 1.0f)) * 255.0f + 0.5f) << 24u);
}

SHARED_FN ReuseHistory unpackHistory(uint word)
{
    ReuseHistory h;
    h.nominal = float(word & 0x3fffu) * (1.0f / 16.0f);
    h.credit = unpackCredit(word >> 14u);
    const float root = float(word >> 24u) * (1.0f / 255.0f);
    h.width = root * root;
    return h;
}

SHARED_FN ReuseHistory noHistory()
{
    ReuseHistory h;
    h.nominal = 0.0f;
    h.credit = 0.0f;
    h.width = 1.0f;
    return h;
}

/// Whether pixels look for what the frame before has left of them.
SHARED_FN bool looksBack(ReuseSettings settings)
{
    return settings.strategy != kReuseDiscard || (settings.flags & kReuseAllocates) != 0u;
}

/// Whether the pass takes all that a history stands for anew.
SHARED_FN bool takesAllAnew(ReuseSettings settings)
{
    return settings.strategy == kReuseFull && (settings.flags & kReuseFollows) == 0u;
}

/// What a pixel's history becomes by a pass that was due `rays` paths.
SHARED_FN ReuseHistory grownHistory(ReuseSettings settings, ReuseHistory h, float rays, float width)
{
    h.nominal = min(takesAllAnew(settings) ? rays : h.nominal + rays, settings.cap);
    h.width = width;
    return h;
}

// How much of its lobe a first hit may lose by turning (total variation) before it gets a path in
// every pass, and before its directions are resampled: what old samples no longer answer for is
// left to new ones, and must not wait for them.
SHARED_CONST float kReuseTurnsALittle = 0.02f;
SHARED_CONST float kReuseTurnsALot = 0.1f;

/// The total variation between a microfacet lobe and that of the frame before, roughly: a quarter
/// of angle / alpha, its `width`. `turned` is the length between its unit directions, then and now.
SHARED_FN float lobeTurn(float width, float turned)
{
    return 0.25f * turned / max(width, 1.0e-6f);
}

/// Paths that are due to a pixel in this pass, on average: n, and of `full` N + n.
SHARED_FN float raysDue(ReuseSettings settings, ReuseHistory h, float turned)
{
    if ((settings.flags & kReuseFollows) != 0u) return 1.0f;
    const bool few = settings.rays < 1.0f && h.nominal >= kReuseYoung &&
                     lobeTurn(h.width, turned) < kReuseTurnsALittle;
    const float rays = few ? settings.rays : max(settings.rays, 1.0f);
    return takesAllAnew(settings) ? h.nominal + rays : rays;
}

/// c: the share that a history answers for where new paths count as `rays`.
SHARED_FN float shareOfHistory(ReuseSettings settings, ReuseHistory h, float rays)
{
    const bool reuses = keepsSamples(settings.strategy) || keepsMeans(settings.strategy);
    return reuses ? h.nominal / (h.nominal + rays) : 0.0f;
}

/// How many of `due` paths a pixel takes now. The rest is kept as credit: how often a history is
/// renewed is then as even as can be, which leaves no noise of its own in the picture.
SHARED_FN uint takeRays(ReuseSettings settings, float due, INOUT(ReuseHistory) h)
{
    const uint most = settings.strategy == kReuseFull ? kReuseMostFresh : kReuseMostRays;
    const uint taken = min(uint(h.credit + due), most);
    h.credit = clamp(h.credit + due - float(taken), 0.0f, 1.0f);
    return taken;
}

/// A sample of the light that comes to a first hit from one direction. `slot` and `place` say
/// where the ray ended: a triangle and barycentrics (packNumbers), or (kNone) a direction (packOct)
/// in which nothing is met. `u` is the absolute weight: per area on a triangle, per solid angle
/// without. `radiance` (packRgbe) leaves the place for the first hit. Where that depends on the
/// direction it is found anew (kReuseEvaluated) from emission, which is looked up, and from two
/// pieces of light that arrive at the place: from an emitter and from the path's continuation, each
/// as a direction (packOct) and radiance (packRgbe) over its density, MIS weights as they were.
/// Where samples keep their direction, those with a place shine: `radiance` is what the place
/// reflects, and emission comes to that.
struct ReuseSample {
    uint slot;
    uint place;
    float u;  // 0: there is no sample here
    uint radiance;
    uint lightDirection;
    uint lightRadiance;
    uint nextDirection;
    uint nextRadiance;
};
SHARED_CONST uint kReuseSampleWords = 2u;

// packRgbe makes it of nothing below 1e38.
SHARED_CONST uint kReuseEvaluated = 0xffffffffu;

// In the place of a direction (packOct makes no such word): what the place reflects, it mirrors or
// lets through, and shows something else from elsewhere. Packed as a bit of the slot.
SHARED_CONST uint kReuseBent = 0x80008000u;
SHARED_CONST uint kReuseBentSlot = 0x80000000u;

/// A connection of a first hit to an emitter that was found open: the random numbers by which its
/// point is drawn again. `v` is its weight in the space of these numbers.
struct ReuseLight {
    uint emitter;
    uint numbers;  // 2 x 16 bits
    float v;       // 0: there is none here
    uint through;  // packThrough
};

/// What panes on the way of a connection have let through, and back; 0: all. Not traced again, an
/// old connection is taken for as dim as it was.
SHARED_FN uint packThrough(vec3 through, vec3 xi)
{
    if (!FEATURE(kFeaturePanes) || through == vec3(1.0f)) return 0u;
    return max(packRgbe(through, xi), 1u);
}

SHARED_FN vec3 unpackThrough(uint word)
{
    return FEATURE(kFeaturePanes) && word != 0u ? unpackRgbe(word) : vec3(1.0f);
}

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

/// How much a sample matters when the store is cut down: its weight v, and what it brings (u F)
/// beside what the pixel has on average. Any score keeps the rest unbiased. A reservoir goes by
/// what samples bring alone.
SHARED_FN float reuseScore(ReuseSettings settings, float v, float brings, vec3 mean)
{
    if (settings.strategy == kReuseRestir) return brings;
    return v + settings.protection * brings / max(luminance(mean), 1.0e-30f);
}

SHARED_FN uvec4 packReusePixel(ReusePixel p)
{
    return uvec4(p.slot, floatAsUint(p.barycentrics.x), floatAsUint(p.barycentrics.y), p.history);
}

SHARED_FN ReusePixel unpackReusePixel(uvec4 w)
{
    ReusePixel p;
    p.slot = w.x;
    p.barycentrics = vec2(uintAsFloat(w.y), uintAsFloat(w.z));
    p.history = w.w;
    return p;
}

/// Whether light that comes from the place of a sample is to be evaluated.
SHARED_FN bool isEvaluated(ReuseSettings settings, ReuseSample r)
{
    return r.radiance == kReuseEvaluated || (keepsDirections(settings) && r.slot != kNone);
}

/// Whether samples have a second word (packReuseArriving).
SHARED_FN bool hasArrivingWords(ReuseSettings settings)
{
    return keepsSamples(settings.strategy) && !keepsDirections(settings);
}

/// The words of a sample: the first is enough where radiance is not evaluated, and where samples
/// keep their direction.
SHARED_FN uvec4 packReusePlace(ReuseSample r)
{
    const uint bent = r.nextDirection == kReuseBent ? kReuseBentSlot : 0u;
    return uvec4(r.slot | bent, r.place, floatAsUint(r.u), r.radiance);
}

SHARED_FN uvec4 packReuseArriving(ReuseSample r)
{
    return uvec4(r.lightDirection, r.lightRadiance, r.nextDirection, r.nextRadiance);
}

SHARED_FN ReuseSample unpackReuseSample(ReuseSettings settings, uvec4 place, uvec4 arriving)
{
    const bool bent =
        keepsDirections(settings) && place.x != kNone && (place.x & kReuseBentSlot) != 0u;
    ReuseSample r;
    r.slot = bent ? place.x & ~kReuseBentSlot : place.x;
    r.place = place.y;
    r.u = uintAsFloat(place.z);
    r.radiance = place.w;
    r.lightDirection = arriving.x;
    r.lightRadiance = arriving.y;
    r.nextDirection = bent ? kReuseBent : arriving.z;
    r.nextRadiance = arriving.w;
    return r;
}

SHARED_FN uvec4 packLightRecord(ReuseLight r)
{
    return uvec4(r.emitter, r.numbers, floatAsUint(r.v), r.through);
}

SHARED_FN ReuseLight unpackLightRecord(uvec4 w)
{
    ReuseLight r;
    r.emitter = w.x;
    r.numbers = w.y;
    r.v = uintAsFloat(w.z);
    r.through = FEATURE(kFeaturePanes) ? w.w : 0u;
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

// Barycentrics of places: from -1 to 2, since they may slide somewhat beyond their triangle.
SHARED_CONST float kPlaceLow = -1.0f;
SHARED_CONST float kPlaceRange = 3.0f;

/// The barycentrics of a place, and back.
SHARED_FN uint packPlace(vec2 barycentrics)
{
    return packNumbers((barycentrics - kPlaceLow) * (1.0f / kPlaceRange));
}

SHARED_FN vec2 unpackPlace(uint word)
{
    return kPlaceLow + kPlaceRange * unpackNumbers(word);
}

#ifdef __cplusplus
static_assert(sizeof(ReuseSample) == 16 * kReuseSampleWords && sizeof(ReusePixel) == 16);
static_assert(sizeof(ReuseSettings) == 32);
#endif

SHARED_END

#endif
