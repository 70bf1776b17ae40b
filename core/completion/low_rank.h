// Matrices of low rank from part of their entries: singular value thresholding (J.-F. Cai, E.
// Candes, Z. Shen, "A Singular Value Thresholding Algorithm for Matrix Completion", 2010).
#pragma once

#include <stop_token>

#include "core/completion/bit_matrix.h"
#include "core/completion/dense.h"

namespace core::many_lights {

/// The k largest singular values and their vectors, nearly: N. Halko, P.-G. Martinsson, J. Tropp,
/// "Finding Structure with Randomness" (2011), with ten more columns and two power iterations. The
/// columns of `start`, right vectors of a similar matrix, are taken before random directions.
Svd randomizedSvd(const Matrix& a, size_t k, Pcg32& random, const Matrix& start = {});

/// All singular values above `least`, and their vectors; `guess` of them are expected.
Svd singularValuesAbove(const Matrix& a, double least, size_t guess, Pcg32& random,
                        const Matrix& start = {});

struct SvtSettings {
    double tau = 0;  // what singular values lose; 0: 5 sqrt(rows columns)
    /// Step; 0: 1.2 times the inverse of the share of known entries. It is halved, down to 1.9,
    /// where the residual grows.
    double delta = 0;
    uint32_t iterations = 500;
    double tolerance = 1e-4;  // relative error in the known entries
};

struct LowRank {
    Matrix matrix;
    size_t rank = 0;
    uint32_t iterations = 0;
    double residual = 0;  // relative error at the end
};

/// The matrix of small nuclear norm that agrees with `values` where `known` is set; what
/// `values` holds elsewhere does not count. Ends early, with what there is, when `stop` is
/// requested.
LowRank completeLowRank(const Matrix& values, const BitMatrix& known, const SvtSettings& settings,
                        Pcg32& random, const std::stop_token& stop = {});

}  // namespace core::many_lights
