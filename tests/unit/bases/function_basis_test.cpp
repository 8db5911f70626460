#include "bases/function_basis.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/random_matrix.h"

namespace prt {
namespace {

using test::falling_matrix;
using test::random_areas;

// Functions are stored in float: sums over a few hundred samples round to about this.
constexpr double kFloat = 1e-5;

MatrixF light_rows(Eigen::Index lights, Eigen::Index samples) {
  // All positive, as irradiance is, with a falling spectrum.
  const MatrixD m = falling_matrix(lights, samples, 40, 0.8, 1);
  return (m.array() + m.cwiseAbs().maxCoeff()).matrix().cast<float>();
}

MatrixD gram(const FunctionBasis& basis, const VectorF& areas) {
  const MatrixD f = basis.functions.cast<double>();
  return f * areas.cast<double>().asDiagonal() * f.transpose();
}

/// Relative area-weighted error of the examples' projections, measured from scratch.
double measured_error(const FunctionBasis& basis, const MatrixF& examples, const VectorF& areas) {
  const MatrixD f = basis.functions.cast<double>();
  const MatrixD e = examples.cast<double>();
  const MatrixD left = e - e * areas.cast<double>().asDiagonal() * f.transpose() * f;
  const VectorD root = areas.cast<double>().cwiseSqrt();
  return (left * root.asDiagonal()).norm() / (e * root.asDiagonal()).norm();
}

TEST(FunctionBasis, IsOrthonormalUnderAreas) {
  for (const auto& [lights, samples] : {std::pair{300, 150}, {100, 400}}) {
    const VectorF areas = random_areas(samples, 2);
    const FunctionBasis basis = make_function_basis(light_rows(lights, samples), areas, 10);
    ASSERT_EQ(basis.functions.rows(), 10);
    EXPECT_LT((gram(basis, areas) - MatrixD::Identity(10, 10)).cwiseAbs().maxCoeff(), kFloat);
    EXPECT_LT(basis.defect, kFloat);
  }
}

TEST(FunctionBasis, BeginsWithTheConstant) {
  const VectorF areas = random_areas(200, 3);
  for (const int most : {1, 2, 10}) {
    const FunctionBasis basis = make_function_basis(light_rows(100, 200), areas, most);
    const float expected = 1.0F / std::sqrt(areas.sum());
    for (Eigen::Index s = 0; s < 200; ++s) {
      ASSERT_NEAR(basis.functions(0, s), expected, kFloat * expected);
    }
    // So the integral over the cluster survives projection.
    const MatrixF e = light_rows(100, 200);
    const MatrixD f = basis.functions.cast<double>();
    const VectorD a = areas.cast<double>();
    const MatrixD again = e.cast<double>() * a.asDiagonal() * f.transpose() * f;
    const VectorD integral = e.cast<double>() * a;
    EXPECT_LT((again * a - integral).cwiseAbs().maxCoeff(),
              kFloat * integral.cwiseAbs().maxCoeff());
  }
}

TEST(FunctionBasis, MeasuresItsErrorAndItFallsWithRank) {
  const VectorF areas = random_areas(200, 4);
  const MatrixF examples = light_rows(300, 200);
  double last = 1.0;
  for (const int most : {1, 2, 4, 8, 16}) {
    const FunctionBasis basis = make_function_basis(examples, areas, most);
    EXPECT_NEAR(basis.error, measured_error(basis, examples, areas), kFloat);
    EXPECT_NEAR(basis.energy, 1.0 - basis.error * basis.error, kFloat);
    EXPECT_LT(basis.error, last);
    last = basis.error;
  }
}

TEST(FunctionBasis, GivesTheRootMeanSquareOfCoefficients) {
  const VectorF areas = random_areas(200, 5);
  const MatrixF examples = light_rows(300, 200);
  const FunctionBasis basis = make_function_basis(examples, areas, 6);
  const MatrixF coefficients = basis.functions * areas.asDiagonal() * examples.transpose();
  for (Eigen::Index k = 0; k < 6; ++k) {
    const float rms = coefficients.row(k).norm() / std::sqrt(300.0F);
    EXPECT_NEAR(basis.coefficient_rms[k], rms, 1e-4F * basis.coefficient_rms[0]);
  }
}

TEST(FunctionBasis, StopsAtTheTolerance) {
  const VectorF areas = random_areas(200, 6);
  const MatrixF examples = light_rows(300, 200);
  for (const double tolerance : {0.1, 0.01}) {
    const FunctionBasis basis = make_function_basis(examples, areas, 50, tolerance);
    EXPECT_LE(basis.error, tolerance * (1.0 + 1e-6));
    ASSERT_GT(basis.functions.rows(), 1);
    const auto fewer = static_cast<int>(basis.functions.rows() - 1);
    EXPECT_GT(make_function_basis(examples, areas, fewer).error, tolerance);
  }
}

TEST(FunctionBasis, IsSoundWithoutLightAndOnOneSample) {
  const FunctionBasis dark = make_function_basis(MatrixF::Zero(20, 30), random_areas(30, 7), 8);
  EXPECT_EQ(dark.functions.rows(), 1);
  EXPECT_EQ(dark.error, 0.0);
  EXPECT_EQ(dark.coefficient_rms[0], 0.0F);
  const FunctionBasis one = make_function_basis(light_rows(20, 1), random_areas(1, 8), 8);
  EXPECT_EQ(one.functions.rows(), 1);
  EXPECT_NEAR(one.error, 0.0, kFloat);
  const FunctionBasis even =
      make_function_basis(MatrixF::Constant(20, 30, 2.5F), random_areas(30, 9), 8);
  EXPECT_NEAR(even.error, 0.0, kFloat);
  EXPECT_TRUE(even.functions.allFinite());
  EXPECT_LT(even.defect, kFloat);
}

}  // namespace
}  // namespace prt
