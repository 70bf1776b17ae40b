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
#include "reuse.glsl"

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
    const uint places = push.settings.strategy == kReuseFull ? min(count, 1u) : count;
    return NewPaths(first, count, 1.0, words.x >= 0x80000000u ? first + places : kNone);
}

uvec4 newWord(uint which, uint i)
{
    return texelFetch(newSamples, int(kReuseNewWords * which + i));
}

ReuseNew loadNew(uint which, float part)
{
    ReuseNew found = noReuseNew();
    found.record = unpackReuseSample(newWord(which, 0u), uvec4(0u));
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

ReuseSample oldSample(uint source, uint i)
{
    const int at = int(recordIndex(sizeBefore(), source, i));
    ReuseSample r = unpackReuseSample(texelFetch(placesBefore, at), uvec4(0u));
    r.slot = slotNow(r.slot);
    return r;
}

/// Adds an old sample by which radiance L comes; one that is hidden loses its weight.
void addOrDrop(ReuseView view, vec3 L, bool hidden, inout float weight, inout vec3 brings, inout ReuseSums sums)
{
    if (hidden) {
        dropOldSample(sums, view, L);
        weight = 0.0;
    } else {
        brings = addOldSample(sums, view, L);
    }
}

/// Old samples of directions and the new one: adds them up and keeps some. What arrives is evaluated in a loop of its
/// own, over those that need it: on software devices a branch costs the same whether it is taken or not, and a loop as
/// much as the lane that needs it most often.
void reuseSamples(ReuseVertex v, PathSettings path, SampleStream stream, bool looks, uint source, uint pixel,
                  NewPaths fresh, float xi, inout ReuseSums sums, inout ReuseTally tally)
{
    const uint most = recordsOf(push.settings);
    float weights[kReuseMostScores];  // v
    vec3 brings[kReuseMostScores];    // u F
    float places[kReuseMostScores];  // u as it is stored
    uint placed[kReuseMostRecords];  // where on its triangle the sample is now
    vec3 responses[kReuseMostRecords];
    uint evaluated = 0u;  // a bit for each
    uint hidden = 0u;
    uint turned = 0u;
    const uint count = looks ? most : 0u;
    for (uint i = 0u; i < most; ++i) {
        weights[i] = 0.0;
        brings[i] = vec3(0.0);
        places[i] = 0.0;
    }
    for (uint i = 0u; i < count; ++i) {
        ReuseSample r = oldSample(source, i);
        ReuseView view;
        if (!aimOldSample(scene, push.settings, v, r, view)) continue;
        placed[i] = r.place;
        if (push.settings.strategy == kReuseRejection && !survivesRejection(rejectionNumber(stream, i), view)) continue;
        weights[i] = view.u * view.p;
        places[i] = view.u * view.perPlace;
        responses[i] = view.response;
        if (oldSampleHides(scene, push.settings, v, view, stream, i, tally)) hidden |= 1u << i;
        if (isEvaluated(push.settings, r)) {
            evaluated |= 1u << i;
            if (view.turned) turned |= 1u << i;
        } else {
            addOrDrop(view, unpackRgbe(r.radiance), (hidden & (1u << i)) != 0u, weights[i], brings[i], sums);
        }
    }
    while (evaluated != 0u) {
        const uint i = uint(findLSB(evaluated));
        evaluated &= evaluated - 1u;
        const int at = int(recordIndex(sizeBefore(), source, i));
        uvec4 arriving = uvec4(0u);
        if (hasArrivingWords(push.settings)) arriving = texelFetch(arrivingBefore, at);
        ReuseSample r = unpackReuseSample(texelFetch(placesBefore, at), arriving);
        r.slot = slotNow(r.slot);
        r.place = placed[i];
        ReuseView view;
        vec3 n;
        Triangle t;
        view.distance = kInfinity;
        view.perPlace = 1.0;
        view.turned = (turned & (1u << i)) != 0u;
        if (showsElse(r, view)) {
            weights[i] = 0.0;
            continue;
        }
        if (wayToPlace(scene, r, v.vertex.surface.position, view.direction, t, n)) {
            if (!arrivingIsOld(scene, push.settings, v.vertex.surface.position + view.direction, r)) {
                weights[i] = 0.0;
                continue;
            }
            view.distance = length(view.direction);
            view.direction /= view.distance;
            view.perPlace = view.distance * view.distance / abs(dot(n, view.direction));
        }
        view.response = responses[i];
        view.u = places[i] / view.perPlace;
        view.p = weights[i] / view.u;
        addOrDrop(view, evaluateArriving(scene, path, push.settings, v, r, view), (hidden & (1u << i)) != 0u, weights[i],
                  brings[i], sums);
    }
    vec3 mean = sums.around;
    for (uint k = 0u; k < fresh.count; ++k) {
        const ReuseNew found = loadNew(fresh.first + k, fresh.part);
        mean += found.scale * found.around;
        places[most + k] = found.record.u;
        weights[most + k] = found.record.u > 0.0 ? found.scale : 0.0;
        brings[most + k] = found.record.u > 0.0 ? found.scale * found.around : vec3(0.0);
    }
    const uint all = most + fresh.count;
    for (uint i = 0u; i < all; ++i) {
        weights[i] = reuseScore(push.settings, weights[i], luminance(brings[i]), mean);
        sums.remainder += brings[i];
    }
    const float kappa = reuseThreshold(weights, all, most);
    float sum = 0.0;
    uint kept = 0u;
    for (uint i = 0u; i < all && kept < most; ++i) {
        if (!usableDensity(weights[i])) continue;
        if (kappa > 0.0 && !reuseKeep(sum, weights[i], kappa, xi)) continue;
        const int at = int(recordIndex(sizeBefore(), source, min(i, most - 1u)));
        const uint which = fresh.first + i - most;
        uvec4 place;
        if (i < most) {
            place = texelFetch(placesBefore, at);
            place = uvec4(slotNow(place.x), placed[i], place.zw);
        } else {
            place = newWord(which, 0u);
        }
        const float scale = kappa > 0.0 ? reuseKeepScale(weights[i], kappa) : 1.0;
        place.z = floatBitsToUint(places[i] * scale);
        sums.remainder -= scale * brings[i];
        const uint to = recordIndex(sizeNow(), pixel, kept++);
        placesNow[to] = place;
        if (place.w != kReuseEvaluated || !hasArrivingWords(push.settings)) continue;
        if (i < most)
            arrivingNow[to] = texelFetch(arrivingBefore, at);
        else
            arrivingNow[to] = newWord(which, 1u);
    }
    for (; kept < most; ++kept) placesNow[recordIndex(sizeNow(), pixel, kept)] = uvec4(kNone, 0u, 0u, 0u);
}

/// The same of connections to emitters.
void reuseLights(ReuseVertex v, PathSettings path, SampleStream stream, bool looks, uint source, uint pixel,
                 NewPaths fresh, float xi, inout ReuseSums sums, inout ReuseTally tally)
{
    const uint most = lightsOf(push.settings);
    float scores[kReuseMostScores];
    vec3 brings[kReuseMostScores];
    float weights[kReuseMostScores];
    for (uint i = 0u; i < most; ++i) {
        weights[i] = 0.0;
        brings[i] = vec3(0.0);
        if (!looks) continue;
        ReuseLight r = unpackLightRecord(texelFetch(lightsBefore, int(recordIndex(sizeBefore(), source, i))));
        if (!(r.v > 0.0)) continue;
        brings[i] = addOldLight(scene, path, push.settings, v, stream, i, r, sums, tally);
        weights[i] = r.v;
    }
    vec3 mean = sums.direct;
    for (uint k = 0u; k < fresh.count; ++k) {
        const ReuseNew found = loadNew(fresh.first + k, fresh.part);
        mean += found.light.v * found.direct;
        weights[most + k] = found.light.v;
        brings[most + k] = found.light.v * found.direct;
    }
    const uint all = most + fresh.count;
    // Unbiased connections are not looked at again.
    const float carries = isUnbiased(push.settings) ? 0.0 : 1.0;
    for (uint i = 0u; i < all; ++i) {
        scores[i] = reuseScore(push.settings, weights[i], luminance(brings[i]), mean);
        sums.remainder += carries * brings[i];
    }
    const float kappa = reuseThreshold(scores, all, most);
    float sum = 0.0;
    uint kept = 0u;
    for (uint i = 0u; i < all && kept < most; ++i) {
        if (!usableDensity(scores[i])) continue;
        if (kappa > 0.0 && !reuseKeep(sum, scores[i], kappa, xi)) continue;
        uvec4 light;
        if (i < most)
            light = texelFetch(lightsBefore, int(recordIndex(sizeBefore(), source, i)));
        else
            light = newWord(fresh.first + i - most, 2u);
        const float scale = kappa > 0.0 ? reuseKeepScale(scores[i], kappa) : 1.0;
        light.z = floatBitsToUint(weights[i] * scale);
        sums.remainder -= (carries * scale) * brings[i];
        lightsNow[recordIndex(sizeNow(), pixel, kept++)] = light;
    }
    for (; kept < most; ++kept) lightsNow[recordIndex(sizeNow(), pixel, kept)] = uvec4(0u);
}

/// One more sample of the pixel, or (begins) the first ones: as many as the history stands for.
void addToFilm(uint pixel, bool begins, vec3 L, vec3 squares, float weight)
{
    FilmPixel p = FilmPixel(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), 0.0);
    if (!begins) p = loadFilm(pixel);
    // What is known at the beginning is an estimate, which may be below zero.
    if (isColour(begins ? abs(L) : L)) {
        addCompensated(p.sum, p.sumLost, weight * L);
        addCompensated(p.squares, p.squaresLost, weight * squares);
    }
    p.weight += weight;
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

/// Adds the new paths of a pixel.
void addNewPaths(NewPaths fresh, inout ReuseSums sums)
{
    if (push.settings.strategy == kReuseFull && fresh.count > 0u) {
        addPathSums(sums, newWord(fresh.first, 0u), newWord(fresh.first, 1u), newWord(fresh.first, 2u),
                    newWord(fresh.first, 3u), newWord(fresh.first, 4u), fresh.count);
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
void count(ReuseSums sums, bool begins, bool scatters, bool looks, ReuseTally tally)
{
    const float c = sums.nominal / (sums.nominal + sums.rays);
    const uint all = subgroupAdd(scatters ? 1u : 0u);
    const uint withHistory = subgroupAdd(looks ? 1u : 0u);
    const uint weights = subgroupAdd(uint(min(sums.weightSum, 64.0) * kCountedUnit + 0.5));
    const uint shares = subgroupAdd(uint(c * kCountedUnit + 0.5));
    if (FEATURE(kFeatureAsksVisibility)) countVisibility(sums, begins, all, tally);
    if (!subgroupElect()) return;
    atomicAdd(counters.scatters, all);
    atomicAdd(counters.withHistory, withHistory);
    atomicAdd(counters.weightSum, weights);
    atomicAdd(counters.shareSum, shares);
}

void main()
{
    uint lane;
    uvec2 pixel;
    if (!lanesPixel(lane, pixel)) return;
    const uint i = pixelIndex(pixel);
    const uvec4 here = pixelsNow[i];
    const SampleStream stream = pixelStream(pixel);
    const SampleStream keeping = decisionStream(stream, kPurposeResampling);
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
        reuseSamples(v, path, stream, looks, source, i, fresh, streamFloat(keeping, 0u), sums, tally);
        reuseLights(v, path, stream, looks, source, i, fresh, streamFloat(keeping, 1u), sums, tally);
    }
    addNewPaths(fresh, sums);
    if (carriesRemainder(push.settings)) remaindersNow[i] = vec4(remainderNow(sums), 0.0);
    if (FEATURE(kFeatureDelta) && fresh.rest != kNone) sums.rest = loadNew(fresh.rest, 1.0).around;
    vec3 L = reusedRadiance(sums);
    vec3 squares = reusedSquares(sums);
    const vec3 plain = plainRadiance(sums);
    if (keepsMeans(strategy)) {
        vec3 before = looks ? texelFetch(meansBefore, int(source)).xyz : vec3(0.0);
        // What is seen over mirrors or through glass has no other taps: it is not known where they would lie.
        if (strategy == kReuseSvgf && looks && (here.w & kChained) == 0u)
            before = meanOfTaps(v.vertex.surface, motionOf(unpackReusePixel(here)), before);
        L = naiveMean(sums, before);
        squares = L * L;
    }
    float deviation = kNoDeviation;
    if (looks) deviation = unpackReuseMap(texelFetch(meansBefore, int(source)), strategy).deviation;
    if (scatters) deviation = grownDeviation(sums, v.history.nominal, deviation);
    meansNow[i] = packReuseMap(L, reuseMap(sums, strategy, deviation), strategy);
    const bool begins = (push.settings.flags & kReuseFollows) == 0u;
    if (begins) {
        addToFilm(i, true, L, squares, sums.nominal + sums.rays);
    } else {
        addToFilm(i, false, plain, plain * plain, 1.0);
    }
    count(sums, begins, scatters, sums.nominal > 0.0, tally);
    ReuseHistory history = noHistory();
    if (scatters) {
        history = grownHistory(push.settings, v.history, v.rays, narrowestLobe(v.vertex.bsdf));
    }
    pixelsNow[i].w = packHistory(history);
}
