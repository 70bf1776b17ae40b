// What a pass of sample reuse adds up at a pixel: old samples and new ones, and what is told of
// them.
#ifndef REKINDLE_SHARED_REUSE_SUMS_H
#define REKINDLE_SHARED_REUSE_SUMS_H

#include "reuse_records.h"

SHARED_BEGIN

/// What a new path and a new connection have brought to a pixel, from one kernel to the next. The
/// sample's weight times its integrand is `scale` times `around`; that of the connection `light.v`
/// times `direct`. A pixel may have several in one pass.
struct ReuseNew {
    ReuseSample record;  // to be kept; of weight 0 where it cannot be
    ReuseLight light;
    float scale;  // what old samples leave to the new one
    vec3 around;  // what the path alone would estimate, where there was one candidate
    vec3 direct;
    float lost;  // luminance that would have been left to old samples which cannot bring it
};
SHARED_CONST uint kReuseNewWords = 5u;  // and of packPathSums

// Old samples that the first picture of a view counts as when the camera rests (weightAtRest).
SHARED_CONST float kReuseMostAtRest = 12.0f;

// Of a pixel of which no deviation is known.
SHARED_CONST float kNoDeviation = -1.0f;

SHARED_FN ReuseNew noReuseNew()
{
    ReuseNew n;
    n.record = noReuseSample();
    n.light.emitter = 0u;
    n.light.numbers = 0u;
    n.light.v = 0.0f;
    n.light.through = 0u;
    n.scale = 0.0f;
    n.around = vec3(0.0f);
    n.direct = vec3(0.0f);
    n.lost = 0.0f;
    return n;
}

/// What a pass has found at one pixel. Light that comes to the first hit is found in two ways:
/// `around`, in directions of the surface model, and `direct`, by connections to emitters.
struct ReuseSums {
    vec3 seen;           // towards the camera without any scattering
    vec3 rest;           // by ways that mirrors and glass have not taken (reuse_chain.h)
    vec3 beta;           // of the way from the camera: all but these two goes through it
    vec3 around;         // by old samples and new
    vec3 aroundSquares;  // of what single paths would have brought, on average
    vec3 direct;
    vec3 directSquares;
    vec3 carried;         // given back of the frame before's remainder; 0 on average
    vec3 remainder;       // what cutting the store down has taken away
    vec3 plain;           // by the new path and connection alone
    float plainSquares;   // of the luminance of single ones, towards the camera
    float weightSum;      // of v, of all samples of directions
    float weightSquares;  // and of its squares
    float oldShare;       // of weightSum by old samples
    float nominal;        // N of what is reused; 0 without
    float rays;           // n: new paths that are due
    uint taken;           // and those that there are
    float part;           // of a path that is due, which each of these counts as
    float noise;          // deviation that paths were allocated by; kNoDeviation: none
    float leaked;         // luminance of old samples that were found to be hidden
    float lost;           // and of new ones that were found to have been
};

SHARED_FN ReuseSums noReuseSums()
{
    ReuseSums s;
    s.seen = vec3(0.0f);
    s.rest = vec3(0.0f);
    s.beta = vec3(1.0f);
    s.around = vec3(0.0f);
    s.aroundSquares = vec3(0.0f);
    s.direct = vec3(0.0f);
    s.directSquares = vec3(0.0f);
    s.carried = vec3(0.0f);
    s.remainder = vec3(0.0f);
    s.plain = vec3(0.0f);
    s.plainSquares = 0.0f;
    s.weightSum = 0.0f;
    s.weightSquares = 0.0f;
    s.oldShare = 0.0f;
    s.nominal = 0.0f;
    s.rays = 1.0f;
    s.taken = 0u;
    s.part = 1.0f;
    s.noise = kNoDeviation;
    s.leaked = 0.0f;
    s.lost = 0.0f;
    return s;
}

/// What each of a pixel's new paths counts as, where `rays` were due. How many it takes must not
/// change c = N / (N + n), which is as if it took what is due: where bright old samples lead to
/// more new paths, and these to a smaller c, the picture is too dark. Below one path that is due
/// there is none in some passes, and whole ones in others pay for them.
SHARED_FN float partOfPath(float rays, uint taken)
{
    return rays >= 1.0f && taken > 0u ? rays / float(taken) : 1.0f;
}

/// Lets a new sample count as `part` of a path that is due.
SHARED_FN void countAsPart(float part, INOUT(ReuseNew) n)
{
    n.scale *= part;
    n.record.u *= part;
    n.light.v *= part;
    n.lost *= part;
}

