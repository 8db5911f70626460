#include "domains/thinning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "domains/samples.h"
#include "unit/domains/random_points.h"

namespace prt {
namespace {

constexpr float kRadius = 0.12F;

Candidates view(const test::PointCloud& cloud) {
  return {cloud.positions, cloud.normals, cloud.curvatures, cloud.priorities};
}

/// A sphere whose curvature rises with x, so that radii differ from point to point.
test::PointCloud curved_sphere(std::size_t count, std::uint64_t stream) {
  test::PointCloud cloud = test::sphere_cloud(count, stream);
  for (std::size_t i = 0; i < count; ++i) {
    cloud.curvatures[i] = 10.0F * std::max(0.0F, cloud.positions[i].x());
  }
  return cloud;
}

bool conflict(const test::PointCloud& cloud, std::uint32_t a, std::uint32_t b) {
  const float limit = std::min(candidate_radius(kRadius, cloud.curvatures[a]),
                               candidate_radius(kRadius, cloud.curvatures[b]));
  return cloud.normals[a].dot(cloud.normals[b]) >= kCompatibleCosine &&
         (cloud.positions[a] - cloud.positions[b]).squaredNorm() < limit * limit;
}

TEST(Thinning, KeepsNoCompatiblePairNearerThanTheSmallerRadius) {
  for (const auto& cloud : {curved_sphere(6000, 1), test::random_cloud(6000, 2)}) {
    const auto kept = thin(view(cloud), kRadius, kCompatibleCosine);
    EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end()));
    for (std::size_t i = 0; i < kept.size(); ++i) {
      for (std::size_t j = i + 1; j < kept.size(); ++j) {
        ASSERT_FALSE(conflict(cloud, kept[i], kept[j])) << kept[i] << " and " << kept[j];
      }
    }
  }
}

TEST(Thinning, IsMaximalAndEachDroppedOneGaveWayToAHigherPriority) {
  for (const auto& cloud : {curved_sphere(6000, 3), test::random_cloud(6000, 4)}) {
    const auto kept = thin(view(cloud), kRadius, kCompatibleCosine);
    EXPECT_LT(kept.size(), cloud.positions.size());
    std::vector<bool> stays(cloud.positions.size(), false);
    for (const auto i : kept) stays[i] = true;
    for (std::uint32_t i = 0; i < stays.size(); ++i) {
      if (stays[i]) continue;
      const bool gave_way = std::any_of(kept.begin(), kept.end(), [&](std::uint32_t k) {
        return cloud.priorities[k] > cloud.priorities[i] && conflict(cloud, i, k);
      });
      ASSERT_TRUE(gave_way) << i;
    }
  }
}

TEST(Thinning, DoesNotDependOnTheOrderOfCandidates) {
  const auto cloud = curved_sphere(6000, 5);
  std::vector<std::uint32_t> order(cloud.positions.size());
  std::iota(order.begin(), order.end(), 0U);
  for (std::uint32_t i = static_cast<std::uint32_t>(order.size()) - 1; i > 0; --i) {
    std::swap(order[i], order[Random(6, i).below(i + 1)]);
  }
  test::PointCloud shuffled;
  for (const auto i : order) {
    shuffled.positions.push_back(cloud.positions[i]);
    shuffled.normals.push_back(cloud.normals[i]);
    shuffled.curvatures.push_back(cloud.curvatures[i]);
    shuffled.priorities.push_back(cloud.priorities[i]);
  }
  const auto kept = thin(view(cloud), kRadius, kCompatibleCosine);
  std::vector<std::uint32_t> again;
  for (const auto i : thin(view(shuffled), kRadius, kCompatibleCosine)) again.push_back(order[i]);
  std::sort(again.begin(), again.end());
  EXPECT_EQ(kept, again);
}

TEST(Thinning, OppositeSidesOfASheetDoNotCompete) {
  const std::vector<Vec3f> positions(2, Vec3f::Zero());
  const std::vector<Vec3f> normals{Vec3f::UnitY(), -Vec3f::UnitY()};
  const std::vector<float> flat(2, 0.0F);
  const std::vector<std::uint64_t> priorities{1, 2};
  EXPECT_EQ(thin({positions, normals, flat, priorities}, kRadius, kCompatibleCosine).size(), 2U);
}

TEST(Thinning, ReachesACountToFivePerCent) {
  const auto cloud = test::sphere_cloud(48000, 7);
  for (const std::size_t count : {40UL, 600UL, 2000UL}) {
    const ThinnedTo result = thin_to_count(view(cloud), count, kCompatibleCosine);
    EXPECT_NEAR(static_cast<double>(result.kept.size()) / static_cast<double>(count), 1.0, 0.05)
        << count;
    EXPECT_EQ(result.kept, thin(view(cloud), result.radius, kCompatibleCosine));
  }
}

TEST(Thinning, GivesAllCandidatesWhereMoreAreWanted) {
  const auto cloud = test::sphere_cloud(50, 8);
  EXPECT_EQ(thin_to_count(view(cloud), 500, kCompatibleCosine).kept.size(), 50U);
}

TEST(Thinning, CurvatureShrinksRadiiByAQuarterAtMost) {
  EXPECT_FLOAT_EQ(candidate_radius(0.2F, 0.0F), 0.2F);
  EXPECT_FLOAT_EQ(candidate_radius(0.2F, 5.0F), 0.1F);
  EXPECT_FLOAT_EQ(candidate_radius(0.2F, 1e6F), 0.05F);
  // The curved half of the sphere ends up with more samples than the flat one.
  const auto cloud = curved_sphere(20000, 9);
  std::size_t curved = 0;
  const auto kept = thin(view(cloud), kRadius, kCompatibleCosine);
  for (const auto i : kept) curved += cloud.positions[i].x() > 0.0F ? 1 : 0;
  EXPECT_GT(static_cast<double>(curved), 0.6 * static_cast<double>(kept.size()));
}

}  // namespace
}  // namespace prt
