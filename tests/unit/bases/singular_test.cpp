#include "bases/singular.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "support/random_matrix.h"

namespace prt {
namespace {

using test::falling_matrix;
using test::random_matrix;

// What the product promises of its bases.
constexpr double kDefect = 1e-5;
// Singular values come from a Gram matrix: absolute error of σ² is a few roundings of σ₁², and the
// iterative solver stops at 1e-9 of it.
constexpr double kSquaredValue = 1e-8;

VectorD true_values(const MatrixD& m) {
  return Eigen::JacobiSVD<Eigen::MatrixXd>(Eigen::MatrixXd(m)).singularValues();
}

/// The basis must be orthonormal, hold the true singular values, and keep of m what the optimal
/// basis of its size keeps (Eckart and Young): that is what its rows are for.
void expect_optimal(const MatrixD& m, const SingularBasis& basis) {
  const double scale = m.cwiseAbs().maxCoeff();
  const MatrixD a = m / scale;
  const VectorD values = true_values(a);
  const double squared = values.squaredNorm();
  const Eigen::Index k = basis.vectors.rows();
  ASSERT_EQ(basis.vectors.cols(), m.cols());
  ASSERT_EQ(basis.values.size(), k);
  EXPECT_LT(orthonormality_defect(basis.vectors), kDefect);
  EXPECT_LT(basis.defect, kDefect);
  for (Eigen::Index i = 0; i < k; ++i) {
    const double value = basis.values[i] / scale;
    EXPECT_NEAR(value * value, values[i] * values[i], kSquaredValue * squared);
    EXPECT_LE(basis.values[i], basis.values[std::max<Eigen::Index>(0, i - 1)]);
  }
  const double optimal = values.head(k).squaredNorm();
  EXPECT_NEAR(basis.energy, optimal / squared, kSquaredValue);
  EXPECT_NEAR((a * basis.vectors.transpose()).squaredNorm() / squared, optimal / squared,
              kSquaredValue);
}

TEST(SingularVectors, OfRandomMatricesAreOptimal) {
  for (const auto& [rows, cols] : {std::pair{200, 40}, {40, 200}, {60, 60}, {250, 240}}) {
    for (const Eigen::Index most : {1, 5, 30}) {
      const MatrixD m = random_matrix(rows, cols, 1);
      const SingularBasis basis = leading_right_vectors(m, most);
      EXPECT_EQ(basis.vectors.rows(), most);
      expect_optimal(m, basis);
    }
  }
}

// Above 96 unknowns the iterative solver works: a falling spectrum is its usual food.
TEST(SingularVectors, OfFallingSpectraAreOptimal) {
  for (const auto& [rows, cols] : {std::pair{150, 400}, {400, 150}}) {
    const MatrixD m = falling_matrix(rows, cols, 100, 0.9, 3);
    const SingularBasis basis = leading_right_vectors(m, 30);
    EXPECT_EQ(basis.vectors.rows(), 30);
    expect_optimal(m, basis);
  }
}

TEST(SingularVectors, OfDeficientMatricesStopAtTheRank) {
  for (const auto& [rows, cols] : {std::pair{200, 30}, {30, 200}, {150, 300}, {300, 150}}) {
    for (const Eigen::Index rank : {1, 7}) {
      const MatrixD m = falling_matrix(rows, cols, rank, 0.8, 5);
      const SingularBasis basis = leading_right_vectors(m, 25);
      EXPECT_GE(basis.vectors.rows(), rank);
      EXPECT_LT(orthonormality_defect(basis.vectors), kDefect);
      EXPECT_NEAR(basis.energy, 1.0, kSquaredValue);
      const MatrixD again = m * basis.vectors.transpose() * basis.vectors;
      EXPECT_LT((m - again).norm(), 1e-6 * m.norm());
    }
  }
}

/// Singular values 1, 10^-1/2, 10^-1, ... down to 1e-12.
MatrixD steep_matrix(Eigen::Index rows, Eigen::Index cols) {
  constexpr Eigen::Index kValues = 25;
  const auto orthonormal = [](Eigen::Index size, std::uint64_t stream) {
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(random_matrix(size, kValues, stream));
    return Eigen::MatrixXd(qr.householderQ() * Eigen::MatrixXd::Identity(size, kValues));
  };
  Eigen::MatrixXd left = orthonormal(rows, 11);
  for (Eigen::Index i = 0; i < kValues; ++i) left.col(i) *= std::pow(10.0, -0.5 * double(i));
  return left * orthonormal(cols, 12).transpose();
}

// Eigenvectors of a Gram matrix lose orthogonality where σ is small, and below 1e-8 they are noise.
TEST(SingularVectors, OfSteepSpectraStayOrthonormal) {
  for (const auto& [rows, cols] : {std::pair{60, 90}, {90, 60}, {200, 300}, {300, 200}}) {
    const MatrixD m = steep_matrix(rows, cols);
    const SingularBasis basis = leading_right_vectors(m, 25);
    // 10^-6.5 is above the zero of 1e-7, 10^-7.5 below it; 1e-7 itself may fall either way.
    EXPECT_GE(basis.vectors.rows(), 14);
    EXPECT_LE(basis.vectors.rows(), 15);
    EXPECT_LT(orthonormality_defect(basis.vectors), kDefect);
    // What is left out is what counts as zero, and rounding of as much.
    const MatrixD left = m - m * basis.vectors.transpose() * basis.vectors;
    EXPECT_LT(left.norm(), 1e-6 * m.norm());
    for (Eigen::Index i = 1; i < basis.values.size(); ++i) {
      EXPECT_LE(basis.values[i], basis.values[i - 1]);
    }
  }
}

TEST(SingularVectors, OfZeroAndEmptyAreNone) {
  for (const MatrixD& m : {MatrixD(MatrixD::Zero(5, 9)), MatrixD(0, 9), MatrixD(5, 0)}) {
    const SingularBasis basis = leading_right_vectors(m, 4);
    EXPECT_EQ(basis.vectors.rows(), 0);
    EXPECT_EQ(basis.vectors.cols(), m.cols());
    EXPECT_EQ(basis.energy, 1.0);
    EXPECT_EQ(basis.defect, 0.0);
  }
}

TEST(SingularVectors, OfOneRowColumnAndEqualRows) {
  expect_optimal(random_matrix(1, 50, 6), leading_right_vectors(random_matrix(1, 50, 6), 10));
  expect_optimal(random_matrix(50, 1, 6), leading_right_vectors(random_matrix(50, 1, 6), 10));
  for (const auto& [rows, cols] : {std::pair{40, 120}, {120, 40}, {200, 300}}) {
    const MatrixD equal = MatrixD::Constant(rows, cols, 0.3);
    const SingularBasis basis = leading_right_vectors(equal, 10);
    EXPECT_EQ(basis.vectors.rows(), 1);
    expect_optimal(equal, basis);
  }
}

TEST(SingularVectors, DoNotDependOnTheUnit) {
  const MatrixD m = random_matrix(60, 150, 7);
  const SingularBasis plain = leading_right_vectors(m, 12);
  for (const double scale : {1e-20, 1e20, 1e-180, 1e180}) {
    const SingularBasis scaled = leading_right_vectors(scale * m, 12);
    ASSERT_EQ(scaled.vectors.rows(), 12);
    EXPECT_LT(orthonormality_defect(scaled.vectors), kDefect);
    EXPECT_NEAR(scaled.energy, plain.energy, kSquaredValue);
    for (Eigen::Index i = 0; i < 12; ++i) {
      EXPECT_NEAR(scaled.values[i] / scale / plain.values[i], 1.0, 1e-6);
    }
  }
}

TEST(SingularVectors, StopAtTheTolerance) {
  const MatrixD m = falling_matrix(80, 200, 60, 0.8, 8);
  const VectorD values = true_values(m);
  for (const double tolerance : {0.3, 0.05, 0.01}) {
    const SingularBasis basis = leading_right_vectors(m, 60, tolerance);
    const Eigen::Index k = basis.vectors.rows();
    ASSERT_GT(k, 1);
    const double limit = tolerance * tolerance * values.squaredNorm();
    EXPECT_LE(values.tail(values.size() - k).squaredNorm(), limit * (1.0 + 1e-6));
    EXPECT_GT(values.tail(values.size() - k + 1).squaredNorm(), limit * (1.0 - 1e-6));
  }
}

TEST(SingularVectors, OfTheLeftAreThoseOfTheTranspose) {
  const MatrixD m = random_matrix(30, 80, 9);
  EXPECT_EQ(leading_left_vectors(m, 6).vectors, leading_right_vectors(m.transpose(), 6).vectors);
  expect_optimal(m.transpose(), leading_left_vectors(m, 6));
}

TEST(SingularVectors, RefuseWhatIsNotFinite) {
  MatrixD m = random_matrix(5, 6, 10);
  m(2, 3) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)leading_right_vectors(m, 2), UnsoundData);
  m(2, 3) = std::numeric_limits<double>::infinity();
  EXPECT_THROW((void)leading_right_vectors(m, 2), UnsoundData);
}

}  // namespace
}  // namespace prt
