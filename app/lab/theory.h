// What the formulas say the laboratory must measure: mean and variance of each estimator by
// quadrature over the pieces between crossings, edges and supports.
#pragma once

#include <functional>
#include <limits>
#include <vector>

#include "app/lab/pairs.h"
#include "app/lab/results.h"

namespace app::lab {

/// As Cell::candidates: the limit of RIS with ever more candidates, exact samples of the residual.
inline constexpr uint32_t kExactResidual = std::numeric_limits<uint32_t>::max();

struct Expectation {
    double mean = kUnknown;      // differs from the truth where the method is biased
    double variance = kUnknown;  // N Var; kInfinite where the integral provably diverges; kUnknown
                                 // where there is no formula
};

/// For the cell's pair, function, method, beta, N, n, k and c; the measured members are not read.
/// Both unknown where the method has no formula (biased by its own noise: Beta::own,
/// self-normalised reweighting) and where it does not exist (without a finite majorisation
/// constant). Old and new samples are independent, so their variances add.
Expectation expectation(const Cell& cell);

/// Integral of h between the first and the last of `breaks` (sorted), for h smooth between
/// neighbours, with integrable singularities of powers of x^(1/4) at the breaks at most. Relative
/// error below 1e-9 for features as narrow as those of the laboratory (.05).
double integrate(const std::vector<double>& breaks, const std::function<double(double)>& h);

}  // namespace app::lab
