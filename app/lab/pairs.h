// The nine changes of density D1 to D9 of the one-dimensional laboratory, and their exact
// constants: overlap and residual mass, the best c, the majorisation constants.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>
#include <vector>

#include "app/lab/density.h"
#include "app/lab/functions.h"
#include "core/reuse/solve_c.h"

namespace app::lab {

struct Pair {
    const char* id;       // "D2"
    const char* name;     // "small shift"
    const char* meaning;  // "the lobe moved by its own width"
    const char* formula;  // "C(.45,.1) -> C(.55,.1)"
    Density q, p;         // old, new

    /// P and Q of the set where p > c q: what core::reuse::solveC asks for. Closed form, by the
    /// cdfs between crossings.
    core::reuse::Masses overSampled(double c) const;
    /// R(c), the mass of (p - c q)+.
    double residual(double c) const;
    /// c* for n new samples beside N old ones: c n = N R(c).
    double bestC(double oldSamples, double newSamples) const;
    double rejectionConstant() const { return supremumOfRatio(p, q); }     // b
    double augmentationConstant() const { return supremumOfRatio(q, p); }  // a
    /// Integral of f over the support of p, per function.
    Values truth() const { return integrateFunctions(p.low(), p.high()); }
};

inline constexpr size_t kPairs = 9;
const std::array<Pair, kPairs>& pairs();

/// The pair of that id; null when there is none. pairOf CHECKs that there is.
const Pair* findPair(std::string_view id);
const Pair& pairOf(std::string_view id);

}  // namespace app::lab
