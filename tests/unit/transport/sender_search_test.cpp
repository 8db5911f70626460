// Which sample a hit takes: two floors that face the same way, one above the other.
#include "transport/sender_search.h"

#include <gtest/gtest.h>

namespace prt {
namespace {

constexpr float kRadius = 0.1F;

/// A square of side 2 at each height, facing up; its triangles are 2k and 2k + 1.
Scene floors(const std::vector<float>& heights) {
  Scene scene;
  scene.materials.emplace_back();
  for (const float y : heights) {
    const auto first = static_cast<std::uint32_t>(scene.positions.size());
    for (const auto& [x, z] : {std::pair(0.0F, 0.0F), {0.0F, 2.0F}, {2.0F, 2.0F}, {2.0F, 0.0F}}) {
      scene.positions.emplace_back(x, y, z);
    }
    for (const std::uint32_t k : {1U, 2U}) {
      Triangle triangle;
      triangle.vertex = {first, first + k, first + k + 1};
      scene.triangles.push_back(triangle);
    }
  }
  return scene;
}

SampleSet one_sample(const Vec3f& position, std::uint32_t triangle) {
  SampleSet samples;
  samples.positions = {position};
  samples.normals = {Vec3f::UnitY()};
  samples.tangents = {Vec3f::UnitX()};
  samples.areas = {1.0F};
  samples.radii = {kRadius};
  samples.triangles = {triangle};
  samples.cluster_begin = {0, 1};
  return samples;
}

SurfacePoint point_at(const Vec3f& position, std::uint32_t triangle) {
  SurfacePoint point;
  point.position = position;
  point.normal = Vec3f::UnitY();
  point.triangle = triangle;
  return point;
}

TEST(SenderSearch, AFloorWithoutSamplesTakesNoneFromTheFloorAbove) {
  const Scene scene = floors({0.0F, 1.5F * kRadius});
  const SampleSet above = one_sample({0.5F, 1.5F * kRadius, 0.5F}, 2);
  const SenderSearch search(scene, above);
  EXPECT_EQ(search.find(point_at({0.5F, 0.0F, 0.5F}, 0)), kNone);
  // Within its own floor it goes as far as four radii.
  EXPECT_EQ(search.find(point_at({0.5F + 3.5F * kRadius, 1.5F * kRadius, 0.5F}, 2)), 0U);
  EXPECT_EQ(search.find(point_at({0.5F + 4.5F * kRadius, 1.5F * kRadius, 0.5F}, 2)), kNone);
}

TEST(SenderSearch, AStepLowerThanTheSamplesAreApartIsOneFloor) {
  const Scene scene = floors({0.0F, 0.5F * kRadius});
  const SampleSet above = one_sample({0.5F, 0.5F * kRadius, 0.5F}, 2);
  EXPECT_EQ(SenderSearch(scene, above).find(point_at({0.5F, 0.0F, 0.5F}, 0)), 0U);
}

}  // namespace
}  // namespace prt
