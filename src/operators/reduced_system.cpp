#include "operators/reduced_system.h"

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/LU>
#include <Eigen/SparseCore>

#include "base/error.h"

namespace prt {

namespace {

constexpr Eigen::Index kLargestDense = 5000;
constexpr double kMostResidual = 1e-6;

MatrixD solve_sparse(const MatrixD& system, const MatrixD& b) {
  const Eigen::SparseMatrix<double, Eigen::RowMajor> sparse = system.sparseView();
  Eigen::BiCGSTAB<Eigen::SparseMatrix<double, Eigen::RowMajor>> solver(sparse);
  solver.setTolerance(0.1 * kMostResidual);
  MatrixD x(b.rows(), b.cols());
  for (Eigen::Index c = 0; c < b.cols(); ++c) x.col(c) = solver.solve(VectorD(b.col(c)));
  return x;
}

}  // namespace

ReducedSolution solve_reduced(const MatrixD& r, const MatrixD& b, int bounces) {
  ReducedSolution solution;
  if (bounces >= 0) {
    solution.x = b;
    for (int i = 0; i < bounces; ++i) solution.x = (b + r * solution.x).eval();
    return solution;
  }
  const MatrixD system = MatrixD::Identity(r.rows(), r.cols()) - r;
  if (system.rows() > kLargestDense) {
    solution.x = solve_sparse(system, b);
  } else {
    solution.x = Eigen::PartialPivLU<Eigen::MatrixXd>(system).solve(Eigen::MatrixXd(b));
  }
  const double norm = b.norm();
  solution.residual = norm > 0.0 ? (system * solution.x - b).norm() / norm : 0.0;
  if (!solution.x.allFinite() || !(solution.residual <= kMostResidual)) {
    throw UnsoundData(
        "the reduced transport system has no sound solution: some albedo is too near 1 in a "
        "closed scene; lower it or set transport.bounces");
  }
  return solution;
}

}  // namespace prt
