// What the rows of a scene say on practical path guiding and on chapter 9 of S. Wang, "Efficient
// Sample Usage in Photo-Realistic Rendering" (2022): tables of the families of variants, and plain
// sentences that follow from them.
#pragma once

#include <string>
#include <vector>

#include "app/bench/guiding/guiding_cases.h"
#include "app/bench/guiding/guiding_results.h"

namespace app::guiding {

/// A family on one device with so many samples per pixel; `rows` in the table's order.
struct Claim {
    Family family;
    std::string device;
    uint32_t spp = 0;
    std::vector<const Row*> rows;
    std::string sentence;  // what they say; empty where some that it takes were not measured
};

/// All families but the switches, of which something was measured.
std::vector<Claim> claimsOf(const Results& results, const SceneResult& scene);

}  // namespace app::guiding
