#include "operators/low_rank.h"

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <cmath>

#include "support/random_matrix.h"

namespace prt {
namespace {

using test::falling_matrix;
using test::random_areas;
using test::random_matrix;

// Factors are float: relative error of products of a few dozen terms.
constexpr double kFloat = 1e-5;

/// m ≈ left·right by the factor's functions.
struct LowRank {
  MatrixF left, right;
  double relative_error;
};
LowRank low_rank(const MatrixF& m, const VectorF& weights, const MatrixF& fields, int most,
                 double tolerance) {
  const LeftFactor factor = left_factor(fields, weights, most, tolerance);
  return {factor.functions, factor.dual * m, factor.relative_error};
}

double weighted_error(const LowRank& low, const MatrixF& m, const MatrixF& fields,
                      const MatrixF& inputs, const VectorF& weights) {
  const VectorD root = weights.cast<double>().cwiseSqrt();
  const MatrixD exact = fields.cast<double>();
  const MatrixD again =
      low.left.cast<double>() * (low.right.cast<double>() * inputs.cast<double>());
  EXPECT_EQ(low.right.cols(), m.cols());
  return (root.asDiagonal() * (again - exact)).norm() / (root.asDiagonal() * exact).norm();
}

TEST(LowRank, ErrorIsThatOfTheOptimalDecomposition) {
  const MatrixF m = falling_matrix(80, 120, 60, 0.85, 1).cast<float>();
  const MatrixF inputs = random_matrix(120, 90, 3).cast<float>();
  const MatrixF fields = m * inputs;
  const VectorF weights = random_areas(80, 4);
  const MatrixD weighted = weights.cast<double>().cwiseSqrt().asDiagonal() * fields.cast<double>();
  const VectorD values =
      Eigen::JacobiSVD<Eigen::MatrixXd>(Eigen::MatrixXd(weighted)).singularValues();
  for (const int most : {1, 5, 20}) {
    const LowRank low = low_rank(m, weights, fields, most, 0.0);
    ASSERT_EQ(low.left.cols(), most);
    const double optimal =
        std::sqrt(values.tail(values.size() - most).squaredNorm() / values.squaredNorm());
    EXPECT_NEAR(low.relative_error, optimal, kFloat);
    EXPECT_NEAR(weighted_error(low, m, fields, inputs, weights), optimal, kFloat);
  }
}

TEST(LowRank, StopsAtTheToleranceAndKeepsIt) {
  const MatrixF m = falling_matrix(80, 120, 60, 0.8, 5).cast<float>();
  const MatrixF inputs = random_matrix(120, 90, 7).cast<float>();
  const MatrixF fields = m * inputs;
  const VectorF weights = random_areas(80, 8);
  const LowRank low = low_rank(m, weights, fields, 80, 0.01);
  EXPECT_LE(weighted_error(low, m, fields, inputs, weights), 0.01 + kFloat);
  const auto fewer = static_cast<int>(low.left.cols()) - 1;
  ASSERT_GT(fewer, 0);
  EXPECT_GT(low_rank(m, weights, fields, fewer, 0.0).relative_error, 0.01);
}

TEST(LowRank, ServesInputsItWasNotTunedOn) {
  // Fields of few inputs, but of full range: the rest of m is projected, not forgotten.
  const MatrixF m = falling_matrix(40, 100, 6, 0.9, 9).cast<float>();
  const MatrixF tuned = random_matrix(100, 12, 11).cast<float>();
  const VectorF weights = random_areas(40, 12);
  const LowRank low = low_rank(m, weights, m * tuned, 40, 1e-6);
  const MatrixF others = random_matrix(100, 12, 13).cast<float>();
  EXPECT_LT(weighted_error(low, m, m * others, others, weights), kFloat);
}

TEST(LowRank, FunctionsAreOrthonormalUnderTheWeights) {
  const MatrixF m = falling_matrix(40, 60, 30, 0.7, 14).cast<float>();
  const LeftFactor factor = left_factor(m, random_areas(40, 15), 8, 0.0);
  const MatrixF gram = factor.dual * factor.functions;
  ASSERT_EQ(gram.rows(), 8);
  EXPECT_LT((gram - MatrixF::Identity(8, 8)).cwiseAbs().maxCoeff(), kFloat);
}

TEST(LowRank, OfNothingIsEmptyAndRight) {
  const LowRank dark =
      low_rank(MatrixF::Zero(7, 9), random_areas(7, 16), MatrixF::Zero(7, 3), 5, 1e-2);
  EXPECT_EQ(dark.left.cols(), 0);
  EXPECT_EQ(dark.left.rows(), 7);
  EXPECT_EQ(dark.right.cols(), 9);
  EXPECT_EQ(dark.relative_error, 0.0);
}

TEST(Balance, LeavesTheProductAlone) {
  MatrixF left = random_matrix(20, 4, 17).cast<float>();
  left.col(1) *= 1e-6F;
  left.col(3).setZero();
  MatrixF right = random_matrix(4, 10, 18).cast<float>();
  const MatrixF before = left * right;
  balance(left, right);
  EXPECT_LT((left * right - before).cwiseAbs().maxCoeff(), 1e-6F);  // a few float roundings
  EXPECT_FLOAT_EQ(left.col(1).cwiseAbs().maxCoeff(), 1.0F);
  EXPECT_EQ(left.col(3).cwiseAbs().maxCoeff(), 0.0F);
}

}  // namespace
}  // namespace prt
