#include <gtest/gtest.h>

#include <algorithm>

#include "domains/samples.h"
#include "unit/domains/random_points.h"

namespace prt {
namespace {

constexpr float kCell = 0.1F;

/// What nearest() promises, by looking at all samples.
std::uint32_t nearest_of_all(const test::PointCloud& cloud, const Vec3f& p, const Vec3f& n,
                             float radius, float min_cosine) {
  std::uint32_t best = kNone;
  float least = kInfinity;
  for (std::uint32_t i = 0; i < cloud.positions.size(); ++i) {
    const Vec3f offset = cloud.positions[i] - p;
    // Along the normal, four times as far.
    const float d = (offset + 3.0F * offset.dot(n) * n).squaredNorm();
    if (cloud.normals[i].dot(n) < min_cosine || offset.norm() > radius || d >= least) continue;
    least = d;
    best = i;
  }
  return best;
}

/// Query points reach beyond the cube of the samples, where cells are empty and negative.
Vec3f query_point(Random& random) {
  const float x = random.uniform(), y = random.uniform(), z = random.uniform();
  return 1.4F * Vec3f(x, y, z) - Vec3f::Constant(0.2F);
}

TEST(SampleGrid, NearestIsThatOfBruteForceForAnyRadius) {
  const test::PointCloud cloud = test::random_cloud(3000, 1);
  const SampleGrid grid(cloud.positions, cloud.normals, kCell);
  int found = 0;
  int missed = 0;
  for (const float radius : {0.3F * kCell, kCell, 1.001F * kCell, 3.7F * kCell}) {
    for (const float cosine : {-1.0F, 0.0F, kCompatibleCosine}) {
      for (std::uint64_t q = 0; q < 500; ++q) {
        Random random(2, q);
        const Vec3f p = query_point(random);
        const Vec3f& n = cloud.normals[q];
        const std::uint32_t expected = nearest_of_all(cloud, p, n, radius, cosine);
        ASSERT_EQ(grid.nearest(p, n, radius, cosine), expected)
            << "radius " << radius << ", cosine " << cosine << ", query " << q;
        ++(expected == kNone ? missed : found);
      }
    }
  }
  EXPECT_GT(found, 1000);  // both outcomes were really asked for
  EXPECT_GT(missed, 1000);
}

TEST(SampleGrid, WithinIsThatOfBruteForceForAnyRadius) {
  const test::PointCloud cloud = test::random_cloud(3000, 3);
  const SampleGrid grid(cloud.positions, cloud.normals, kCell);
  for (const float radius : {0.3F * kCell, kCell, 3.7F * kCell}) {
    for (std::uint64_t q = 0; q < 500; ++q) {
      Random random(4, q);
      const Vec3f p = query_point(random);
      std::vector<std::uint32_t> expected;
      for (std::uint32_t i = 0; i < cloud.positions.size(); ++i) {
        if ((cloud.positions[i] - p).squaredNorm() <= radius * radius) expected.push_back(i);
      }
      std::vector<std::uint32_t> out;
      grid.within(p, radius, out);
      std::sort(out.begin(), out.end());  // sorted cell by cell only
      ASSERT_EQ(out, expected) << "radius " << radius << ", query " << q;
    }
  }
}

TEST(SampleGrid, WithinAppends) {
  const test::PointCloud cloud = test::random_cloud(10, 5);
  const SampleGrid grid(cloud.positions, cloud.normals, kCell);
  std::vector<std::uint32_t> out{77};
  grid.within(cloud.positions[3], 0.0F, out);
  EXPECT_EQ(out, (std::vector<std::uint32_t>{77, 3}));
}

TEST(SampleGrid, TiesGoToTheLowestIndexWhereverTheyLie) {
  // Eight samples at exactly the same distance, in eight cells, in an order that is not that of
  // cells; the query is their centre.
  const Vec3f centre(0.5F, 0.5F, 0.5F);
  std::vector<Vec3f> corners;
  for (const int k : {5, 2, 7, 0, 3, 6, 1, 4}) {
    corners.push_back(centre + 0.0625F * Vec3f(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1));
  }
  const std::vector<Vec3f> up(corners.size(), Vec3f::UnitY());
  for (const float cell : {0.05F, 0.11F, 2.0F}) {
    const SampleGrid grid(corners, up, cell);
    for (std::size_t dropped = 0; dropped < corners.size(); ++dropped) {
      std::vector<Vec3f> normals = up;  // the first `dropped` face away
      std::fill_n(normals.begin(), dropped, -Vec3f::UnitY());
      const SampleGrid partly(corners, normals, cell);
      EXPECT_EQ(partly.nearest(centre, Vec3f::UnitY(), 0.2F), dropped) << "cell " << cell;
    }
  }
}

TEST(SampleGrid, AWallOfFewSamplesDoesNotTakeThoseOfTheNextWall) {
  // Two walls 0.4 apart that face the same way; the point lies on the first, whose only sample is
  // farther than one of the second.
  const std::vector<Vec3f> positions = {{0, 0, 0}, {0.8F, 0, 0.4F}};
  const std::vector<Vec3f> normals(2, Vec3f::UnitZ());
  const SampleGrid grid(positions, normals, 1.0F);
  const Vec3f point(0.8F, 0, 0);
  EXPECT_EQ(grid.nearest(point, Vec3f::UnitZ(), 1.0F), 0U);
  // What lies beyond the radius does not count, however flat.
  EXPECT_EQ(grid.nearest(point, Vec3f::UnitZ(), 0.5F), 1U);
}

TEST(SampleGrid, EmptyFindsNothing) {
  const SampleGrid grid;
  std::vector<std::uint32_t> out;
  grid.within(Vec3f::Zero(), 1.0F, out);
  EXPECT_TRUE(out.empty());
  EXPECT_EQ(grid.nearest(Vec3f::Zero(), Vec3f::UnitY(), 1.0F), kNone);
}

}  // namespace
}  // namespace prt
