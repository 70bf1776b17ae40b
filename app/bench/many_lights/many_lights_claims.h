// What the thesis claims, and what this project wants, each with a verdict from the numbers.
#pragma once

#include <string>
#include <vector>

#include "app/bench/many_lights/many_lights_results.h"

namespace app::many_lights {

enum class Verdict { reproduced, refuted, undecided };
const char* verdictName(Verdict verdict);

/// A measured number that should lie in [low, high].
struct Finding {
    std::string scene, what;
    Spread value;
    double low = 0, high = 0;
};

/// Reproduced when all repetitions lie in the interval, refuted when all lie on one side of it,
/// undecided in between and with fewer than two.
Verdict verdictOf(const Finding& finding);

struct Claim {
    std::string name, text;
    bool most = false;  // of most scenes, not of all
    std::vector<Finding> findings;
};

/// Of what is decided: refuted when any finding is (or as many as are reproduced, where the claim
/// is one of most scenes), reproduced when none is; undecided where that rests on less than half of
/// the findings.
Verdict verdictOf(const Claim& claim);

/// All claims; those of which nothing was measured have no findings.
std::vector<Claim> claimsOf(const Results& results);

/// A setting of a method: how long it takes and how wrong it is.
struct Reached {
    double seconds = 0, error = 0;
};

/// Seconds until an error is reached along a curve in order of seconds: between two settings error
/// is a power of time. Infinite where no setting reaches it; that of the first where it is reached
/// there already.
double secondsToReach(const std::vector<Reached>& curve, double error);

/// For each repetition, how many times the time of `thesis` with `clusters` clusters `method` needs
/// for that error.
Spread equalErrorRatio(const SceneResult& scene, const std::string& method, uint32_t clusters);

}  // namespace app::many_lights
