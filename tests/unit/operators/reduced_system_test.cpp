#include "operators/reduced_system.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "support/random_matrix.h"

namespace prt {
namespace {

using test::random_matrix;

// Double precision through a few dozen products.
constexpr double kDouble = 1e-11;

/// Non-negative, every row sums to `albedo`: what light transport in a closed room looks like.
MatrixD transport(Eigen::Index n, double albedo, std::uint64_t stream) {
  MatrixD r = random_matrix(n, n, stream).cwiseAbs();
  for (Eigen::Index i = 0; i < n; ++i) r.row(i) *= albedo / r.row(i).sum();
  return r;
}

TEST(ReducedSystem, AllBouncesAreTheNeumannSeries) {
  for (const double albedo : {0.0, 0.5, 0.95}) {
    const MatrixD r = transport(30, albedo, 1);
    const MatrixD b = random_matrix(30, 4, 2);
    MatrixD sum = b;
    MatrixD term = b;
    for (int i = 0; i < 800; ++i) {  // 0.95^800 is 1e-18
      term = (r * term).eval();
      sum += term;
    }
    const ReducedSolution solution = solve_reduced(r, b, -1);
    EXPECT_LT((solution.x - sum).norm(), 100 * kDouble * sum.norm()) << albedo;
    EXPECT_LT(solution.residual, kDouble);
  }
}

TEST(ReducedSystem, NBouncesAreThePartialSum) {
  const MatrixD r = transport(30, 0.8, 3);
  const MatrixD b = random_matrix(30, 4, 4);
  MatrixD sum = b;
  MatrixD term = b;
  EXPECT_EQ(solve_reduced(r, b, 0).x, b);
  for (int bounces = 1; bounces <= 5; ++bounces) {
    term = (r * term).eval();
    sum += term;
    EXPECT_LT((solve_reduced(r, b, bounces).x - sum).norm(), kDouble * sum.norm()) << bounces;
  }
}

TEST(ReducedSystem, AConstantGainsOneOverOneMinusAlbedo) {
  const ReducedSolution solution =
      solve_reduced(transport(50, 0.75, 5), MatrixD::Constant(50, 1, 2.0), -1);
  EXPECT_LT((solution.x.array() - 8.0).abs().maxCoeff(), 1e3 * kDouble);
}

TEST(ReducedSystem, IterationFindsWhatLuFinds) {
  // More columns than go together, one of them dark and one solved by the first guess.
  MatrixD b = random_matrix(60, 300, 8);
  b.col(7).setZero();
  MatrixD r = transport(60, 0.9, 9);
  r.row(5).setZero();
  b.col(11).setZero();
  b(5, 11) = 1.0;
  r.col(5).setZero();
  const MatrixD exact = solve_reduced(r, b, -1).x;
  const IterativeSolution found = solve_by_iteration(r, b, 1e-10, 500);
  for (Eigen::Index c = 0; c < b.cols(); ++c) {
    // Residual 1e-10, and light gains at most 1 / (1 − 0.9) on its way.
    EXPECT_LE((found.x - exact).col(c).norm(), 1e-9 * 10 * b.col(c).norm()) << c;
  }
  EXPECT_GT(found.products, 0);
}

TEST(ReducedSystem, IterationTakesFewProductsWhereTheSeriesWouldTakeThousands) {
  // Two rooms, joined by a pinhole, that lose a thousandth per bounce: the series loses as little
  // per product.
  const Eigen::Index n = 60;
  MatrixD r = MatrixD::Zero(2 * n, 2 * n);
  r.topLeftCorner(n, n) = transport(n, 0.9989, 21);
  r.bottomRightCorner(n, n) = transport(n, 0.9989, 22);
  r(0, n) += 1e-4;
  r(n, 0) += 1e-4;
  const MatrixD b = random_matrix(2 * n, 20, 23);
  const IterativeSolution found = solve_by_iteration(r, b, 1e-8, 500);
  EXPECT_LT((found.x - r * found.x - b).norm(), 1e-7 * b.norm());
  EXPECT_LT(found.products, 100);
}

TEST(ReducedSystem, IterationThatMayNotGoOnStops) {
  const MatrixD b = random_matrix(60, 2, 24);
  EXPECT_EQ(solve_by_iteration(transport(60, 0.99, 25), b, 0.0, 3).products, 6);
}

TEST(ReducedSystem, LightThatIsNeverLostIsRefused) {
  // Two surfaces that hand all light to each other: I − R is exactly singular.
  MatrixD r(2, 2);
  r << 0.0, 1.0, 1.0, 0.0;
  EXPECT_THROW((void)solve_reduced(r, MatrixD::Ones(2, 1), -1), UnsoundData);
  EXPECT_NO_THROW((void)solve_reduced(r, MatrixD::Ones(2, 1), 5));
  // Nor is light that only rounding and leaking rays take away.
  EXPECT_THROW((void)solve_reduced(transport(30, 0.99995, 26), MatrixD::Ones(30, 1), -1),
               UnsoundData);
  EXPECT_NO_THROW((void)solve_reduced(transport(30, 0.9995, 27), MatrixD::Ones(30, 1), -1));
}

TEST(ReducedSystem, NothingStaysNothing) {
  const ReducedSolution solution = solve_reduced(transport(5, 0.5, 7), MatrixD::Zero(5, 2), -1);
  EXPECT_EQ(solution.x.norm(), 0.0);
  EXPECT_EQ(solution.residual, 0.0);
  EXPECT_EQ(solve_reduced(MatrixD(0, 0), MatrixD(0, 3), -1).x.cols(), 3);
}

}  // namespace
}  // namespace prt
