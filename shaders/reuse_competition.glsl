// The records of a pixel, old ones, then new ones, compete for its places in the store. They are arrays; their lengths
// are constants, and an element by a number of each lane is found by a loop over all, so that they lie in registers: on
// software devices an array is memory, and such an element a load or a store for each lane.
#include "shared/bindings.h"

layout(constant_id = kSpecializeRecords) const uint kRecords = 4u;
layout(constant_id = kSpecializeLights) const uint kLights = 2u;
layout(constant_id = kSpecializeFresh) const uint kFresh = 1u;
#define REKINDLE_MOST_SCORES ((kRecords > kLights ? kRecords : kLights) + kFresh)

#include "reuse.glsl"

// Where there may be many they lie in memory nonetheless, and loops end with those that there are: loops that end by
// constants are unrolled, and would take minutes to compile.
const bool kInMemory = kReuseMostScores > 12u;

// Two competitions: of samples, and of connections. Not parameters, since these are copied.
const uint kOfSamples = 0u;
const uint kOfLights = kReuseMostScores;
float recordWeights[2u * kReuseMostScores];  // v; 0: there is no record
vec3 recordBrings[2u * kReuseMostScores];    // u F, of connections v F
float recordStored[2u * kReuseMostScores];   // u per area or solid angle, or v
uint recordPlaces[2u * kReuseMostScores];    // of samples: where they are now; of connections: what comes through

/// One that has kept its place.
struct Kept {
    uint which;  // kNone: there is none
    float stored;
    uint place;
};

Kept kept[kReuseMostScores];

/// Records of a pixel that keeps `most` old ones and has that many new paths.
uint competing(uint most, uint fresh)
{
    return most + (kInMemory ? fresh : kFresh);
}

/// Begins a competition of `all` records, of which there is none yet.
void beginCompetition(uint of, uint all)
{
    for (uint i = 0u; i < all; ++i) {
        recordWeights[of + i] = 0.0;
        recordBrings[of + i] = vec3(0.0);
        recordStored[of + i] = 0.0;
        recordPlaces[of + i] = 0u;
    }
}

/// Lets record `i` take part.
void enter(uint of, uint i, float weight, vec3 brings, float stored, uint place)
{
    for (uint j = kInMemory ? i : 0u; j < (kInMemory ? i + 1u : kReuseMostScores); ++j) {
        if (j != i) continue;
        recordWeights[of + j] = weight;
        recordBrings[of + j] = brings;
        recordStored[of + j] = stored;
        recordPlaces[of + j] = place;
    }
}

void setKept(uint place, Kept one)
{
    if (kInMemory) {
        kept[place] = one;
        return;
    }
    for (uint j = 0u; j < kReuseMostScores; ++j)
        if (j == place) kept[j] = one;
}

/// Who has place number `place` after a competition.
Kept keptIn(uint place)
{
    if (kInMemory) return kept[place];
    Kept found = Kept(kNone, 0.0, 0u);
    for (uint j = 0u; j < kReuseMostScores; ++j)
        if (j == place) found = kept[j];
    return found;
}

/// Decides which of the first `all` keep one of `most` places (keptIn), in their order, and pays them for the others:
/// what is stored of them grows. `mean`: what all together bring. Returns what they brought less what the kept ones
/// bring.
vec3 compete(uint of, uint all, uint most, vec3 mean, float xi)
{
    float scores[kReuseMostScores];
    vec3 remainder = vec3(0.0);
    for (uint i = 0u; i < all; ++i) {
        const vec3 brings = recordBrings[of + i];
        scores[i] = reuseScore(push.settings, recordWeights[of + i], luminance(brings), mean);
        remainder += brings;
        kept[i] = Kept(kNone, 0.0, 0u);
    }
    const float kappa = reuseThreshold(scores, all, most);
    float sum = 0.0;
    uint count = 0u;
    for (uint i = 0u; i < all; ++i) {
        if (!usableDensity(scores[i]) || count >= most) continue;
        if (kappa > 0.0 && !reuseKeep(sum, scores[i], kappa, xi)) continue;
        const float scale = kappa > 0.0 ? reuseKeepScale(scores[i], kappa) : 1.0;
        remainder -= scale * recordBrings[of + i];
        setKept(count++, Kept(i, scale * recordStored[of + i], recordPlaces[of + i]));
    }
    return remainder;
}
