#include "domains/directions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/random.h"

namespace prt {
namespace {

constexpr int kCounts[] = {1, 4, 6, 30, 2016, 4096};
// A few float roundings of numbers up to 1.
constexpr float kRounding = 2e-6F;
// The inverse map goes through atan2 and a division by cells: cell coordinates of up to 64 carry
// 64 times the rounding.
constexpr float kLookupRounding = 1e-4F;

TEST(HemisphereDirections, AreUnitAndAboveTheSurface) {
  for (const int count : kCounts) {
    const HemisphereDirections directions(count);
    ASSERT_EQ(directions.count(), count);
    for (int i = 0; i < count; ++i) {
      EXPECT_NEAR(directions.direction(i).norm(), 1.0F, kRounding);
      EXPECT_GT(directions.direction(i).z(), 0.0F);
    }
  }
}

TEST(HemisphereDirections, WeightsAreCosinesOfSumOne) {
  for (const int count : kCounts) {
    const HemisphereDirections directions(count);
    double sum = 0.0;
    for (const float w : directions.weights()) sum += w;
    EXPECT_NEAR(sum, 1.0, kRounding) << count;
    const double factor = directions.weights()[0] / directions.direction(0).z();
    for (int i = 0; i < count; ++i) {
      EXPECT_NEAR(directions.weights()[i] / (factor * directions.direction(i).z()), 1.0, 1e-5);
    }
  }
}

TEST(HemisphereDirections, IntegrateClosedForms) {
  // Midpoint rule on the square: its error falls as 1/count, and the map's kinks on the diagonals
  // cost as much.
  const HemisphereDirections directions(4096);
  const double tolerance = 4.0 / directions.count();
  Vec3d mean = Vec3d::Zero();         // ∫ω dω / 2π = (0, 0, 1/2)
  Vec3d cosine_mean = Vec3d::Zero();  // ∫ω cosθ dω / π = (0, 0, 2/3)
  double square_x = 0.0;              // ∫x² dω / 2π = 1/3
  double product_xy = 0.0;            // 0
  for (int i = 0; i < directions.count(); ++i) {
    const Vec3d d = directions.direction(i).cast<double>();
    mean += d / directions.count();
    cosine_mean += d * directions.weights()[i];
    square_x += d.x() * d.x() / directions.count();
    product_xy += d.x() * d.y() / directions.count();
  }
  EXPECT_LT((mean - Vec3d(0, 0, 0.5)).norm(), tolerance);
  EXPECT_LT((cosine_mean - Vec3d(0, 0, 2.0 / 3.0)).norm(), tolerance);
  EXPECT_NEAR(square_x, 1.0 / 3.0, tolerance);
  EXPECT_NEAR(product_xy, 0.0, tolerance);
}

TEST(HemisphereDirections, CellsCoverEqualSolidAngles) {
  const HemisphereDirections directions(30);
  constexpr int kDraws = 300000;
  std::vector<int> counts(directions.count(), 0);
  for (int k = 0; k < kDraws; ++k) {
    Random random(11, k);
    const float u = random.uniform();
    Vec3f d = sphere_direction(u, random.uniform());
    d.z() = std::abs(d.z());
    // The cell a direction falls into is the one whose centre has the most bilinear weight.
    const auto four = directions.lookup(d);
    const auto most = std::max_element(four.weight.begin(), four.weight.end());
    ++counts[four.index[most - four.weight.begin()]];
  }
  double chi_squared = 0.0;
  const double expected = static_cast<double>(kDraws) / directions.count();
  for (const int n : counts) chi_squared += (n - expected) * (n - expected) / expected;
  constexpr double kLimit = 58.3;  // 99.9 % quantile of χ² with 29 degrees of freedom
  EXPECT_LT(chi_squared, kLimit);
}

TEST(HemisphereDirections, LookupOfADirectionIsThatDirection) {
  for (const int count : kCounts) {
    const HemisphereDirections directions(count);
    for (int i = 0; i < count; ++i) {
      const auto four = directions.lookup(directions.direction(i));
      float weight = 0.0F;
      for (int k = 0; k < 4; ++k) {
        if (four.index[k] == i) weight += four.weight[k];
      }
      ASSERT_NEAR(weight, 1.0F, kLookupRounding) << i << " of " << count;
    }
  }
}

TEST(HemisphereDirections, LookupWeightsArePositiveOfSumOneAndNear) {
  for (const int count : kCounts) {
    const HemisphereDirections directions(count);
    for (int q = 0; q < 5000; ++q) {
      Random random(12, q);
      const float u = random.uniform();
      Vec3f d = sphere_direction(u, random.uniform());
      d.z() = std::abs(d.z());
      if (q == 0) d = Vec3f::UnitX();  // the horizon itself
      if (q == 1) d = Vec3f::UnitZ();
      const auto four = directions.lookup(d);
      float sum = 0.0F;
      for (int k = 0; k < 4; ++k) {
        ASSERT_GE(four.weight[k], 0.0F);
        ASSERT_GE(four.index[k], 0);
        ASSERT_LT(four.index[k], count);
        sum += four.weight[k];
      }
      ASSERT_NEAR(sum, 1.0F, kRounding);
    }
  }
}

TEST(HemisphereDirections, LookupInterpolatesSmoothFunctions) {
  // Inside the grid the bilinear mean of the four directions is the direction itself but for the
  // cells' curvature; cells of 2016 are 0.056 rad wide, the outermost are clamped by half of that.
  const HemisphereDirections directions(2016);
  constexpr float kHalfCell = 0.06F;
  for (int q = 0; q < 5000; ++q) {
    Random random(13, q);
    const float u = random.uniform();
    Vec3f d = sphere_direction(u, random.uniform());
    d.z() = std::abs(d.z());
    const auto four = directions.lookup(d);
    Vec3f mean = Vec3f::Zero();
    for (int k = 0; k < 4; ++k) mean += four.weight[k] * directions.direction(four.index[k]);
    ASSERT_LT((mean - d).norm(), kHalfCell);
  }
}

TEST(HemisphereDirections, RefusesCountsWithoutAGridAndNamesTheNearestThatHas) {
  for (const int count : {0, -5, 2, 13, 127, 2017}) {
    EXPECT_THROW(HemisphereDirections{count}, UserError) << count;
    const int near = HemisphereDirections::nearest_count(count);
    EXPECT_EQ(HemisphereDirections(near).count(), near);
  }
  EXPECT_EQ(HemisphereDirections::nearest_count(2016), 2016);
  EXPECT_EQ(HemisphereDirections::nearest_count(32), 30);
  EXPECT_EQ(HemisphereDirections::nearest_count(13), 12);
}

}  // namespace
}  // namespace prt
