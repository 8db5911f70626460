// The shadow test of many places at once against its definition, one place after the other.
#include "player/depth_tables.h"

#include <gtest/gtest.h>

#include "base/random.h"
#include "unit/package/synthetic_package.h"

namespace prt {
namespace {

/// Places in cells of some tens a side are off by their float rounding and that of a polynomial.
constexpr float kRounding = 2e-5F;

std::vector<Vec3f> directions_all_over() {
  std::vector<Vec3f> directions{Vec3f::UnitZ(),
                                Vec3f(1, 0, 1e-4F).normalized(),
                                Vec3f(0, -1, 1e-4F).normalized(),
                                Vec3f(1, 1, 1).normalized(),
                                Vec3f(-1, 1, 0.1F).normalized(),
                                Vec3f(-1e-12F, 1e-12F, 1)};
  for (int i = 0; i < 1000; ++i) {
    const Vec3f d = sphere_direction(static_cast<float>(i % 32) / 32.0F + 0.01F,
                                     static_cast<float>(i) * 0.001F);
    directions.emplace_back(d.x(), d.y(), std::abs(d.z()) + 1e-6F);
    directions.back().normalize();
  }
  return directions;
}

TEST(DirectionCells, AreThoseOfTheLookup) {
  const std::vector<Vec3f> asked = directions_all_over();
  for (const int count : {1, 2, 63, 1008, 2016}) {
    const HemisphereDirections directions(HemisphereDirections::nearest_count(count));
    DirectionCells cells;
    cells.make_room(asked.size());
    for (std::size_t i = 0; i < asked.size(); ++i) {
      cells.x[i] = asked[i].x();
      cells.y[i] = asked[i].y();
      cells.z[i] = asked[i].z();
    }
    find_cells(directions, asked.size(), cells);
    for (std::size_t i = 0; i < asked.size(); ++i) {
      const auto expected = directions.lookup(asked[i]);
      // Where a place is in the grid, whichever of two cells it is said to be in.
      const auto column = static_cast<float>(cells.corner[i] % directions.width());
      const auto row = static_cast<float>(cells.corner[i] / directions.width());
      float x = 0.0F;
      float y = 0.0F;
      for (std::size_t k = 0; k < 4; ++k) {
        x += expected.weight[k] * static_cast<float>(expected.index[k] % directions.width());
        y += expected.weight[k] * static_cast<float>(expected.index[k] / directions.width());
      }
      EXPECT_NEAR(directions.width() > 1 ? column + cells.across[i] : 0.0F, x, kRounding) << i;
      EXPECT_NEAR(directions.height() > 1 ? row + cells.along[i] : 0.0F, y, kRounding) << i;
      EXPECT_LT(cells.corner[i], directions.count());
    }
  }
}

TEST(DepthTables, ShareOfEachPlaceIsThatOfTheSoftTest) {
  for (const int bits : {8, 16, 32}) {
    const Package room = test::synthetic_room({.samples_per_edge = 6, .bits = bits});
    const DepthVisibility& visibility = *room.visibility;
    const DepthTables tables(visibility, room.samples);
    const HemisphereDirections directions(visibility.directions);
    DepthTables::Scratch scratch;
    std::size_t partly = 0;
    for (std::uint32_t sample = 0; sample < room.samples.size(); sample += 5) {
      const std::uint32_t cluster = room.samples.cluster_of_sample()[sample];
      const DepthBlock& block = visibility.clusters[cluster];
      const MatrixF depths =
          block.mean.decode() +
          block.coefficients.decode().row(sample - room.samples.cluster_begin[cluster]) *
              block.basis.decode();
      std::vector<ShiningPlace> places;
      for (int k = 0; k < 25; ++k) {  // a light of 0.8 m, some of it behind the wall
        const Vec3f at(1.6F + 0.2F * static_cast<float>(k % 5), 2.2F + 0.2F * float(k / 5), 2.5F);
        const Vec3f offset = at - room.samples.positions[sample];
        places.push_back({offset.normalized(), offset.norm()});
      }
      std::vector<float> shares(places.size());
      tables.visibility(sample, cluster, places, scratch, shares);
      for (std::size_t k = 0; k < places.size(); ++k) {
        const float expected = depth_visibility(
            directions, [&](int d) { return depths(0, d); },
            Vec3f(room.samples.frame(sample).transpose() * places[k].to_light), places[k].distance,
            visibility.bound, visibility.bias);
        EXPECT_NEAR(shares[k], expected, kRounding) << sample << ' ' << k;
        if (expected > 0.0F && expected < 1.0F) ++partly;
        float alone = -1.0F;
        tables.visibility(sample, cluster, {&places[k], 1}, scratch, {&alone, 1});
        EXPECT_EQ(shares[k], alone);
      }
    }
    EXPECT_GT(partly, 100U);
  }
}

}  // namespace
}  // namespace prt
