#include "bases/pca.h"

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <cmath>

#include "support/random_matrix.h"

namespace prt {
namespace {

// The basis, the mean and the coefficients are stored in float: 2^-24 of values up to 1, times a
// few dozen components.
constexpr double kFloat = 1e-5;

/// Encoded depths as a cluster has them: smooth in sample and direction, some rays escaped.
MatrixF depth_rows(Eigen::Index samples, Eigen::Index directions) {
  MatrixF rows(samples, directions);
  for (Eigen::Index s = 0; s < samples; ++s) {
    const float place = static_cast<float>(s) / 50.0F;
    for (Eigen::Index d = 0; d < directions; ++d) {
      const float angle = 6.2F * static_cast<float>(d) / static_cast<float>(directions);
      const float depth =
          0.5F + 0.3F * std::sin(angle + place) + 0.1F * std::cos(3 * angle * place);
      rows(s, d) = depth > 0.75F ? 1.0F : depth;
    }
  }
  return rows;
}

MatrixD approximation(const PrincipalComponents& pca) {
  MatrixD again = pca.coefficients.cast<double>() * pca.basis.cast<double>();
  again.rowwise() += pca.mean.cast<double>().transpose();
  return again;
}

TEST(PrincipalComponents, AreOptimalOnDepths) {
  for (const auto& [samples, directions] : {std::pair{60, 400}, {300, 120}}) {
    const MatrixF rows = depth_rows(samples, directions);
    const PrincipalComponents pca = principal_components(rows, 12);
    ASSERT_EQ(pca.basis.rows(), 12);
    EXPECT_LT(pca.defect, 1e-5);
    MatrixD centred = rows.cast<double>();
    centred.rowwise() -= centred.colwise().mean().eval();
    const VectorD values =
        Eigen::JacobiSVD<Eigen::MatrixXd>(Eigen::MatrixXd(centred)).singularValues();
    const double optimal =
        std::sqrt(values.tail(values.size() - 12).squaredNorm() / static_cast<double>(rows.size()));
    const double measured = std::sqrt((approximation(pca) - rows.cast<double>()).squaredNorm() /
                                      static_cast<double>(rows.size()));
    ASSERT_GT(optimal, 100 * kFloat);  // truncation, not rounding, is what is measured
    EXPECT_NEAR(measured, optimal, kFloat);
    EXPECT_NEAR(pca.rms_error, measured, kFloat);
    EXPECT_NEAR(pca.energy, values.head(12).squaredNorm() / values.squaredNorm(), kFloat);
  }
}

TEST(PrincipalComponents, OfAllComponentsGiveTheRowsBack) {
  const MatrixF rows = depth_rows(20, 64);
  const PrincipalComponents pca = principal_components(rows, 100);
  EXPECT_LE(pca.basis.rows(), 19);  // one dimension goes to the mean
  EXPECT_LT((approximation(pca) - rows.cast<double>()).cwiseAbs().maxCoeff(), kFloat);
  EXPECT_NEAR(pca.rms_error, 0.0, kFloat);
}

TEST(PrincipalComponents, OfEqualRowsAreNone) {
  for (const Eigen::Index samples : {1, 2, 3, 100}) {
    const MatrixF rows = depth_rows(1, 200).replicate(samples, 1);
    const PrincipalComponents pca = principal_components(rows, 50);
    EXPECT_EQ(pca.basis.rows(), 0);
    EXPECT_EQ(pca.coefficients.rows(), samples);
    EXPECT_EQ(pca.energy, 1.0);
    EXPECT_LT((approximation(pca) - rows.cast<double>()).cwiseAbs().maxCoeff(), kFloat);
  }
}

TEST(PrincipalComponents, OfTwoAndThreeRowsAreExact) {
  for (const Eigen::Index samples : {2, 3}) {
    const MatrixF rows = depth_rows(samples, 200);
    const PrincipalComponents pca = principal_components(rows, 50);
    EXPECT_GE(pca.basis.rows(), samples - 1);  // one more may hold the rounding of the mean
    EXPECT_LT(pca.defect, 1e-5);
    EXPECT_LT((approximation(pca) - rows.cast<double>()).cwiseAbs().maxCoeff(), kFloat);
  }
}

TEST(PrincipalComponents, StopAtTheTolerance) {
  const MatrixF rows = depth_rows(60, 400);
  const PrincipalComponents loose = principal_components(rows, 50, 0.3);
  const PrincipalComponents tight = principal_components(rows, 50, 0.03);
  EXPECT_LT(loose.basis.rows(), tight.basis.rows());
  EXPECT_GE(loose.energy, 1.0 - 0.3 * 0.3);
  EXPECT_GE(tight.energy, 1.0 - 0.03 * 0.03);
}

}  // namespace
}  // namespace prt
