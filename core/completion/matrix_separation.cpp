// See matrix_separation.h.
#include "core/completion/matrix_separation.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace core::many_lights {

namespace {

constexpr double kStall = 0.9;  // the residual falls more slowly than by this factor

/// `directions` with some random columns behind the others.
Matrix widened(const Matrix& directions, size_t columns, Pcg32& random)
{
    Matrix wide(directions.rows(), columns);
    for (double& x : wide.values()) x = random() - 0.5;
    std::ranges::copy(directions.values(), wide.values().begin());
    return wide;
}

}  // namespace

Separation separateByFactors(const Matrix& d, const FactorSettings& settings, Pcg32& random,
                             const std::stop_token& stop)
{
    const size_t rows = d.rows(), columns = d.columns(), most = std::min(rows, columns);
    Separation result{{Matrix(rows, columns), 0, 0, 0}, Matrix(rows, columns)};
    const double norm = frobeniusNorm(d);
    if (!(norm > 0)) return result;
    const double threshold = norm / settings.penalty;
    LowRank& low = result.low;
    low.rank = std::clamp<size_t>(settings.rank > 0 ? settings.rank : most / 20, 1, most);
    low.residual = 1;

    Matrix multipliers(rows, columns);  // over the penalty
    Matrix work = d;                    // what the factors are to hold
    Matrix right = widened(Matrix(columns, 0), low.rank, random);
    while (low.iterations < settings.iterations && !stop.stop_requested()) {
        Matrix left = product(work, right);
        if (stop.stop_requested()) break;
        left = orthonormalized(std::move(left));
        if (stop.stop_requested()) break;
        const Matrix factor = innerProducts(left, work);
        if (stop.stop_requested()) break;
        low.matrix = product(left, factor);
        double squares = 0;
        for (size_t k = 0; k < d.values().size(); ++k) {
            const double held = d.values()[k] - low.matrix.values()[k];
            double& multiplier = multipliers.values()[k];
            const double x = held + multiplier;
            multiplier = std::clamp(x, -threshold, threshold);
            const double sparse = x - multiplier;
            result.sparse.values()[k] = sparse;
            work.values()[k] = d.values()[k] - sparse + multiplier;
            squares += (held - sparse) * (held - sparse);
        }
        ++low.iterations;
        const double residual = std::sqrt(squares) / norm;
        const bool stalls = residual > kStall * low.residual;
        low.residual = residual;
        if (residual < settings.tolerance) break;
        right = transposed(factor);
        if (!stalls || low.rank == most) continue;
        low.rank = std::min(low.rank + settings.rankStep, most);
        right = widened(right, low.rank, random);
    }
    return result;
}

}  // namespace core::many_lights
