// Leading singular vectors of the tall and wide matrices that clusters give, safe for
// rank-deficient, zero and tiny ones.
#pragma once

#include "base/types.h"

namespace prt {

/// Leading right singular vectors of m (rows × d).
struct SingularBasis {
  MatrixD vectors;      ///< k × d, orthonormal rows; k <= rank of m, at most what was asked for
  VectorD values;       ///< k singular values, falling
  double energy = 1.0;  ///< Σ values² / ‖m‖_F²; 1 for a zero matrix
  double defect = 0.0;  ///< largest entry of |vectors·vectorsᵀ − I|
};

/// The `most` leading right singular vectors, fewer where the matrix has lower rank (σ < 1e-7·σ₁
/// counts as zero) or once the energy left out is at most tolerance²·‖m‖². Gram matrix of the
/// shorter side in double, Krylov–Schur for its leading eigenvectors, Householder QR afterwards,
/// since eigenvectors of a Gram matrix lose orthogonality for small σ. Throws UnsoundData if m is
/// not finite.
SingularBasis leading_right_vectors(const MatrixD& m, Eigen::Index most, double tolerance = 0.0);

/// The same for left singular vectors: those of the transpose, as rows (k × rows of m).
SingularBasis leading_left_vectors(const MatrixD& m, Eigen::Index most, double tolerance = 0.0);

/// Largest entry of |rows·rowsᵀ − I|.
double orthonormality_defect(const MatrixD& rows);

}  // namespace prt
