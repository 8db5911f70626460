// Principal component analysis of a cluster's rows (Leonhardt & Bohn, eqs. 7-9).
#pragma once

#include "base/types.h"

namespace prt {

/// rows ≈ coefficients · basis + mean.
struct PrincipalComponents {
  VectorF mean;            ///< d
  MatrixF basis;           ///< k × d, orthonormal rows
  MatrixF coefficients;    ///< n × k
  double energy = 1.0;     ///< share of the centred rows' energy that is kept
  double rms_error = 0.0;  ///< root mean square of rows − approximation, in the rows' unit
  double defect = 0.0;     ///< orthonormality defect of the float basis
};

/// rows: n × d. At most `most` components, fewer where the rest has no energy (rank-deficient,
/// constant or single rows: k may be 0) or where the energy left out is at most tolerance².
PrincipalComponents principal_components(const MatrixF& rows, int most, double tolerance = 0.0);

}  // namespace prt
