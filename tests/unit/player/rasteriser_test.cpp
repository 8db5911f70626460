#include "player/rasteriser.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>

#include "base/error.h"
#include "base/random.h"

namespace prt {
namespace {

/// A scene of loose triangles with one opaque material; the camera below looks along -z.
class Picture : public ::testing::Test {
 protected:
  void SetUp() override { scene_.materials.resize(1); }

  void add(const Vec3f& a, const Vec3f& b, const Vec3f& c, std::uint32_t material = 0) {
    const auto first = static_cast<std::uint32_t>(scene_.positions.size());
    for (const Vec3f& p : {a, b, c}) {
      scene_.positions.push_back(p);
      scene_.normals.emplace_back(Vec3f::UnitZ());
      scene_.uvs.emplace_back(p.x(), p.y());
      scene_.bounds_min = scene_.bounds_min.cwiseMin(p);
      scene_.bounds_max = scene_.bounds_max.cwiseMax(p);
    }
    scene_.triangles.push_back({{first, first + 1, first + 2}, material, 0});
  }
  void add_quad(const Vec3f& a, const Vec3f& b, const Vec3f& c, const Vec3f& d) {
    add(a, b, c);
    add(a, c, d);
  }
  [[nodiscard]] FragmentImage draw(unsigned threads = 0) const {
    return rasterise(scene_, camera_, kSize, kSize, threads);
  }
  /// Pixels of each triangle.
  static std::map<std::uint32_t, int> counts(const FragmentImage& image) {
    std::map<std::uint32_t, int> counts;
    for (const Fragment& f : image.fragments) ++counts[f.triangle];
    return counts;
  }

