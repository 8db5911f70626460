// Packages under an environment: the GL against the CPU.
#include <gtest/gtest.h>

#include "gl/gl_lights.h"
#include "player/environment_light.h"
#include "player/gl/offscreen.h"
#include "player/gl/renderer.h"
#include "support/picture_difference.h"

namespace prt {
namespace {

/// Sums in another order.
constexpr float kRounding = 1e-4F;
/// As between pictures without an environment (gl_pictures_test.cpp).
constexpr double kMeanDifference = 0.01;
constexpr double kBlockDifference = 0.05;
constexpr int kWidth = 240, kHeight = 180;

Package room(int order, std::uint32_t channels, bool reflected, bool near = false) {
  Package package = test::synthetic_room({.albedo = {0.2F, 0.5F, 0.8F}});
  if (near) test::add_near(package);
  test::add_environment(package, order, channels, reflected);
  validate(package, "room");
  return package;
}

TEST(GlEnvironment, PlaysEveryOrderAsTheCpuDoes) {
  const gl::OffscreenContext context;
  const Environment sky = parse_environment("lobes:1,0.8,0.5");
  const auto lights = test::lights_of_every_kind().front().lights;
  for (const int order : {1, 2, 3, 5, 8}) {
    for (const bool reflected : {false, true}) {
      const Package package = room(order, order == 3 ? 1 : 3, reflected, order == 5);
      const Evaluator cpu(package);
      gl::GlRenderer gl(package);
      const MatrixF coefficients = EnvironmentLight(sky, order).coefficients(20.0);
      const SampleIrradiance expected = cpu.evaluate(lights, coefficients);
      gl.set_lights(lights, coefficients);
      EXPECT_TRUE(gl.sky().isApprox(expected.sky, kRounding)) << order << reflected;
      EXPECT_TRUE(gl.indirect().isApprox(expected.indirect, kRounding)) << order << reflected;
      EXPECT_TRUE(gl.direct().isApprox(expected.direct, 10.0F * kRounding)) << order << reflected;
      EXPECT_GT(expected.sky.norm(), 0.0F);
      gl.set_lights({});
      EXPECT_EQ(gl.sky().norm(), 0.0F);
      EXPECT_EQ(gl.indirect().norm(), 0.0F);
    }
  }
}

TEST(GlEnvironment, DrawsWhatTheCpuDraws) {
  const gl::OffscreenContext context;
  const Package package = room(4, 3, false);
  const Evaluator cpu(package);
  gl::GlRenderer gl(package);
  const Environment sky =
      parse_environment("gradient:0.5,0.8,1.5:1,1,1:0.2,0.18,0.15").turned(75.0);
  const Environment lobes = parse_environment("lobes:3,2,1");
  gl::GlView view(kWidth, kHeight);
  const std::vector<SceneCamera> cameras = {
      {.eye = {0.4F, 1.6F, 0.4F}, .target = {3, 1, 4}, .vertical_fov = 1.1F},
      {.eye = {9.0F, 6.0F, 11.0F}, .target = {2, 1, 2}, .vertical_fov = 0.9F}};
  for (const Environment* environment : {&sky, &lobes}) {
    const MatrixF coefficients = EnvironmentLight(*environment, 4).coefficients();
    const SampleIrradiance irradiance = cpu.evaluate({}, coefficients);
    gl.set_lights({}, coefficients);
    gl.set_background(environment);
    for (const SceneCamera& camera : cameras) {
      for (const Show show : {Show::kFull, Show::kDirect, Show::kIndirect}) {
        const PictureSettings settings{.width = kWidth,
                                       .height = kHeight,
                                       .show = show,
                                       .environment = environment,
                                       .reflection = show == Show::kFull ? 0.2F : 0.0F};
        const Picture expected = render(cpu, irradiance, camera, settings);
        gl.draw(view, camera,
                {.show = show, .exposure = expected.exposure, .reflection = settings.reflection});
        const auto apart = test::difference(view.pixels(), expected.rgb, kWidth, kHeight);
        EXPECT_LE(apart.mean, kMeanDifference) << static_cast<int>(show);
        EXPECT_LE(apart.worst_block, kBlockDifference) << static_cast<int>(show);
        PictureSettings linear = settings;
        linear.linear = true;
        const Picture exact = render(cpu, irradiance, camera, linear);
        const auto radiance =
            gl.radiance(view, camera, {.show = show, .reflection = settings.reflection});
        const Eigen::Map<const VectorF> a(radiance.data(),
                                          static_cast<Eigen::Index>(radiance.size()));
        const Eigen::Map<const VectorF> b(exact.radiance.data(), a.size());
        EXPECT_LE((a - b).norm(), 0.05F * b.norm()) << static_cast<int>(show);
      }
    }
  }
}

TEST(GlEnvironment, TurnsItsPicture) {
  const gl::OffscreenContext context;
  const Package package = room(3, 3, false);
  gl::GlRenderer gl(package);
  gl::GlView view(kWidth, kHeight);
  const Environment sky = parse_environment("disc:1,-0.2,0.3:1,1,1:30");
  const SceneCamera camera{.eye = {9, 6, 11}, .target = {2, 1, 2}, .vertical_fov = 1.5F};
  const Environment turned = sky.turned(40.0);
  gl.set_background(&sky);
  gl.draw(view, camera, {.turn = 40.0F});
  const auto by_look = view.pixels();
  gl.set_background(&turned);
  gl.draw(view, camera, {});
  const auto by_environment = view.pixels();
  gl.set_background(&sky);
  gl.draw(view, camera, {});
  const auto apart = test::difference(by_look, by_environment, kWidth, kHeight);
  EXPECT_LE(apart.mean, 0.1 * kMeanDifference);
  EXPECT_GT(test::difference(by_look, view.pixels(), kWidth, kHeight).mean, kMeanDifference);
}

}  // namespace
}  // namespace prt
