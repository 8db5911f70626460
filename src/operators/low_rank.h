// Low-rank form of a receiver cluster's transfer (the step beyond Leonhardt & Bohn, §4.4).
#pragma once

#include "base/types.h"

namespace prt {

/// Functions that span fields best: fields ≈ functions·(dual·fields), and transfer m ≈
/// functions·(dual·m).
struct LeftFactor {
  MatrixF functions;            ///< n × k; functionsᵀ·diag(row weights)·functions = I
  MatrixF dual;                 ///< k × n; functionsᵀ·diag(row weights)
  double relative_error = 0.0;  ///< of the fields, weighted Frobenius norm
};

/// Minimises ‖diag(√row_weights)·(fields − functions·dual·fields)‖ over at most `most` functions,
/// fewer once the relative error is at most `tolerance`. fields: n × m, what is typical; anything
/// else is served as well as these functions can.
LeftFactor left_factor(const MatrixF& fields, const VectorF& row_weights, int most,
                       double tolerance);

/// Moves each column's largest magnitude from left to the matching row of right, so that rounding
/// left row by row serves all columns alike.
void balance(MatrixF& left, MatrixF& right);

}  // namespace prt
