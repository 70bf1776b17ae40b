// Looks at the samples of the frame before from the first hits of this one, adds up what they and the new ones bring,
// and cuts the store down to what is kept for the next frame. One kernel: what it knows of a pixel would take longer to
// store and load than to find.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_basic : require

#define REKINDLE_READS_CHAINS
#include "colour.glsl"
#include "film.glsl"
#include "reuse_competition.glsl"

layout(local_size_x = 64) in;

layout(set = kSetKernel, binding = kBindPlacesBefore) uniform usamplerBuffer placesBefore;
layout(set = kSetKernel, binding = kBindArrivingBefore) uniform usamplerBuffer arrivingBefore;
layout(set = kSetKernel, binding = kBindLightsBefore) uniform usamplerBuffer lightsBefore;
layout(set = kSetKernel, binding = kBindMeansBefore) uniform samplerBuffer meansBefore;
layout(set = kSetKernel, binding = kBindRemaindersBefore) uniform samplerBuffer remaindersBefore;
layout(set = kSetKernel, binding = kBindNewSamples) uniform usamplerBuffer newSamples;
layout(set = kSetKernel, binding = kBindFirstNew) uniform usamplerBuffer firstNew;

layout(set = kSetKernel, binding = kBindPlacesNow, scalar) writeonly buffer PlacesNowBlock
{
    uvec4 placesNow[];
};

layout(set = kSetKernel, binding = kBindArrivingNow, scalar) writeonly buffer ArrivingNowBlock
{
    uvec4 arrivingNow[];
};

layout(set = kSetKernel, binding = kBindLightsNow, scalar) writeonly buffer LightsNowBlock
{
    uvec4 lightsNow[];
};

layout(set = kSetKernel, binding = kBindMeansNow, scalar) writeonly buffer MeansNowBlock
{
    vec4 meansNow[];
};

layout(set = kSetKernel, binding = kBindRemaindersNow, scalar) writeonly buffer RemaindersNowBlock
{
    vec4 remaindersNow[];
};

uvec2 sizeNow()
{
    return uvec2(frame.settings.imageWidth, frame.settings.imageHeight);
}

/// The new paths of a pixel, what each counts as, and that of a way not taken (kNone: there is none).
struct NewPaths {
    uint first;
    uint count;
    float part;
    uint rest;
};

/// As reuse_hits has packed them.
NewPaths newPathsOf(uvec2 words)
{
    const uint first = words.x & 0x7fffffffu;
    const uint count = words.y & 0xffffu;
    return NewPaths(first, count, 1.0, words.x >= 0x80000000u ? first + placesFor(count) : kNone);
}

uvec4 newWord(uint which, uint i)
{
    return texelFetch(newSamples, int(kReuseNewWords * which + i));
}

ReuseNew loadNew(uint which, float part)
{
    ReuseNew found = noReuseNew();
    found.record = unpackReuseSample(push.settings, newWord(which, 0u), uvec4(0u));
    found.light = unpackLightRecord(newWord(which, 2u));
    const vec4 around = uintBitsToFloat(newWord(which, 3u));
    found.around = around.xyz;
    found.lost = around.w;
    const vec4 direct = uintBitsToFloat(newWord(which, 4u));
    found.direct = direct.xyz;
    found.scale = direct.w;
    countAsPart(part, found);
    return found;
}

/// The first word of an old sample, as it lies in memory.
uvec4 oldWord(uint source, uint i)
{
    uvec4 word = texelFetch(placesBefore, int(recordIndex(sizeBefore(), source, i)));
    word.x = slotNow(word.x);
    return word;
}

/// Adds an old sample by which radiance L comes, unless it is hidden.
void addOld(uint i, ReuseSample r, ReuseView view, vec3 L, bool hides, inout ReuseSums sums)
{
    if (hides) {
        dropOldSample(sums, view, L);
    } else {
        const vec3 brings = addOldSample(sums, view, L);
        enter(kOfSamples, i, view.u * view.p, brings, view.u * view.perPlace, r.place);
    }
}

/// Whether an old sample survives, of strategies that drop some.
bool survives(SampleStream stream, uint i, inout ReuseView view)
{
    return push.settings.strategy != kReuseRejection || survivesRejection(rejectionNumber(stream, i), view);
}

/// Looks at those old samples of a pixel that keep their directions. Visibility is not asked for where samples do.
void lookAtDirections(ReuseVertex v, PathSettings path, SampleStream stream, uint source, inout ReuseSums sums)
{
    for (uint i = 0u; i < kRecords; ++i) {
        const ReuseSample r = unpackReuseSample(push.settings, oldWord(source, i), uvec4(0u));
        ReuseView view;
        if (r.slot != kNone || !aimOldDirection(scene, push.settings, v, r, view)) continue;
        if (!survives(stream, i, view)) continue;
        const vec3 L = r.radiance == kReuseEvaluated ? skyOfSample(scene, path, v, view) : unpackRgbe(r.radiance);
        addOld(i, r, view, L, false, sums);
    }
}