/// Adds what is new, and counts as s.part, to what old samples of nominal number `s.nominal` have
/// brought.
SHARED_FN void addReuseNew(INOUT(ReuseSums) s, ReuseNew n)
{
    const float share = s.part / (s.nominal + s.rays);
    s.around += n.scale * n.around;
    s.aroundSquares += share * n.around * n.around;
    s.direct += n.light.v * n.direct;
    s.directSquares += n.light.v * n.direct * n.direct;
    s.plain += n.around + n.direct;
    const float L = luminance(s.beta * (n.around + n.direct));
    s.plainSquares += L * L;
    ++s.taken;
    s.lost += n.lost;
    s.weightSum += n.scale;
    s.weightSquares += n.scale * n.scale;
}

/// Radiance by old samples and new.
SHARED_FN vec3 reusedRadiance(IN(ReuseSums) s)
{
    return s.seen + s.rest + s.beta * (s.around + s.direct + s.carried);
}

/// Whether all of it can be added to something. Each component: a maximum may pass over a NaN.
SHARED_FN bool isNumber(vec3 v)
{
    return abs(v.x) < kInfinity && abs(v.y) < kInfinity && abs(v.z) < kInfinity;
}

/// What a pixel hands on beside its store: what all samples brought that competed for a place
/// there, less what the kept ones bring (s.remainder), and what it was handed itself. Its mean is
/// zero whatever the samples bring, since resampling keeps all sums on average; so the next frame
/// may add any share of it that does not depend on what was sampled (giveBack in reuse_view.h).
/// Where old samples bring nearly what they brought before, the noise of cutting down goes with it:
/// the store is a control variate of its own past, and the pixel has the noise of all samples that
/// it stands for, not of those few that it keeps.
SHARED_FN vec3 remainderNow(IN(ReuseSums) s)
{
    const vec3 sum = s.carried + s.remainder;
    return isNumber(sum) ? sum : vec3(0.0f);
}

/// Radiance by the new paths alone, where there are any.
SHARED_FN vec3 plainRadiance(IN(ReuseSums) s)
{
    return s.seen + s.rest + s.beta * s.plain / float(max(s.taken, 1u));
}

/// The mean that `naive` goes on with: `before` is that of the history.
SHARED_FN vec3 naiveMean(IN(ReuseSums) s, vec3 before)
{
    if (!(s.nominal > 0.0f)) return plainRadiance(s);
    const float share = float(s.taken) / (s.nominal + s.rays);
    return before + min(share, 1.0f) * (plainRadiance(s) - before);
}

/// What the next view goes on with: a sample that is no number is dropped from the picture, and
/// must not be in the mean of all that follow, nor in those of the pixels around.
SHARED_FN vec3 keptMean(vec3 mean, vec3 before)
{
    return isNumber(mean) ? mean : before;
}

/// How many samples the first picture of a view counts as among those that follow when the camera
/// rests. Its pixels are as good as N + n samples each; but their errors are alike where
/// neighbours have inherited the same old samples, to the eye blotches, and of each only the middle
/// was seen, whatever else lies in it. `magnified`: pixels of the picture for each of that before;
/// a block of so many has the old samples of one, so for the block they count as N / magnified.
/// This is between the two. Never more than kReuseMostAtRest: with all of N a box at rest
/// errs more from the fourth sample on.
SHARED_FN float weightAtRest(IN(ReuseSums) s, float magnified)
{
    return s.rays + min(s.nominal * inversesqrt(max(magnified, 1.0f)), kReuseMostAtRest);
}

/// Mean square of the radiance, so that the variance that is told of a picture that counts as
/// `weight` samples is that of N + n.
SHARED_FN vec3 reusedSquares(IN(ReuseSums) s, float weight)
{
    const vec3 mean = reusedRadiance(s);
    const vec3 around = max(s.aroundSquares - s.around * s.around, vec3(0.0f));
    const vec3 direct = max(s.directSquares - s.direct * s.direct, vec3(0.0f));
    const float part = s.part * weight / (s.nominal + s.rays);
    return mean * mean + s.beta * s.beta * (part * (around + direct));
}

/// A vector and a word as one kernel leaves them to the next.
SHARED_FN uvec4 packVector(vec3 v, uint word)
{
    return uvec4(floatAsUint(v.x), floatAsUint(v.y), floatAsUint(v.z), word);
}

SHARED_FN vec3 unpackVector(uvec4 w)
{
    return vec3(uintAsFloat(w.x), uintAsFloat(w.y), uintAsFloat(w.z));
}

