// The methods that the laboratory compares: one table, walked by the experiments, the report and
// the tests.
#pragma once

#include <span>
#include <string_view>

#include "app/lab/results.h"

namespace app::lab {

struct Method {
    const char* id;  // in lab.json
    const char* name;
    const char* formula;  // one line, as text with Unicode
    const char* meaning;  // one or two sentences for a reader who does not know it
    const char* needs;    // what must hold or be known, "" for nothing
    bool unbiased;        // wherever its needs are met
    bool fresh;           // draws new samples, so that n matters
};

/// All methods, comparators first.
std::span<const Method> methods();

/// The method of that id. CHECKs that there is one.
const Method& methodOf(std::string_view id);

}  // namespace app::lab