/// Which old samples of a pixel are looked at by their places, a bit for each.
uint samplesWithPlaces(uint source)
{
    if (!keepsDirections(push.settings)) return (1u << kRecords) - 1u;
    uint found = 0u;
    for (uint i = 0u; i < kRecords; ++i) {
        const uint slot = texelFetch(placesBefore, int(recordIndex(sizeBefore(), source, i))).x;
        if (slot != kNone) found |= 1u << i;
    }
    return found;
}

/// Looks at old samples that have a place, or may have one. Where most keep their directions this is a loop over the
/// others: on software devices a branch costs the same whether it is taken or not, and a loop as much as the lane that
/// needs it most often.
void lookAtPlaces(ReuseVertex v, PathSettings path, SampleStream stream, uint source, inout ReuseSums sums,
                  inout ReuseTally tally)
{
    uint left = samplesWithPlaces(source);
    while (left != 0u) {
        const uint i = uint(findLSB(left));
        left &= left - 1u;
        uvec4 arriving = uvec4(0u);
        if (hasArrivingWords(push.settings))
            arriving = texelFetch(arrivingBefore, int(recordIndex(sizeBefore(), source, i)));
        ReuseSample r = unpackReuseSample(push.settings, oldWord(source, i), arriving);
        ReuseView view;
        if (!aimOldSample(scene, push.settings, v, r, view) || !survives(stream, i, view)) continue;
        const bool hides = oldSampleHides(scene, push.settings, v, view, stream, i, tally);
        vec3 L = unpackRgbe(r.radiance);
        if (isEvaluated(push.settings, r)) {
            const vec3 place = v.vertex.surface.position + view.distance * view.direction;
            if (showsElse(r, view) || !arrivingIsOld(scene, push.settings, place, r)) continue;
            L = evaluateArriving(scene, path, push.settings, v, r, view);
        }
        addOld(i, r, view, L, hides, sums);
    }
}

/// The same of old connections to emitters.
void lookAtLights(ReuseVertex v, PathSettings path, SampleStream stream, uint source, inout ReuseSums sums,
                  inout ReuseTally tally)
{
    for (uint i = 0u; i < kLights; ++i) {
        ReuseLight r = unpackLightRecord(texelFetch(lightsBefore, int(recordIndex(sizeBefore(), source, i))));
        if (!(r.v > 0.0)) continue;
        const vec3 brings = addOldLight(scene, path, push.settings, v, stream, i, r, sums, tally);
        enter(kOfLights, i, r.v, brings, r.v, r.through);
    }
}

/// Keeps what has won a place.
void storeSamples(uint source, uint pixel, NewPaths fresh)
{
    for (uint place = 0u; place < kRecords; ++place) {
        const Kept one = keptIn(place);
        const bool isOld = one.which < kRecords;
        const uint which = fresh.first + one.which - kRecords;
        uvec4 word = uvec4(kNone, 0u, 0u, 0u);
        if (isOld) {
            word = oldWord(source, one.which);
        } else if (one.which != kNone) {
            word = newWord(which, 0u);
        }
        const uint to = recordIndex(sizeNow(), pixel, place);
        placesNow[to] = uvec4(word.x, one.place, floatBitsToUint(one.stored), word.w);
        if (one.which == kNone || word.w != kReuseEvaluated || !hasArrivingWords(push.settings)) continue;
        if (isOld) {
            arrivingNow[to] = texelFetch(arrivingBefore, int(recordIndex(sizeBefore(), source, one.which)));
        } else {
            arrivingNow[to] = newWord(which, 1u);
        }
    }
}

void storeLights(uint source, uint pixel, NewPaths fresh)
{
    for (uint place = 0u; place < kLights; ++place) {
        const Kept one = keptIn(place);
        uvec4 word = uvec4(0u);
        if (one.which < kLights) {
            word = texelFetch(lightsBefore, int(recordIndex(sizeBefore(), source, one.which)));
        } else if (one.which != kNone) {
            word = newWord(fresh.first + one.which - kLights, 2u);
        }
        word.z = floatBitsToUint(one.stored);
        if (FEATURE(kFeaturePanes)) word.w = one.place;
        lightsNow[recordIndex(sizeNow(), pixel, place)] = word;
    }
}

