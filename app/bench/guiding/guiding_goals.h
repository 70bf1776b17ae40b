// What path guiding is to gain, each goal with a verdict from the numbers.
#pragma once

#include <string>
#include <vector>

#include "app/bench/guiding/guiding_results.h"

namespace app::guiding {

enum class Verdict { met, missed, notMeasured };
const char* verdictName(Verdict verdict);

/// A goal for the efficiency of `guided` (error times seconds of plain path tracing over its own),
/// or for its error alone where the text says so.
struct Goal {
    std::string text;   // what is to be, in words
    double least = 0;   // that it is to be
    Ratio measured;     // unknown where nothing was
    std::string where;  // the scene and the device of that number
    Verdict verdict = Verdict::notMeasured;
};

/// All goals, those of which nothing was measured included.
std::vector<Goal> goalsOf(const Results& results);

}  // namespace app::guiding