/// Word `i` of sums over new paths alone, as one kernel leaves them to the next.
SHARED_FN uvec4 packPathSums(IN(ReuseSums) s, uint i)
{
    vec3 v = s.around;
    float rest = s.weightSum;
    if (i == 1u) {
        v = s.aroundSquares;
        rest = s.weightSquares;
    } else if (i == 2u) {
        v = s.direct;
        rest = s.plainSquares;
    } else if (i == 3u) {
        v = s.directSquares;
    } else if (i == 4u) {
        v = s.plain;
    }
    return packVector(v, floatAsUint(rest));
}

/// Adds these; how many paths they are of is not among them.
SHARED_FN void addPathSums(INOUT(ReuseSums) s, uvec4 word0, uvec4 word1, uvec4 word2, uvec4 word3,
                           uvec4 word4)
{
    s.around += unpackVector(word0);
    s.weightSum += uintAsFloat(word0.w);
    s.aroundSquares += unpackVector(word1);
    s.weightSquares += uintAsFloat(word1.w);
    s.direct += unpackVector(word2);
    s.plainSquares += uintAsFloat(word2.w);
    s.directSquares += unpackVector(word3);
    s.plain += unpackVector(word4);
}

/// The standard deviation of the luminance that single paths of a pixel find, from these and what
/// was known before of a history of `nominal` samples.
SHARED_FN float grownDeviation(IN(ReuseSums) s, float nominal, float before)
{
    if (s.taken < 2u) return before;
    const float count = float(s.taken);
    const float mean = luminance(s.beta * s.plain) / count;
    const float variance = max(s.plainSquares - count * mean * mean, 0.0f) / (count - 1.0f);
    const float had = before >= 0.0f ? nominal : 0.0f;
    const float all = (had * before * before + (count - 1.0f) * variance) / (had + count - 1.0f);
    return all < kInfinity ? sqrt(all) : before;
}

/// A part of a pixel's luminance as the counters take it.
SHARED_FN float biasShare(IN(ReuseSums) s, float part)
{
    const float whole = max(luminance(reusedRadiance(s)), 1.0e-30f);
    return min(part * luminance(s.beta) / whole, 1.0f);
}

/// What views of a pixel's reuse show. `old`: the share of the picture that old samples answer for
/// (alpha, averaged over directions); `c`: N / (N + n); `effective`: number of equal samples that
/// would be as good as the weights are (Kong 1992), which of a mean is the history that it now has;
/// `taken`: new paths; `deviation`: grownDeviation.
struct ReuseMapPixel {
    float old;
    float c;
    float effective;
    uint taken;
    float deviation;
};

/// The same share of a mean: a pass that takes no path leaves it as it was.
SHARED_FN float oldShareOfMean(float c, uint taken)
{
    return taken > 0u ? c : (c > 0.0f ? 1.0f : 0.0f);
}

SHARED_FN ReuseMapPixel reuseMap(IN(ReuseSums) s, uint strategy, float deviation)
{
    ReuseMapPixel m;
    m.c = s.nominal / (s.nominal + s.rays);
    m.old = s.oldShare;
    m.effective = s.weightSquares > 0.0f ? s.weightSum * s.weightSum / s.weightSquares : 0.0f;
    m.taken = s.taken;
    m.deviation = deviation;
    if (keepsMeans(strategy)) m.old = oldShareOfMean(m.c, m.taken);
    return m;
}

/// As it lies in memory, behind the mean of strategies that keep one: `mean` may be anything.
SHARED_FN vec4 packReuseMap(vec3 mean, ReuseMapPixel m, uint strategy)
{
    // In the mantissa of a number of [1,2): devices may flush denormal ones.
    const uint word =
        0x3f800000u | uint(min(m.c, 1.0f) * 4095.0f + 0.5f) | (min(m.taken, 2047u) << 12u);
    if (!keepsMeans(strategy)) mean = vec3(m.old, m.effective, m.deviation);
    return vec4(mean, uintAsFloat(word));
}

SHARED_FN ReuseMapPixel unpackReuseMap(vec4 w, uint strategy)
{
    const uint word = floatAsUint(w.w);
    ReuseMapPixel m;
    m.c = float(word & 0xfffu) * (1.0f / 4095.0f);
    m.taken = (word >> 12u) & 2047u;
    m.old = keepsMeans(strategy) ? oldShareOfMean(m.c, m.taken) : w.x;
    m.effective = keepsMeans(strategy) ? 0.0f : w.y;
    m.deviation = keepsMeans(strategy) ? kNoDeviation : w.z;
    return m;
}

SHARED_END

#endif