/// Adds up old samples and new ones, and keeps some of both.
void reuseSamples(ReuseVertex v, PathSettings path, SampleStream stream, bool looks, uint source, uint pixel,
                  NewPaths fresh, inout ReuseSums sums, inout ReuseTally tally)
{
    const uint allSamples = competing(kRecords, fresh.count);
    const uint allLights = competing(kLights, fresh.count);
    beginCompetition(kOfSamples, allSamples);
    beginCompetition(kOfLights, allLights);
    if (looks) {
        if (keepsDirections(push.settings)) lookAtDirections(v, path, stream, source, sums);
        lookAtPlaces(v, path, stream, source, sums, tally);
        lookAtLights(v, path, stream, source, sums, tally);
    }
    for (uint k = 0u; k < competing(0u, fresh.count); ++k) {
        if (k >= fresh.count) continue;
        const ReuseNew found = loadNew(fresh.first + k, fresh.part);
        addReuseNew(sums, found);
        const ReuseSample r = found.record;
        if (r.u > 0.0) enter(kOfSamples, kRecords + k, found.scale, found.scale * found.around, r.u, r.place);
        enter(kOfLights, kLights + k, found.light.v, found.light.v * found.direct, found.light.v, found.light.through);
    }
    const SampleStream keeping = decisionStream(stream, kPurposeResampling);
    sums.remainder = compete(kOfSamples, allSamples, kRecords, sums.around, streamFloat(keeping, 0u));
    storeSamples(source, pixel, fresh);
    const vec3 ofLights = compete(kOfLights, allLights, kLights, sums.direct, streamFloat(keeping, 1u));
    storeLights(source, pixel, fresh);
    if (!isUnbiased(push.settings)) sums.remainder += ofLights;  // else they are not looked at again
}

/// One more sample of the pixel, or (begins) the first ones: as many as weightAtRest.
void addToFilm(uint pixel, bool begins, vec3 L, vec3 squares, float weight)
{
    FilmPixel p = FilmPixel(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), 0.0, 0.0);
    if (!begins) p = loadFilm(pixel);
    // What is known at the beginning is an estimate, which may be below zero.
    if (isColour(begins ? abs(L) : L)) {
        addCompensated(p.sum, p.sumLost, weight * L);
        addCompensated(p.squares, p.squaresLost, weight * squares);
    }
    addWeight(p, weight);
    storeFilm(pixel, p);
}

/// Mean of the four pixels around where the first hit was before, of those whose history fits; `nearest` where none
/// does.
vec3 meanOfTaps(SurfacePoint s, SurfaceMotion motion, vec3 nearest)
{
    const CameraData cameraBefore = movedCamera(push.cameraBefore, motion);
    const ivec2 size = ivec2(sizeBefore());
    vec2 film;
    projectToFilm(cameraBefore, vec2(size), s.position, film);
    const float away = length(s.position - cameraBefore.position);
    vec4 sum = vec4(0.0);
    for (uint k = 0u; k < 4u; ++k) {
        ivec2 at;
        const float weight = historyTap(film, k, at);
        if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, size))) continue;
        const uint source = uint(at.y * size.x + at.x);
        const ReusePixel before = loadPixelBefore(source);
        if (historyFits(scene, push.settings, cameraBefore, before, s, motion.piece, away, kInfinity))
            sum += weight * vec4(texelFetch(meansBefore, int(source)).xyz, 1.0);
    }
    return sum.w > 0.01 ? sum.xyz / sum.w : nearest;
}

/// Adds the new paths of a pixel, where nothing is kept of them.
void addNewPaths(NewPaths fresh, inout ReuseSums sums)
{
    if (push.settings.strategy == kReuseFull && fresh.count > 0u) {
        for (uint at = fresh.first; at < fresh.first + placesFor(fresh.count); ++at)
            addPathSums(sums, newWord(at, 0u), newWord(at, 1u), newWord(at, 2u), newWord(at, 3u), newWord(at, 4u));
        sums.taken = fresh.count;
        return;
    }
    for (uint k = 0u; k < fresh.count; ++k) addReuseNew(sums, loadNew(fresh.first + k, fresh.part));
}

/// What asking for visibility has cost, and what it has found across a move: in the pass that begins a view.
void countVisibility(ReuseSums sums, bool begins, uint scatters, ReuseTally tally)
{
    const uint rays = subgroupAdd(tally.shadowRays);
    if (subgroupElect()) atomicAdd(counters.shadowRays, rays);
    if (!begins) return;
    const uint leaked = subgroupAdd(uint(biasShare(sums, sums.leaked) * kCountedBias + 0.5));
    const uint lost = subgroupAdd(uint(biasShare(sums, sums.lost) * kCountedBias + 0.5));
    if (!subgroupElect()) return;
    atomicAdd(counters.asked, scatters);
    atomicAdd(counters.leaked, leaked);
    atomicAdd(counters.lost, lost);
}

