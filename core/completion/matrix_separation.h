// A matrix as one of low rank, kept as two factors, and one that is sparse: Y. Shen, Z. Wen, Y.
// Zhang, "Augmented Lagrangian Alternating Direction Method for Matrix Separation Based on Low-Rank
// Factorization" (2014). No singular values, so that each step costs three thin products. What
// differs: the rank begins low and grows where the residual stalls. That rule does not know where
// to end: where what is sparse exceeds the tolerance, the rank may pass the true one, and the
// factors then hold what is sparse, too (measured: rank 10 with 5 % of the entries off is recovered
// from a guess of 10, and not from 5 or 20).
#pragma once

#include <stop_token>

#include "core/completion/low_rank.h"

namespace core::many_lights {

struct FactorSettings {
    size_t rank = 0;      // to begin with; 0: a twentieth of the largest that there is
    size_t rankStep = 5;  // what it grows by
    uint32_t iterations = 40;
    double tolerance = 0.01;  // of what neither part holds, over the Frobenius norm of the matrix
    double penalty = 500;     // over that norm: entries above its inverse begin as sparse
};

/// D = L + S, L of low rank and S sparse.
struct Separation {
    LowRank low;
    Matrix sparse;
};

/// D = L + S up to the residual of `low`. Ends early, with what there is, when `stop` is requested.
Separation separateByFactors(const Matrix& d, const FactorSettings& settings, Pcg32& random,
                             const std::stop_token& stop = {});

}  // namespace core::many_lights
