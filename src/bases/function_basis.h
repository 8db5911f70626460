// Bases of functions on a cluster's samples from example functions: snapshots of gathered light for
// the reduced transport system.
#pragma once

#include "base/types.h"

namespace prt {

/// Functions orthonormal under area weights: functions·diag(area)·functionsᵀ = I.
struct FunctionBasis {
  MatrixF functions;        ///< k × n
  VectorF coefficient_rms;  ///< k: root mean square coefficient over the examples
  double energy = 1.0;      ///< share of the examples' area-weighted energy that is kept
  double error = 0.0;       ///< √(1 − energy): relative error on the examples themselves
  double defect = 0.0;      ///< orthonormality defect in float
};

/// examples: m × n values on n samples with areas > 0. Deviates from the paper, whose eq. 10
/// subtracts the mean and so loses the mean's own light: the rows stay uncentred, which keeps the
/// map linear, and the constant is the first function, so that the integral over the cluster is
/// kept exactly. At most `most` >= 1 functions, fewer once the energy left out is at most
/// tolerance² of the whole.
FunctionBasis make_function_basis(const MatrixF& examples, const VectorF& areas, int most,
                                  double tolerance = 0.0);

}  // namespace prt
