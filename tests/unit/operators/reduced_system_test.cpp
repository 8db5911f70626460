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

TEST(ReducedSystem, LightThatIsNeverLostIsRefused) {
  // Two surfaces that hand all light to each other: I − R is exactly singular.
  MatrixD r(2, 2);
  r << 0.0, 1.0, 1.0, 0.0;
  EXPECT_THROW((void)solve_reduced(r, MatrixD::Ones(2, 1), -1), UnsoundData);
  EXPECT_NO_THROW((void)solve_reduced(r, MatrixD::Ones(2, 1), 5));
}

TEST(ReducedSystem, NothingStaysNothing) {
  const ReducedSolution solution = solve_reduced(transport(5, 0.5, 7), MatrixD::Zero(5, 2), -1);
  EXPECT_EQ(solution.x.norm(), 0.0);
  EXPECT_EQ(solution.residual, 0.0);
  EXPECT_EQ(solve_reduced(MatrixD(0, 0), MatrixD(0, 3), -1).x.cols(), 3);
}

}  // namespace
}  // namespace prt
