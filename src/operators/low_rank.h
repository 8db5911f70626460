// Low-rank form of a receiver cluster's transfer (the step beyond Leonhardt & Bohn, §4.4).
#pragma once

#include "base/types.h"

namespace prt {

/// m ≈ left · right.
struct LowRank {
  MatrixF left;   ///< rows × k; columns scaled to a largest magnitude of 1, scale in right
  MatrixF right;  ///< k × cols
  double relative_error = 0.0;  ///< weighted Frobenius norm of the difference over that of m
};

/// The best approximation under row and column weights (both >= 0): minimises
/// ‖diag(√row)·(m − left·right)·diag(col)‖ with at most `most` terms, fewer once the relative error
/// is at most `tolerance`.
LowRank low_rank(const MatrixF& m, const VectorF& row_weights, const VectorF& column_weights,
                 int most, double tolerance);

/// Moves each column's largest magnitude from left to the matching row of right, so that rounding
/// left row by row serves all columns alike.
void balance(MatrixF& left, MatrixF& right);

}  // namespace prt
