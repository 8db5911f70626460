#include "bases/effect_basis.h"

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <algorithm>
#include <functional>

#include "support/random_matrix.h"

namespace prt {
namespace {

using test::falling_matrix;
using test::random_matrix;

// Products of some hundred float terms, divided by singular values that fall to a hundredth.
constexpr double kFloat = 1e-4;

struct Case {
  MatrixD effect, examples;  // m × n, lights × n
};

/// Lights × receivers × samples of all proportions; singular values fall as those of real clusters.
Case falling_case(Eigen::Index receivers, Eigen::Index lights, Eigen::Index samples) {
  const Eigen::Index rank = std::min({receivers, lights, samples});
  return {falling_matrix(receivers, samples, rank, 0.8, 1),
          falling_matrix(lights, samples, rank, 0.9, 3)};
}

EffectBasis basis_of(const Case& c, int most) {
  return make_effect_basis(c.effect.cast<float>(), c.examples.cast<float>(), most);
}

VectorD singular_values(const Case& c) {
  const Eigen::MatrixXd caused = c.effect * c.examples.transpose();
  return Eigen::JacobiSVD<Eigen::MatrixXd>(caused).singularValues();
}

/// ‖effect·(E − functionsᵀ·projections·E)‖², what the basis promises to make small.
double effect_left_out(const Case& c, const EffectBasis& basis) {
  const MatrixD e = c.examples.transpose();
  const MatrixD kept =
      basis.functions.cast<double>().transpose() * (basis.projections.cast<double>() * e);
  return (c.effect * (e - kept)).squaredNorm();
}

double biorthogonality_defect(const EffectBasis& basis) {
  const MatrixD product =
      basis.projections.cast<double>() * basis.functions.cast<double>().transpose();
  return (product - MatrixD::Identity(product.rows(), product.cols())).cwiseAbs().maxCoeff();
}

TEST(EffectBasis, KeepsOfTheEffectWhatTheSvdKeeps) {
  for (const Case& c : {falling_case(60, 40, 50), falling_case(20, 150, 80),
                        falling_case(200, 120, 30), falling_case(7, 9, 300)}) {
    const VectorD values = singular_values(c);
    const double total = values.squaredNorm();
    for (const int most : {1, 3, 7}) {
      const EffectBasis basis = basis_of(c, most);
      ASSERT_EQ(basis.functions.rows(), most);
      ASSERT_EQ(basis.functions.cols(), c.examples.cols());
      ASSERT_EQ(basis.projections.rows(), most);
      ASSERT_EQ(basis.projections.cols(), c.examples.cols());
      const double left = total - values.head(most).squaredNorm();
      EXPECT_NEAR(effect_left_out(c, basis) / total, left / total, kFloat);
      EXPECT_NEAR(basis.energy, 1.0 - left / total, kFloat);
      for (int k = 0; k < most; ++k) {
        EXPECT_NEAR(basis.strengths[k], values[k], kFloat * values[0]);
      }
    }
  }
}

TEST(EffectBasis, ProjectsItsFunctionsOnToThemselves) {
  for (const Case& c : {falling_case(60, 40, 50), falling_case(20, 150, 80)}) {
    const EffectBasis basis = basis_of(c, 12);
    ASSERT_EQ(basis.functions.rows(), 12);
    EXPECT_LT(biorthogonality_defect(basis), kFloat);
    EXPECT_NEAR(basis.defect, biorthogonality_defect(basis), kFloat);
    EXPECT_TRUE(std::is_sorted(basis.strengths.begin(), basis.strengths.end(), std::greater<>()));
  }
}

// Light that no receiver sees is no part of the basis, however strong it is.
TEST(EffectBasis, LeavesOutWhatNobodySees) {
  Case c = falling_case(30, 40, 50);
  c.effect.rightCols(25).setZero();
  c.examples.rightCols(25) *= 1e3;
  const EffectBasis basis = basis_of(c, 10);
  ASSERT_EQ(basis.functions.rows(), 10);
  EXPECT_EQ(basis.projections.rightCols(25).cwiseAbs().maxCoeff(), 0.0F);
  const VectorD values = singular_values(c);
  EXPECT_NEAR(effect_left_out(c, basis) / values.squaredNorm(),
              values.tail(values.size() - 10).squaredNorm() / values.squaredNorm(), kFloat);
}

// Rounding makes more of a deficient effect than there is; that must not spoil what is real.
TEST(EffectBasis, OfADeficientEffectIsExactAndSound) {
  for (const Eigen::Index rank : {1, 4}) {
    const Case c{falling_matrix(60, 50, rank, 0.7, 5), random_matrix(40, 50, 7)};
    const EffectBasis basis = basis_of(c, 12);
    ASSERT_GE(basis.functions.rows(), rank);
    EXPECT_TRUE(basis.functions.allFinite());
    EXPECT_TRUE(basis.projections.allFinite());
    EXPECT_NEAR(basis.energy, 1.0, kFloat);
    const double total = singular_values(c).squaredNorm();
    EXPECT_LT(effect_left_out(c, basis), kFloat * kFloat * total);
    const MatrixD product =
        basis.projections.cast<double>() * basis.functions.cast<double>().transpose();
    const MatrixD real = product.topLeftCorner(rank, rank);
    EXPECT_LT((real - MatrixD::Identity(rank, rank)).cwiseAbs().maxCoeff(), kFloat);
  }
}

TEST(EffectBasis, OfNoEffectIsEmpty) {
  const MatrixD some = random_matrix(8, 20, 9);
  for (const Case& c : {Case{MatrixD::Zero(6, 20), some}, Case{some, MatrixD::Zero(6, 20)},
                        Case{MatrixD(0, 20), some}}) {
    const EffectBasis basis = basis_of(c, 5);
    EXPECT_EQ(basis.functions.rows(), 0);
    EXPECT_EQ(basis.functions.cols(), 20);
    EXPECT_EQ(basis.projections.rows(), 0);
    EXPECT_EQ(basis.projections.cols(), 20);
    EXPECT_EQ(basis.strengths.size(), 0);
    EXPECT_EQ(basis.energy, 1.0);
    EXPECT_EQ(basis.defect, 0.0);
  }
}

// Clusters share out their functions by strength: it must be in the unit of the effect.
TEST(EffectBasis, StrengthsFollowTheUnitOfTheEffect) {
  Case c = falling_case(30, 40, 50);
  const EffectBasis plain = basis_of(c, 6);
  for (const double unit : {1e-6, 1e6}) {
    const EffectBasis scaled = basis_of({unit * c.effect, c.examples}, 6);
    ASSERT_EQ(scaled.strengths.size(), 6);
    for (int k = 0; k < 6; ++k) {
      EXPECT_NEAR(scaled.strengths[k] / unit / plain.strengths[k], 1.0, kFloat);
    }
    EXPECT_LT(biorthogonality_defect(scaled), kFloat);
  }
}

}  // namespace
}  // namespace prt
