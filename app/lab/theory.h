// What the formulas say the laboratory must measure: mean and variance of each estimator by
// quadrature over the pieces between crossings, edges and supports.
#pragma once

#include <functional>
#include <vector>

#include "app/lab/pairs.h"
#include "app/lab/results.h"

namespace app::lab {

struct Expectation {
    double mean = kUnknown;      // differs from the truth where the method is biased
    double variance = kUnknown;  // N Var; kInfinite where the integral provably diverges; kUnknown
                                 // where there is no formula
};

/// For the cell's pair, function, method, beta, N, n, k and c; the measured members are not read.
Expectation expectation(const Cell& cell);

/// Integral of h over [0, 1] for h smooth between `breaks` (sorted, with 0 and 1), with integrable
/// singularities at the breaks at most. Relative error about 1e-9.
double integrate(const std::vector<double>& breaks, const std::function<double(double)>& h);

}  // namespace app::lab