  static constexpr int kSize = 64;
  Scene scene_;
  /// At unit depth the picture spans [-1, 1]²: a pixel is 1/32 wide.
  SceneCamera camera_{.eye = Vec3f::Zero(), .target = -Vec3f::UnitZ(), .vertical_fov = kPi / 2};
};

TEST_F(Picture, CoversExactlyThePixelsWhoseCentresAreInside) {
  // 16 × 8 pixels, corners on pixel corners.
  add_quad({-0.25F, -0.125F, -1}, {0.25F, -0.125F, -1}, {0.25F, 0.125F, -1}, {-0.25F, 0.125F, -1});
  const FragmentImage image = draw();
  auto found = counts(image);
  EXPECT_EQ(found[0] + found[1], 16 * 8);
  EXPECT_NE(image.fragments[28 * kSize + 24].triangle, kNone);  // the top left corner
  EXPECT_EQ(image.fragments[27 * kSize + 24].triangle, kNone);
  EXPECT_EQ(image.fragments[28 * kSize + 23].triangle, kNone);
  EXPECT_NE(image.fragments[35 * kSize + 39].triangle, kNone);  // the bottom right corner
  EXPECT_EQ(image.fragments[36 * kSize + 39].triangle, kNone);
}

TEST_F(Picture, APixelCentreOnASharedEdgeBelongsToOneTriangle) {
  // Corners on pixel centres, so that the outer edges, too, run through centres: of the 17 columns
  // and rows of centres on the square one side's are left out.
  const float a = 8.5F / 32.0F;
  const float b = 7.5F / 32.0F;
  add_quad({-a, -a, -1}, {b, -a, -1}, {b, b, -1}, {-a, b, -1});
  auto found = counts(draw());
  EXPECT_EQ(found[0] + found[1], 16 * 16);
}

TEST_F(Picture, AMeshHasNoCracksAndNoOverlaps) {
  // A fan of thin triangles about an odd point fills the picture; each pixel is drawn once.
  const Vec3f centre(0.123F, -0.217F, -1);
  const int spokes = 97;
  const auto rim = [](int k) {
    const float angle = 2.0F * kPi * static_cast<float>(k % spokes) / spokes;
    return Vec3f(3.0F * std::cos(angle), 3.0F * std::sin(angle), -1.0F);
  };
  for (int k = 0; k < spokes; ++k) add(centre, rim(k), rim(k + 1));
  EXPECT_EQ(counts(draw()).count(kNone), 0U);
  int sum = 0;
  const Scene all = scene_;
  for (const Triangle& t : all.triangles) {
    scene_.triangles = {t};
    sum += counts(draw())[0];
  }
  EXPECT_EQ(sum, kSize * kSize);
}

TEST_F(Picture, ATiltedMeshThatReachesBehindTheEyeHasNoCracks) {
  // The camera stands in a closed box of many triangles, most of them clipped.
  constexpr int kCells = 9;
  const auto point = [](int axis, float side, int i, int j) {
    Vec3f p;
    p[axis] = side;
    p[(axis + 1) % 3] = -1.7F + 3.4F * static_cast<float>(i) / kCells;
    p[(axis + 2) % 3] = -1.7F + 3.4F * static_cast<float>(j) / kCells;
    return p;
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (const float side : {-1.7F, 1.7F}) {
      for (int k = 0; k < kCells * kCells; ++k) {
        const int i = k % kCells;
        const int j = k / kCells;
        add_quad(point(axis, side, i, j), point(axis, side, i + 1, j),
                 point(axis, side, i + 1, j + 1), point(axis, side, i, j + 1));
      }
    }
  }
  for (std::uint64_t view = 0; view < 20; ++view) {
    Random random(1, view);
    const float u = random.uniform();
    camera_.eye = Vec3f(random.uniform(), random.uniform(), random.uniform());
    camera_.target = camera_.eye + sphere_direction(u, random.uniform());
    ASSERT_EQ(counts(draw()).count(kNone), 0U) << "view " << view;
  }
}

TEST_F(Picture, TheNearestTriangleWinsInAnyOrder) {
  add({-4, -4, -3}, {4, -4, -3}, {0, 8, -3});
  add({-1, -1, -2}, {1, -1, -2}, {0, 1, -2});
  const auto before = counts(draw());
  std::swap(scene_.triangles[0], scene_.triangles[1]);
  const auto after = counts(draw());
  EXPECT_GT(before.at(1), 0);
  EXPECT_EQ(before.at(1), after.at(0));
  EXPECT_EQ(before.at(0), after.at(1));
}

TEST_F(Picture, TrianglesThatCrossAreSplitWhereTheyCross) {
  // Two walls through the z axis at depth 2, tilted oppositely: each is in front on one half.
  add_quad({-1, -1, -1.5F}, {1, -1, -2.5F}, {1, 1, -2.5F}, {-1, 1, -1.5F});
  add_quad({-1, -1, -2.5F}, {1, -1, -1.5F}, {1, 1, -1.5F}, {-1, 1, -2.5F});
  const FragmentImage image = draw();
  for (int x = 0; x < kSize; ++x) {
    const std::uint32_t t = image.fragments[32 * kSize + x].triangle;
    if (t == kNone || std::abs(x - kSize / 2) < 2) continue;
    EXPECT_EQ(t / 2, x < kSize / 2 ? 0U : 1U) << x;
  }
}

TEST_F(Picture, WhatLiesBehindTheEyeIsNotDrawn) {
  add({-1, -1, 2}, {1, -1, 2}, {0, 1, 2});
  EXPECT_EQ(counts(draw())[kNone], kSize * kSize);
}

TEST_F(Picture, BothSidesAreDrawn) {
  add({-1, -1, -2}, {1, -1, -2}, {0, 1, -2});
  const int front = counts(draw())[0];
  std::swap(scene_.triangles[0].vertex[0], scene_.triangles[0].vertex[1]);
  EXPECT_EQ(counts(draw())[0], front);
  EXPECT_GT(front, 100);
}

TEST_F(Picture, BarycentricsAreThoseOfTheSurfaceSeen) {
  // Each fragment's point, projected again, is the pixel's centre: to the rounding of corners to
  // 1/256 pixel, which a receding floor stretches.
  constexpr float kPixels = 0.02F;
  add_quad({-30, -1, 5}, {30, -1, 5}, {3, -1, -60}, {-3, -1, -60});
  const FragmentImage image = draw();
  int seen = 0;
  for (int i = 0; i < kSize * kSize; ++i) {
    const Fragment& f = image.fragments[i];
    if (f.triangle == kNone) continue;
    ++seen;
    const Vec3f p = triangle_point(scene_, f.triangle, f.u, f.v);
    const float x = 32.0F * (1.0F + p.x() / -p.z());
    const float y = 32.0F * (1.0F - p.y() / -p.z());
    ASSERT_NEAR(x, static_cast<float>(i % kSize) + 0.5F, kPixels);
    ASSERT_NEAR(y, static_cast<float>(i / kSize) + 0.5F, kPixels);
  }
  EXPECT_GT(seen, 1000);
}

TEST_F(Picture, AlphaMasksLetThroughWhatLiesBehind) {
  Texture holes;
  holes.width = 2;
  holes.height = 1;
  holes.rgba = {255, 255, 255, 255, 255, 255, 255, 0};
  scene_.textures = {holes};
  Material masked;
  masked.alpha_mask = true;
  masked.texture = 0;
  scene_.materials.push_back(masked);
  add({-8, -8, -3}, {8, -8, -3}, {0, 16, -3});
  add({0, -1, -1}, {1, -1, -1}, {1, 1, -1}, 1);
  add({0, -1, -1}, {1, 1, -1}, {0, 1, -1}, 1);
  auto found = counts(draw());
  EXPECT_GT(found[1] + found[2], 200);
  EXPECT_LT(found[1] + found[2], kSize * kSize / 2 - 200);
  EXPECT_EQ(found[0] + found[1] + found[2], kSize * kSize);
}

TEST_F(Picture, IsTheSameOnAnyNumberOfThreads) {
  for (std::uint64_t t = 0; t < 300; ++t) {
    Random random(2, t);
    const auto corner = [&]() -> Vec3f {
      const float x = random.uniform() * 4 - 2;
      const float y = random.uniform() * 4 - 2;
      return {x, y, -random.uniform() * 4};
    };
    const Vec3f a = corner();
    const Vec3f b = corner();
    add(a, b, corner());
  }
  const FragmentImage one = draw(1);
  const FragmentImage many = draw(4);
  for (std::size_t i = 0; i < one.fragments.size(); ++i) {
    ASSERT_EQ(one.fragments[i].triangle, many.fragments[i].triangle);
    ASSERT_EQ(one.fragments[i].u, many.fragments[i].u);
  }
}

TEST_F(Picture, RefusesImpossibleSizes) {
  EXPECT_THROW(static_cast<void>(rasterise(scene_, camera_, 0, 5)), UserError);
  EXPECT_THROW(static_cast<void>(rasterise(scene_, camera_, 5, 100000)), UserError);
}

}  // namespace
}  // namespace prt
