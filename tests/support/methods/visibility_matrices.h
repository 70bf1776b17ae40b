// Synthetic visibility: matrices of known structure, and an oracle that answers from a matrix and
// watches how it is asked.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/pcg32.h"
#include "core/completion/bits.h"
#include "core/completion/completion.h"

namespace tests {

using core::many_lights::BitMatrix;

/// Answers from `truth`. Adds a failure to the running test when a row is asked for twice, or one
/// that does not exist or does not matter.
class MatrixOracle : public core::many_lights::VisibilityOracle {
public:
    explicit MatrixOracle(const BitMatrix& truth)
        : truth_(truth), asked_(truth.rows(), truth.columns())
    {}
    MatrixOracle(const BitMatrix& truth, const BitMatrix& matters)
        : truth_(truth), matters_(&matters), asked_(truth.rows(), truth.columns())
    {}

    void trace(std::span<const core::many_lights::TraceRequest> requests) override;
    const uint64_t* matters(uint32_t column) const override;

    uint64_t rays() const { return rays_; }
    uint64_t calls() const { return calls_; }
    /// The rows that were asked for, column by column.
    const BitMatrix& asked() const { return asked_; }

private:
    const BitMatrix& truth_;
    const BitMatrix* matters_ = nullptr;
    BitMatrix asked_;
    uint64_t rays_ = 0, calls_ = 0;
};

/// Column 1 is so many times as bright as the mean.
class BrightOracle : public MatrixOracle {
public:
    BrightOracle(const BitMatrix& truth, float brightness)
        : MatrixOracle(truth), brightness_(brightness)
    {}
    std::optional<float> brightness(uint32_t column) const override
    {
        return column == 1 ? brightness_ : 1;
    }

private:
    float brightness_;
};

/// Rows, each of them with probability p.
core::many_lights::Words randomRows(uint32_t rows, double p, core::Pcg32& random);

/// Every bit set with probability p.
BitMatrix randomMatrix(uint32_t rows, uint32_t columns, double p, core::Pcg32& random);

/// Random columns of a dictionary of `distinct` random columns, half of them complemented. The
/// first columns are the dictionary; the order is shuffled.
BitMatrix dictionaryMatrix(uint32_t rows, uint32_t columns, uint32_t distinct, core::Pcg32& random);

/// A thousand by a thousand, of ten columns.
inline BitMatrix tenColumns(core::Pcg32& random)
{
    return dictionaryMatrix(1000, 1000, 10, random);
}

/// Random sums over GF(2) of `rank` random columns.
BitMatrix sumsMatrix(uint32_t rows, uint32_t columns, uint32_t rank, core::Pcg32& random);

/// Column j is lit above a threshold t_j uniform in 0..rows: the shadow of one edge.
BitMatrix edgesMatrix(uint32_t rows, uint32_t columns, core::Pcg32& random);

/// A room of unit height: `side` x `side` receivers in scan-line order on a patch of the floor of
/// edge `patch`, lights on the ceiling, spheres between them.
BitMatrix spheresMatrix(uint32_t side, uint32_t columns, uint32_t spheres, double radius,
                        double patch, core::Pcg32& random);

/// Leaves: every column has its own runs of lit and dark rows, of mean length `run`.
BitMatrix foliageMatrix(uint32_t rows, uint32_t columns, double run, core::Pcg32& random);

/// Where receivers and lights face each other: column j is 1 on a half of the rows that moves with
/// j.
BitMatrix facingMask(uint32_t rows, uint32_t columns, double share, core::Pcg32& random);

/// Wrong bits where visibility matters, as a share of these bits. `matters` null: everywhere.
double bitError(const BitMatrix& truth, const BitMatrix& found, const BitMatrix* matters = nullptr);

/// Columns that differ from each other and from each other's complement.
uint32_t distinctColumns(const BitMatrix& matrix);

}  // namespace tests
