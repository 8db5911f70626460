// The reduced transport system of POD–Galerkin: all bounces at the cost of one small solve.
#pragma once

#include "base/types.h"

namespace prt {

struct ReducedSolution {
  MatrixD x;              ///< n × m
  double residual = 0.0;  ///< ‖(I − R)x − b‖_F / ‖b‖_F; 0 for b = 0
};

/// Solves (I − R) x = b for an operator R with norm below 1: R n × n, b n × m. `bounces` < 0: all
/// of them, by LU up to 12,000 unknowns (some 4 GB) and by iteration above; else x = b + R b + … +
/// R^(bounces) b. Throws UnsoundData where the solution is not finite, the residual stays above
/// 1e-6 or x is over 10,000 times b: the albedo is too near 1 for light ever to be lost.
ReducedSolution solve_reduced(const MatrixD& r, const MatrixD& b, int bounces);

/// What iterating took.
struct IterativeSolution {
  MatrixD x;
  int products = 0;  ///< multiplications by R of the column that needed the most
};

/// The same for all bounces by BiCGSTAB (van der Vorst 1992), all columns at once: a product with R
/// is one matrix product. Stops where every column's residual is at most `tolerance` of its b, or
/// after `most` iterations.
IterativeSolution solve_by_iteration(const MatrixD& r, const MatrixD& b, double tolerance,
                                     int most);

}  // namespace prt
