// The reduced transport system of POD–Galerkin: all bounces at the cost of one small solve.
#pragma once

#include "base/types.h"

namespace prt {

struct ReducedSolution {
  MatrixD x;              ///< n × m
  double residual = 0.0;  ///< ‖(I − R)x − b‖_F / ‖b‖_F; 0 for b = 0
};

/// Solves (I − R) x = b for an operator R with norm below 1: R n × n, b n × m. `bounces` < 0: all
/// of them, by LU up to 5,000 unknowns and by BiCGSTAB above; else x = b + R b + … + R^(bounces) b.
/// Throws UnsoundData where the solution is not finite or the residual stays above 1e-6: the albedo
/// is too near 1 for light ever to be lost.
ReducedSolution solve_reduced(const MatrixD& r, const MatrixD& b, int bounces);

}  // namespace prt
