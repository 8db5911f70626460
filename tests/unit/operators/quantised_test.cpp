#include "operators/quantised.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/error.h"
#include "operators/blocks.h"
#include "support/random_matrix.h"

namespace prt {
namespace {

// Float's rounding of scale and product, as a share of the row's largest entry.
constexpr float kFloat = 4e-7F;

/// Rows of very different size.
MatrixF uneven_rows(Eigen::Index rows, Eigen::Index cols) {
  MatrixF m = test::random_matrix(rows, cols, 1).cast<float>();
  for (Eigen::Index i = 0; i < rows; ++i) m.row(i) *= std::pow(10.0F, static_cast<float>(i - 8));
  return m;
}

TEST(Quantised, RoundTripsWithinHalfAStepOfEachRow) {
  const MatrixF m = uneven_rows(17, 50);
  for (const auto& [bits, full] : {std::pair{8, 127.0F}, {16, 32767.0F}}) {
    const Quantised q = quantise(m, bits);
    const MatrixF again = q.matrix.decode();
    for (Eigen::Index i = 0; i < m.rows(); ++i) {
      const float largest = m.row(i).cwiseAbs().maxCoeff();
      EXPECT_LE((again - m).row(i).cwiseAbs().maxCoeff(), largest * (0.5F / full + kFloat));
      // The largest entry is the full scale itself.
      EXPECT_NEAR(again.row(i).cwiseAbs().maxCoeff(), largest, largest * kFloat);
    }
    EXPECT_NEAR(q.relative_error, (again - m).cast<double>().norm() / m.cast<double>().norm(),
                1e-7);
    EXPECT_GT(q.relative_error, 0.0);
  }
}

TEST(Quantised, KeepsThirtyTwoBitsAsTheyAre) {
  const MatrixF m = uneven_rows(17, 50);
  const Quantised q = quantise(m, 32);
  EXPECT_EQ(q.matrix.decode(), m);
  EXPECT_EQ(q.relative_error, 0.0);
  EXPECT_EQ(q.matrix.bytes(), 4U * 17 * 50);
}

TEST(Quantised, CountsItsBytes) {
  const MatrixF m = uneven_rows(17, 50);
  EXPECT_EQ(quantise(m, 8).matrix.bytes(), 17U * 50 + 4 * 17);
  EXPECT_EQ(quantise(m, 16).matrix.bytes(), 2U * 17 * 50 + 4 * 17);
}

TEST(Quantised, ZeroRowsStayZero) {
  MatrixF m = uneven_rows(3, 4);
  m.row(1).setZero();
  for (const int bits : {8, 16, 32}) {
    const MatrixF again = quantise(m, bits).matrix.decode();
    EXPECT_EQ(again.row(1).cwiseAbs().maxCoeff(), 0.0F);
    EXPECT_GT(again.row(0).cwiseAbs().maxCoeff(), 0.0F);
    EXPECT_EQ(quantise(MatrixF::Zero(3, 4), bits).relative_error, 0.0);
  }
}

TEST(Quantised, TakesEmptyMatrices) {
  for (const int bits : {8, 16, 32}) {
    for (const auto& [rows, cols] : {std::pair{0, 4}, {4, 0}}) {
      const MatrixF again = quantise(MatrixF(rows, cols), bits).matrix.decode();
      EXPECT_EQ(again.rows(), rows);
      EXPECT_EQ(again.cols(), cols);
    }
  }
}

TEST(Quantised, SubnormalAndHugeRowsStayFinite) {
  MatrixF m(4, 2);
  m << 1e-40F, -1e-41F,                             // subnormal
      2e-38F, 1e-38F,                               // normal, but not its scale
      3.4e38F, -3.4e38F,                            // nearly the largest float
      std::numeric_limits<float>::denorm_min(), 0;  // the least there is
  for (const int bits : {8, 16}) {
    const Quantised q = quantise(m, bits);
    const MatrixF again = q.matrix.decode();
    EXPECT_TRUE(again.allFinite());
    // What cannot be scaled is less than 2^-126 · 32767 and may become zero, never more than it
    // was.
    EXPECT_LE((again - m).topRows(2).cwiseAbs().maxCoeff(), 2e-38F);
    EXPECT_NEAR(again(2, 0) / 3.4e38F, 1.0F, 1e-5F);
    EXPECT_NEAR(again(2, 1) / 3.4e38F, -1.0F, 1e-5F);
    EXPECT_LT(q.relative_error, 1e-4);
  }
}

TEST(Quantised, RefusesWhatIsNotFiniteAndNamesTheShape) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), kInfinity, -kInfinity}) {
    MatrixF m = uneven_rows(3, 5);
    m(2, 4) = bad;
    for (const int bits : {8, 16, 32}) {
      try {
        (void)quantise(m, bits);
        ADD_FAILURE() << bad << " was taken";
      } catch (const UnsoundData& error) {
        EXPECT_NE(std::string(error.what()).find("3 x 5"), std::string::npos) << error.what();
      }
    }
  }
}

TEST(ClusterProjection, CountsCoefficients) {
  ClusterProjection projection;
  EXPECT_EQ(projection.coefficient_begin(), std::vector<std::uint32_t>{0});
  projection.blocks.resize(3);
  projection.blocks[0].rows = 4;
  projection.blocks[2].rows = 2;
  EXPECT_EQ(projection.coefficient_begin(), (std::vector<std::uint32_t>{0, 4, 4, 6}));
}

}  // namespace
}  // namespace prt
