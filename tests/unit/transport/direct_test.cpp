#include "transport/direct.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "scene/embree/embree_ray_caster.h"
#include "statistical/test_scenes.h"

namespace prt {
namespace {

// Sample and light are a few metres apart; origins are lifted off the surface by 2^-16 of that.
constexpr float kLift = 2e-4F;

/// A floor of 20 m, with a board of 2 m at height 1 above its middle.
Scene floor_under_board() {
  Scene scene;
  const auto material = test::add_material(scene, Vec3f::Constant(0.5F));
  test::add_quad(scene, {-10, 0, -10}, {0, 0, 20}, {20, 0, 0}, material);
  test::add_quad(scene, {-1, 1, -1}, {0, 0, 2}, {2, 0, 0}, material);
  test::finish(scene);
  return scene;
}

SampleSet floor_samples(std::initializer_list<Vec3f> positions) {
  SampleSet samples;
  for (const Vec3f& p : positions) {
    samples.positions.push_back(p);
    samples.normals.push_back(Vec3f::UnitY());
    samples.triangles.push_back(0);
  }
  return samples;
}

TEST(DirectIrradiance, OfAPointOverAPlaneIsTheClosedForm) {
  const Scene scene = floor_under_board();
  const auto caster = make_embree_ray_caster(scene);
  const SampleSet samples = floor_samples({{3, 0, 0}, {4, 0, 2}, {-5, 0, 6}});
  const std::array<Vec3f, 2> lights{Vec3f(3, 2, 0), Vec3f(5, 0.5F, 3)};
  const MatrixF e = direct_irradiance(scene, *caster, samples, 0, 3, lights, 0.0F);
  for (int l = 0; l < 2; ++l) {
    // The second light's way to the third sample passes beside the board, not below it.
    for (int s = 0; s < 3; ++s) {
      const Vec3f to_light = lights[l] - samples.positions[s];
      const float r = to_light.norm();
      EXPECT_NEAR(e(l, s), to_light.y() / (r * r * r), kLift * to_light.y() / (r * r * r) + 1e-6F)
          << l << ' ' << s;
    }
  }
}

TEST(DirectIrradiance, IsNothingInShadowAndBehindTheSurface) {
  const Scene scene = floor_under_board();
  const auto caster = make_embree_ray_caster(scene);
  const SampleSet samples = floor_samples({{0, 0, 0}, {5, 0, 0}});
  const std::array<Vec3f, 2> lights{Vec3f(0, 3, 0), Vec3f(5, -1, 0)};
  const MatrixF e = direct_irradiance(scene, *caster, samples, 0, 2, lights, 0.0F);
  EXPECT_EQ(e(0, 0), 0.0F);  // below the board
  EXPECT_GT(e(0, 1), 0.0F);
  EXPECT_EQ(e(1, 0), 0.0F);  // light below the floor
  EXPECT_EQ(e(1, 1), 0.0F);
}

TEST(DirectIrradiance, ClipsNearLightsAndTakesARange) {
  const Scene scene = floor_under_board();
  const auto caster = make_embree_ray_caster(scene);
  const SampleSet samples = floor_samples({{0, 0, 0}, {5, 0, 0}, {7, 0, 0}});
  const std::array<Vec3f, 1> lights{Vec3f(5, 0.1F, 0)};
  const MatrixF e = direct_irradiance(scene, *caster, samples, 1, 3, lights, 0.5F);
  ASSERT_EQ(e.cols(), 2);
  EXPECT_NEAR(e(0, 0), 1.0F / (0.5F * 0.5F), 1e-3F);
  const float r = std::hypot(2.0F, 0.1F);
  EXPECT_NEAR(e(0, 1), 0.1F / (r * r * r), 10 * kLift * 0.1F / (r * r * r) + 1e-5F);
}

}  // namespace
}  // namespace prt
