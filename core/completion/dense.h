// Dense matrices of double and what completion needs of linear algebra: no more, and no faster than
// that takes.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/base/pcg32.h"

namespace core::many_lights {

/// Stored by column.
class Matrix {
public:
    Matrix() = default;
    Matrix(size_t rows, size_t columns) : rows_(rows), columns_(columns), values_(rows * columns) {}

    size_t rows() const { return rows_; }
    size_t columns() const { return columns_; }
    std::span<double> column(size_t j) { return {values_.data() + j * rows_, rows_}; }
    std::span<const double> column(size_t j) const { return {values_.data() + j * rows_, rows_}; }
    double& operator()(size_t i, size_t j) { return values_[j * rows_ + i]; }
    double operator()(size_t i, size_t j) const { return values_[j * rows_ + i]; }
    std::span<double> values() { return values_; }
    std::span<const double> values() const { return values_; }

private:
    size_t rows_ = 0, columns_ = 0;
    std::vector<double> values_;
};

Matrix transposed(const Matrix& a);
Matrix product(const Matrix& a, const Matrix& b);
/// a^T b.
Matrix innerProducts(const Matrix& a, const Matrix& b);
double frobeniusNorm(const Matrix& a);

/// Orthonormal columns that span those of a tall matrix; zero where one is a combination of others.
Matrix orthonormalized(Matrix a);

/// A = U diag(s) V^T with orthonormal columns of U and V, s descending. Columns of U that belong to
/// s = 0 are zero.
struct Svd {
    Matrix u;
    std::vector<double> s;
    Matrix v;
};

/// All singular values, by one-sided Jacobi rotations (M. Hestenes, "Inversion of Matrices by
/// Biorthogonalization and Related Results", 1958).
Svd svd(const Matrix& a);

/// The pseudo-inverse; singular values up to `cutoff` count as zero. By elimination where columns
/// are clearly independent, which is twenty times as fast as by singular values.
Matrix pseudoInverse(const Matrix& a, double cutoff);

}  // namespace core::many_lights
