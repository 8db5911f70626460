// Thinning piece by piece keeps what thinning all at once does, to the last candidate.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "domains/samples.h"
#include "domains/thinning.h"
#include "domains/tiles.h"
#include "unit/domains/random_points.h"

namespace prt {
namespace {

Candidates view(const test::PointCloud& cloud) {
  return {cloud.positions, cloud.normals, cloud.curvatures, cloud.priorities};
}

test::PointCloud part_of(const test::PointCloud& cloud, const std::vector<std::uint32_t>& indices) {
  test::PointCloud part;
  for (const auto i : indices) {
    part.positions.push_back(cloud.positions[i]);
    part.normals.push_back(cloud.normals[i]);
    part.curvatures.push_back(cloud.curvatures[i]);
    part.priorities.push_back(cloud.priorities[i]);
  }
  return part;
}

std::vector<std::uint32_t> named(const std::vector<std::uint32_t>& kept,
                                 const std::vector<std::uint32_t>& names) {
  std::vector<std::uint32_t> all;
  for (const auto k : kept) all.push_back(names[k]);
  return all;
}

/// What the tiles leave of all candidates, each seeing `halo` metres beyond its own.
std::vector<std::uint32_t> left_of(const test::PointCloud& cloud, std::size_t count, float halo,
                                   const RadiusRange& range) {
  const Tiles tiles(test::random_cloud(64 * count, 99).positions, count);
  std::vector<std::uint32_t> all;
  for (std::size_t t = 0; t < count; ++t) {
    std::vector<std::uint32_t> near;
    std::vector<float> known;
    for (std::uint32_t i = 0; i < cloud.positions.size(); ++i) {
      const float distance = tiles.distance(t, cloud.positions[i]);
      if (distance > halo) continue;
      near.push_back(i);
      known.push_back(0.999F * halo - distance);
    }
    const auto cut = part_of(cloud, near);
    for (const auto i : named(drop_beaten(view(cut), known, range, kCompatibleCosine), near)) {
      if (tiles.contains(t, cloud.positions[i])) all.push_back(i);
    }
  }
  std::ranges::sort(all);
  return all;
}

/// Radii that differ, and among the priorities equal ones.
test::PointCloud mixed_cloud(std::size_t count, std::uint64_t stream) {
  test::PointCloud cloud = test::random_cloud(count, stream);
  for (std::size_t i = 0; i < count; ++i) {
    Random random(stream + 1000, i);
    cloud.positions[i].z() *= 0.1F;
    if (random.uniform() < 0.5F) cloud.normals[i] = Vec3f::UnitZ();
    cloud.curvatures[i] = 40.0F * random.uniform() * random.uniform();
    if (random.uniform() < 0.2F) cloud.priorities[i] = random.below(20);
  }
  return cloud;
}

TEST(ThinningPieces, TilesLeaveWhatAnyRadiusOfTheRangeKeeps) {
  constexpr float kRadius = 0.05F;
  for (std::uint64_t stream = 1; stream <= 12; ++stream) {
    const auto cloud = mixed_cloud(3000, stream);
    for (const float halo : {0.0F, 0.3F * kRadius, 1.5F * kRadius, 5.0F * kRadius}) {
      for (const float width : {0.0F, 0.02F, 0.3F}) {
        const RadiusRange range{kRadius * (1.0F - width), kRadius * (1.0F + width)};
        const auto left = left_of(cloud, 1 + stream % 9, halo, range);
        const auto cut = part_of(cloud, left);
        for (const float share : {0.0F, 0.37F, 1.0F}) {
          const float radius = range.low + share * (range.high - range.low);
          EXPECT_EQ(named(thin(view(cut), radius, kCompatibleCosine), left),
                    thin(view(cloud), radius, kCompatibleCosine))
              << "cloud " << stream << ", halo " << halo << ", radius " << radius;
        }
      }
    }
  }
}

/// A row in which each gives way to the next but for who it gave way to: who stays depends on the
/// far end.
test::PointCloud chain(std::size_t count, float step) {
  test::PointCloud cloud;
  for (std::size_t i = 0; i < count; ++i) {
    cloud.positions.emplace_back(step * static_cast<float>(i), 0.5F, 0.5F);
    cloud.normals.push_back(Vec3f::UnitY());
    cloud.curvatures.push_back(0.0F);
    cloud.priorities.push_back((i + 1) << 48);
  }
  return cloud;
}

TEST(ThinningPieces, ChainsAcrossAllTilesAreDecidedAtTheirEnd) {
  constexpr float kStep = 0.01F;
  for (const std::size_t count : {100UL, 101UL}) {
    const auto cloud = chain(count, kStep);
    for (const float reach : {1.5F, 2.5F, 7.5F}) {
      const RadiusRange range{reach * kStep, reach * kStep};
      const auto left = left_of(cloud, 8, 4.0F * reach * kStep, range);
      const auto kept = thin(view(cloud), range.low, kCompatibleCosine);
      EXPECT_GT(left.size(), kept.size());  // some tile could not know
      EXPECT_EQ(named(thin(view(part_of(cloud, left)), range.low, kCompatibleCosine), left), kept);
    }
  }
}

TEST(ThinningPieces, TilesThatSeeAFewRadiiAheadLeaveLittle) {
  constexpr float kRadius = 0.02F;
  auto cloud = test::random_cloud(60000, 5);
  for (std::size_t i = 0; i < cloud.positions.size(); ++i) {
    cloud.positions[i].z() = 0.0F;
    cloud.normals[i] = Vec3f::UnitZ();
  }
  const auto kept = thin(view(cloud), kRadius, kCompatibleCosine).size();
  const auto left_at = [&](float halo, float low) {
    return static_cast<double>(left_of(cloud, 4, halo * kRadius, {low * kRadius, kRadius}).size()) /
           static_cast<double>(kept);
  };
  ASSERT_GT(cloud.positions.size(), 25 * kept);
  EXPECT_EQ(left_at(1e3F, 1.0F), 1.0);  // who sees all knows all
  EXPECT_LT(left_at(4.0F, 1.0F), 1.1);
  EXPECT_GT(left_at(0.5F, 1.0F), 1.1);
  EXPECT_LT(left_at(4.0F, 0.88F), 8.0);  // of some 28
}

TEST(ThinningPieces, TheSearchForTheRadiusIsThatOfAllCandidates) {
  for (const std::size_t count : {600UL, 900UL, 1100UL}) {
    for (const std::uint64_t stream : {1UL, 2UL, 3UL}) {
      const auto cloud = mixed_cloud(24000, stream);
      const ThinnedTo whole = thin_to_count(view(cloud), count, kCompatibleCosine);
      Vec3f low = cloud.positions[0], high = low;
      std::vector<std::uint32_t> highest;
      for (std::uint32_t i = 0; i < cloud.positions.size(); ++i) {
        low = low.cwiseMin(cloud.positions[i]);
        high = high.cwiseMax(cloud.positions[i]);
        if (cloud.priorities[i] > std::uint64_t{9} << 60) highest.push_back(i);
      }
      ASSERT_GT(highest.size(), cloud.positions.size() / 16);
      RadiusGuess guess = guess_radius(view(part_of(cloud, highest)), cloud.positions.size(),
                                       (high - low).norm(), count, kCompatibleCosine);
      guess.range = {0.5F * guess.first, 1.5F * guess.first};
      const auto left = left_of(cloud, 5, 4.0F * guess.range.high, guess.range);
      EXPECT_LT(left.size(), cloud.positions.size());
      const auto piecewise =
          thin_to_count(view(part_of(cloud, left)), guess, count, kCompatibleCosine);
      ASSERT_TRUE(piecewise);
      EXPECT_EQ(piecewise->radius, whole.radius);
      EXPECT_EQ(named(piecewise->kept, left), whole.kept);
      // Where it has to look elsewhere it says so.
      guess.range.low = 1.0001F * guess.first;
      EXPECT_FALSE(thin_to_count(view(cloud), guess, count, kCompatibleCosine));
    }
  }
}

TEST(ThinningPieces, TheRadiusIsGuessedWhereEdgesAndCurvatureMatter) {
  // Many small discs, half of them curved: the search begins at some 10 % too much.
  auto cloud = test::random_cloud(400000, 8);
  for (std::size_t i = 0; i < cloud.positions.size(); ++i) {
    Vec3f& p = cloud.positions[i];
    const bool is_curved = p.x() > 0.5F;
    p.z() = 0.25F * std::floor(4.0F * p.z());
    cloud.normals[i] = Vec3f::UnitZ();
    cloud.curvatures[i] = is_curved ? 20.0F : 0.0F;
  }
  Vec3f low = Vec3f::Zero(), high = Vec3f(1.0F, 1.0F, 0.75F);
  const std::size_t count = 14000;
  const ThinnedTo whole = thin_to_count(view(cloud), count, kCompatibleCosine);
  const RadiusGuess guess = guess_radius(view(cloud), cloud.positions.size(), (high - low).norm(),
                                         count, kCompatibleCosine);
  EXPECT_LT(whole.radius, 0.95F * guess.first);
  EXPECT_TRUE(guess.range.contains(whole.radius)) << whole.radius << " of " << guess.first;
  EXPECT_TRUE(thin_to_count(view(cloud), guess, count, kCompatibleCosine));
}

TEST(ThinningPieces, TooFewOfTheHighestAreAMistake) {
  const auto cloud = test::random_cloud(1000, 1);
  EXPECT_THROW((void)guess_radius(view(cloud), 16016, 1.0F, 600, kCompatibleCosine),
               std::logic_error);
}

}  // namespace
}  // namespace prt
