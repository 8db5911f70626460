#include "operators/reduced_system.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace prt {

namespace {

// R and its LU of so many unknowns hold 2.3 GB, right-hand sides and solutions up to as much again.
// It takes about n³ · 2/3 flops, iterating some 20 n² per column: with ten light functions to 39
// unknowns LU is the faster one up to far beyond that.
constexpr Eigen::Index kLargestDense = 12000;
constexpr double kMostResidual = 1e-6;
constexpr int kMostIterations = 500;
// Rays that slip through an edge lose some 1e-5 of the light: what comes out of more bounces than
// this tells of them and not of the scene.
constexpr double kMostGain = 1e4;
// Columns iterated together: enough for the speed of matrix products, few enough that their eight
// vectors stay small beside R.
constexpr Eigen::Index kColumns = 256;

VectorD dots(const MatrixD& a, const MatrixD& b) {
  return a.cwiseProduct(b).colwise().sum().transpose();
}

/// a / b, and 0 where a column is solved or its search has broken down.
VectorD quotient(const VectorD& a, const VectorD& b) {
  return a.binaryExpr(b, [](double x, double y) {
    const double q = x / y;
    return std::isfinite(q) ? q : 0.0;
  });
}

/// One block of columns.
IterativeSolution iterate(const MatrixD& r, const MatrixD& b, double tolerance, int most) {
  const auto apply = [&](const MatrixD& v) { return MatrixD(v - r * v); };
  IterativeSolution out{b, 0};  // light after its first bounce is a good guess
  MatrixD residual = b - apply(out.x);
  MatrixD shadow = residual;
  MatrixD p = residual;
  VectorD rho = dots(shadow, residual);
  const VectorD goal = tolerance * b.colwise().norm().transpose();
  for (int i = 0; i < most; ++i) {
    // 1 where a column still needs work; the others stay as they are.
    const VectorD active =
        (residual.colwise().norm().transpose().array() > goal.array()).cast<double>().matrix();
    if (active.isZero(0.0)) break;
    const MatrixD v = apply(p);
    const VectorD alpha = quotient(rho, dots(shadow, v)).cwiseProduct(active);
    const MatrixD s = residual - v * alpha.asDiagonal();
    const MatrixD t = apply(s);
    const VectorD omega = quotient(dots(t, s), dots(t, t)).cwiseProduct(active);
    out.x += p * alpha.asDiagonal() + s * omega.asDiagonal();
    residual = s - t * omega.asDiagonal();
    out.products += 2;
    const VectorD next = dots(shadow, residual);
    const VectorD beta = quotient(next, rho).cwiseProduct(quotient(alpha, omega));
    p = (residual + (p - v * omega.asDiagonal()) * beta.asDiagonal()).eval();
    rho = next;
  }
  return out;
}

/// LU in place: a second copy of a big system would be most of the memory of a rank.
MatrixD solve_dense(const MatrixD& r, const MatrixD& b) {
  Eigen::MatrixXd system = -r;
  system.diagonal().array() += 1.0;
  const Eigen::PartialPivLU<Eigen::Ref<Eigen::MatrixXd>> lu(system);
  return lu.solve(Eigen::MatrixXd(b));
}

}  // namespace

IterativeSolution solve_by_iteration(const MatrixD& r, const MatrixD& b, double tolerance,
                                     int most) {
  IterativeSolution all{MatrixD(b.rows(), b.cols()), 0};
  for (Eigen::Index first = 0; first < b.cols(); first += kColumns) {
    const Eigen::Index count = std::min(kColumns, b.cols() - first);
    IterativeSolution part = iterate(r, b.middleCols(first, count), tolerance, most);
    all.x.middleCols(first, count) = part.x;
    all.products = std::max(all.products, part.products);
  }
  return all;
}

ReducedSolution solve_reduced(const MatrixD& r, const MatrixD& b, int bounces) {
  ReducedSolution solution;
  if (bounces >= 0) {
    solution.x = b;
    for (int i = 0; i < bounces; ++i) solution.x = (b + r * solution.x).eval();
    return solution;
  }
  solution.x = r.rows() > kLargestDense
                   ? solve_by_iteration(r, b, 0.1 * kMostResidual, kMostIterations).x
                   : solve_dense(r, b);
  const double norm = b.norm();
  solution.residual = norm > 0.0 ? (solution.x - r * solution.x - b).norm() / norm : 0.0;
  if (!solution.x.allFinite() || !(solution.residual <= kMostResidual) ||
      !(solution.x.norm() <= kMostGain * norm)) {
    throw UnsoundData(
        "light is as good as never lost: some albedo is too near 1 in a closed space; lower it or "
        "set transport.bounces");
  }
  return solution;
}

}  // namespace prt