/// What is told of the picture.
void count(ReuseSums sums, bool begins, bool scatters, bool looks, uint paths, ReuseTally tally)
{
    const float c = sums.nominal / (sums.nominal + sums.rays);
    const uint all = subgroupAdd(scatters ? 1u : 0u);
    const uint withHistory = subgroupAdd(looks ? 1u : 0u);
    const uint weights = subgroupAdd(uint(min(sums.weightSum, 64.0) * kCountedUnit + 0.5));
    const uint shares = subgroupAdd(uint(c * kCountedUnit + 0.5));
    const uint taken = subgroupAdd(paths);
    if (FEATURE(kFeatureAsksVisibility)) countVisibility(sums, begins, all, tally);
    if (!subgroupElect()) return;
    atomicAdd(counters.scatters, all);
    atomicAdd(counters.withHistory, withHistory);
    atomicAdd(counters.weightSum, weights);
    atomicAdd(counters.shareSum, shares);
    atomicAdd(counters.newPaths, taken);
}

void main()
{
    uint lane;
    uvec2 pixel;
    if (!lanesPixel(lane, pixel)) return;
    const uint i = pixelIndex(pixel);
    const uvec4 here = pixelsNow[i];
    const SampleStream stream = pixelStream(pixel);
    const uint strategy = push.settings.strategy;
    ReuseSums sums = noReuseSums();
    ReuseTally tally = ReuseTally(0u, 0u);
    ReuseVertex v;
    vec3 towardsBefore;
    PathSettings path = frame.settings;
    const bool scatters = firstVertex(pixel, lane, stream, here, path, v, towardsBefore, sums.seen);
    const bool looks = scatters && lookBack(here, towardsBefore, v);
    const uint source = here.w & ~kChained;
    const uvec2 words = texelFetch(firstNew, int(lane)).xy;
    NewPaths fresh = newPathsOf(words);
    if (scatters) {
        v.history.credit = unpackCredit(words.y >> 16u);
        sums.nominal = v.c > 0.0 ? v.history.nominal : 0.0;
        sums.rays = v.rays;
        sums.beta = v.beta;
        sums.part = fresh.part = partOfPath(v.rays, fresh.count);
    } else {
        fresh.count = 0u;
    }
    if (keepsSamples(strategy)) {
        if (looks && carriesRemainder(push.settings))
            giveBack(v, texelFetch(remaindersBefore, int(source)).xyz, sums);
        reuseSamples(v, path, stream, looks, source, i, fresh, sums, tally);
    } else {
        addNewPaths(fresh, sums);
    }
    if (carriesRemainder(push.settings)) remaindersNow[i] = vec4(remainderNow(sums), 0.0);
    if (FEATURE(kFeatureDelta) && fresh.rest != kNone) sums.rest = loadNew(fresh.rest, 1.0).around;
    vec3 L = reusedRadiance(sums);
    const float weight = weightAtRest(sums, magnified());
    vec3 squares = reusedSquares(sums, weight);
    const vec3 plain = plainRadiance(sums);
    vec3 mean = vec3(0.0);
    if (keepsMeans(strategy)) {
        vec3 before = looks ? texelFetch(meansBefore, int(source)).xyz : vec3(0.0);
        // What is seen over mirrors or through glass has no other taps: it is not known where they would lie.
        if (strategy == kReuseSvgf && looks && (here.w & kChained) == 0u)
            before = meanOfTaps(v.vertex.surface, motionOf(unpackReusePixel(here)), before);
        L = naiveMean(sums, before);
        mean = keptMean(L, before);
        squares = L * L;
    }
    float deviation = kNoDeviation;
    if (looks) deviation = unpackReuseMap(texelFetch(meansBefore, int(source)), strategy).deviation;
    if (scatters) deviation = grownDeviation(sums, v.history.nominal, deviation);
    meansNow[i] = packReuseMap(mean, reuseMap(sums, strategy, deviation), strategy);
    const bool begins = (push.settings.flags & kReuseFollows) == 0u;
    if (begins) {
        addToFilm(i, true, L, squares, weight);
    } else {
        addToFilm(i, false, plain, plain * plain, 1.0);
    }
    // A pixel that scatters nothing is the one path that found so.
    count(sums, begins, scatters, sums.nominal > 0.0, scatters ? fresh.count : 1u, tally);
    ReuseHistory history = noHistory();
    if (scatters) {
        history = grownHistory(push.settings, v.history, v.rays, narrowestLobe(v.vertex.bsdf));
    }
    pixelsNow[i].w = packHistory(history);
}
