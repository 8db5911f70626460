// Low-rank form of a receiver cluster's transfer (the step beyond Leonhardt & Bohn, §4.4).
#pragma once

#include "base/types.h"

namespace prt {

/// m ≈ left · right.
struct LowRank {
  MatrixF left;   ///< rows × k; columns scaled to a largest magnitude of 1, scale in right
  MatrixF right;  ///< k × cols
  double relative_error = 0.0;  ///< of the fields, weighted Frobenius norm
};

/// m ≈ left · right, where left spans best what is typical: `fields` are columns m·x for typical x,
/// and left minimises ‖diag(√row_weights)·(fields − left·leftᵀ·fields)‖ with at most `most`
/// columns, fewer once the relative error is at most `tolerance`; right is the weighted projection
/// of all of m, so that any other x is served too.
LowRank low_rank(const MatrixF& m, const VectorF& row_weights, const MatrixF& fields, int most,
                 double tolerance);

/// Moves each column's largest magnitude from left to the matching row of right, so that rounding
/// left row by row serves all columns alike.
void balance(MatrixF& left, MatrixF& right);

}  // namespace prt
