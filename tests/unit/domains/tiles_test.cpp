#include "domains/tiles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "unit/domains/random_points.h"

namespace prt {
namespace {

std::vector<std::size_t> points_of_tiles(const Tiles& tiles, const std::vector<Vec3f>& points) {
  std::vector<std::size_t> count(tiles.size(), 0);
  for (const Vec3f& p : points) {
    std::size_t in = 0;
    for (std::size_t t = 0; t < tiles.size(); ++t) {
      if (!tiles.contains(t, p)) continue;
      ++count[t];
      ++in;
    }
    EXPECT_EQ(in, 1U) << p.transpose();
  }
  return count;
}

TEST(Tiles, EachPointLiesInOneAndNoneHasManyMore) {
  for (const std::size_t count : {1UL, 2UL, 3UL, 7UL, 16UL}) {
    const auto points = test::random_cloud(64 * count, 1).positions;
    const Tiles tiles(points, count);
    ASSERT_EQ(tiles.size(), count);
    const auto has = points_of_tiles(tiles, points);
    // Shares are rounded down once per halving.
    EXPECT_GE(*std::ranges::min_element(has), 60U);
    EXPECT_LE(*std::ranges::max_element(has), 68U);
    // Others, far outside of their box too, lie somewhere.
    auto others = test::random_cloud(500, 2).positions;
    for (Vec3f& p : others) p = 4.0F * p - Vec3f::Constant(1.5F);
    (void)points_of_tiles(tiles, others);
  }
}

TEST(Tiles, PointsInOnePlaceAreInOneTile) {
  const std::vector<Vec3f> points(256, Vec3f(1.0F, 2.0F, 3.0F));
  const Tiles tiles(points, 4);
  const auto has = points_of_tiles(tiles, points);
  EXPECT_EQ(std::ranges::count(has, 256U), 1);
}

TEST(Tiles, DistanceIsToTheNearestPointOfTheBox) {
  const auto points = test::random_cloud(640, 3).positions;
  const Tiles tiles(points, 10);
  const auto others = test::random_cloud(200, 4).positions;
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    for (const Vec3f& p : others) {
      const float distance = tiles.distance(t, p);
      if (tiles.contains(t, p)) {
        EXPECT_EQ(distance, 0.0F);
      }
      for (const Vec3f& q : points) {
        if (tiles.contains(t, q)) {
          EXPECT_LE(distance, 1.0001F * (p - q).norm());
        }
      }
      if (distance == 0.0F) continue;
      // A little farther on in some direction lies the tile.
      bool reached = false;
      for (const Vec3f& d : test::random_cloud(4000, 5).normals) {
        reached = reached || tiles.contains(t, p + 1.2F * distance * d);
        if (reached) break;
      }
      EXPECT_TRUE(reached) << t << ", " << p.transpose();
    }
  }
}

}  // namespace
}  // namespace prt
