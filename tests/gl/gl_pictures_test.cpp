// Pictures of the GL against those of the CPU.
#include <gtest/gtest.h>

#include "base/image_file.h"
#include "gl/gl_lights.h"
#include "player/gl/eyes.h"
#include "player/gl/offscreen.h"
#include "player/gl/renderer.h"
#include "stability/small_bake.h"
#include "support/picture_difference.h"

namespace prt {
namespace {

/// Pixels on edges may fall to the other side, and weights of samples are kept in ten bits.
constexpr double kMeanDifference = 0.01;
constexpr double kBlockDifference = 0.05;
constexpr int kWidth = 320;
constexpr int kHeight = 240;

SceneCamera camera(const Vec3f& eye, const Vec3f& target, float fov = 1.1F) {
  return {.eye = eye, .target = target, .vertical_fov = fov};
}

std::vector<SceneCamera> cameras() {
  return {camera({0.4F, 1.6F, 0.4F}, {3, 1, 4}), camera({3.7F, 2.7F, 4.6F}, {1.5F, 0.8F, 1.5F}),
          camera({2.0F, 0.3F, 2.5F}, {1.6F, 1.4F, 2.1F}, 1.6F),  // below the table
          camera({6.0F, 5.0F, 7.0F}, {2, 1, 2}, 0.7F)};          // from outside: nothing reaches
}

Package baked_room() {
  const test::SmallBake bake(test::room_with_a_table());
  Package package = bake.package();
  package.scene = bake.scene();
  return package;
}

class GlPictures : public testing::Test {
 protected:
  void expect_same(const SceneCamera& from, const test::NamedLights& lights, Show show) {
    const PictureSettings settings{
        .width = kWidth, .height = kHeight, .show = show, .exposure = std::nullopt};
    const SampleIrradiance irradiance = cpu_.evaluate(lights.lights);
    const Picture expected = render(cpu_, irradiance, from, settings);
    gl_.set_lights(lights.lights);
    gl_.draw(view_, from, {show, expected.exposure});
    const auto pixels = view_.pixels();
    const auto apart = test::difference(pixels, expected.rgb, kWidth, kHeight);
    EXPECT_LE(apart.mean, kMeanDifference);
    EXPECT_LE(apart.worst_block, kBlockDifference);
    if (HasFailure()) {
      const std::string name = testing::TempDir() + "gl_pictures_" + lights.name;
      write_png(name + "_gl.png", kWidth, kHeight, pixels);
      write_png(name + "_cpu.png", kWidth, kHeight, expected.rgb);
    }
    if (show == Show::kFull) {
      EXPECT_NEAR(gl_.own_exposure(view_, from), expected.exposure, 0.01F * expected.exposure);
    }
  }

  gl::OffscreenContext context_;
  Package package_ = baked_room();
  Evaluator cpu_{package_};
  gl::GlRenderer gl_{package_};
  gl::GlView view_{kWidth, kHeight};
};

TEST_F(GlPictures, AgreeWithTheCpusForEveryLightAndCamera) {
  for (const SceneCamera& from : cameras()) {
    for (const auto& lights : test::lights_of_every_kind()) {
      SCOPED_TRACE(lights.name);
      expect_same(from, lights, Show::kFull);
    }
  }
}

TEST_F(GlPictures, AgreeInEveryPart) {
  const auto lights = test::lights_of_every_kind().back();
  for (const Show show : {Show::kDirect, Show::kIndirect, Show::kVisibility, Show::kClusters}) {
    for (const SceneCamera& from : cameras()) {
      SCOPED_TRACE(static_cast<int>(show));
      expect_same(from, lights, show);
    }
  }
}

TEST_F(GlPictures, AgreeWhenPixelsAreAveraged) {
  const auto lights = test::lights_of_every_kind().front();
  const SceneCamera from = cameras().front();
  const SampleIrradiance irradiance = cpu_.evaluate(lights.lights);
  const Picture expected =
      render(cpu_, irradiance, from,
             {.width = kWidth, .height = kHeight, .samples_per_side = 2, .exposure = 1.0F});
  gl::GlView view(kWidth, kHeight, 2);
  gl_.set_lights(lights.lights);
  gl_.draw(view, from, {Show::kFull, 1.0F});
  const auto apart = test::difference(view.pixels(), expected.rgb, kWidth, kHeight);
  EXPECT_LE(apart.mean, kMeanDifference);
  EXPECT_LE(apart.worst_block, kBlockDifference);
}

/// Radiance is compared as a whole: pixels at edges may fall to the other side.
TEST_F(GlPictures, AgreeInRadiance) {
  const auto lights = test::lights_of_every_kind().front();
  const SceneCamera from = cameras().front();
  const SampleIrradiance irradiance = cpu_.evaluate(lights.lights);
  gl_.set_lights(lights.lights);
  gl::GlView view(kWidth, kHeight, 2);
  for (const Show show : {Show::kFull, Show::kDirect, Show::kIndirect}) {
    const Picture expected = render(
        cpu_, irradiance, from,
        {.width = kWidth, .height = kHeight, .show = show, .samples_per_side = 2, .linear = true});
    const auto radiance = gl_.radiance(view, from, {.show = show});
    ASSERT_EQ(radiance.size(), expected.radiance.size());
    double off = 0.0;
    double sum = 0.0;
    for (std::size_t i = 0; i < radiance.size(); ++i) {
      off += std::abs(radiance[i] - expected.radiance[i]);
      sum += expected.radiance[i];
    }
    EXPECT_GT(sum, 0.0);
    EXPECT_LE(off, kMeanDifference * sum) << static_cast<int>(show);
  }
}

TEST_F(GlPictures, ShowEachEyeItsOwnView) {
  const auto lights = test::lights_of_every_kind().front().lights;
  const gl::StereoSettings stereo{.on = true, .eye_distance = 0.3F};
  const SceneCamera from = cameras().front();
  gl::Eyes eyes(2 * kWidth, kHeight, stereo);
  gl_.set_lights(lights);
  eyes.draw(gl_, from, {});
  const auto both = eyes.pixels();
  ASSERT_EQ(both.size(), std::size_t{2} * 3 * kWidth * kHeight);
  const SampleIrradiance irradiance = cpu_.evaluate(lights);
  std::vector<std::vector<std::uint8_t>> halves;
  for (const SceneCamera& eye : gl::eye_cameras(from, stereo)) {
    const auto half = static_cast<std::ptrdiff_t>(halves.size());
    auto& pixels = halves.emplace_back();
    for (std::ptrdiff_t y = 0; y < kHeight; ++y) {
      const auto row = both.begin() + 3 * kWidth * (2 * y + half);
      pixels.insert(pixels.end(), row, row + 3 * kWidth);
    }
    const Picture expected =
        render(cpu_, irradiance, eye, {.width = kWidth, .height = kHeight, .exposure = 1.0F});
    const auto apart = test::difference(pixels, expected.rgb, kWidth, kHeight);
    EXPECT_LE(apart.mean, kMeanDifference);
    EXPECT_LE(apart.worst_block, kBlockDifference);
  }
  EXPECT_GT(test::difference(halves[0], halves[1], kWidth, kHeight).mean, kMeanDifference);
}

/// A room whose samples are too far apart for their kernels, and above the floor a second sheet of
/// samples of another cluster: what is nearest hangs on how much more height counts.
Package room_of_few_samples() {
  Package room = test::synthetic_room({.samples_per_edge = 6});
  SampleSet& samples = room.samples;
  for (std::size_t i = 0; i < samples.size(); ++i) samples.radii[i] *= 0.15F;
  for (std::uint32_t i = samples.cluster_begin[1]; i < samples.cluster_begin[2]; ++i) {
    samples.positions[i].x() += 0.25F;
    samples.positions[i].y() = 0.12F;
    samples.normals[i] = Vec3f::UnitY();
  }
  return room;
}

TEST(GlFallback, TakesTheNearestSampleWhereNoKernelReaches) {
  const gl::OffscreenContext context;
  const Package room = room_of_few_samples();
  const Evaluator cpu(room);
  std::size_t fallen_back = 0;
  std::vector<SplatWeight> weights;
  for (int k = 0; k < 100; ++k) {
    const Vec3f place(0.5F + 0.3F * static_cast<float>(k % 10), 0.0F,
                      0.5F + 0.4F * static_cast<float>(k / 10));
    cpu.splats().weights_at(place, Vec3f::UnitY(), weights);
    if (weights.size() != 1) continue;
    const std::uint32_t nearest = weights[0].sample;
    const float reach = kSplatReach * cpu.splats().radius(nearest);
    if ((room.samples.positions[nearest] - place).norm() > reach) ++fallen_back;
  }
  EXPECT_GT(fallen_back, 30U);

  const SceneCamera from = camera({2.0F, 2.8F, 2.4F}, {2.0F, 0.0F, 2.5F}, 1.4F);
  const auto lights = test::lights_of_every_kind().front().lights;
  gl::GlRenderer gl(room);
  gl::GlView view(kWidth, kHeight);
  gl.set_lights(lights);
  for (const Show show : {Show::kClusters, Show::kFull}) {
    const Picture expected =
        render(cpu, cpu.evaluate(lights), from,
               {.width = kWidth, .height = kHeight, .show = show, .exposure = 1.0F});
    gl.draw(view, from, {show, 1.0F});
    const auto apart = test::difference(view.pixels(), expected.rgb, kWidth, kHeight);
    EXPECT_LE(apart.mean, kMeanDifference);
    EXPECT_LE(apart.worst_block, kBlockDifference);
  }
}

/// What is kept while the camera stands still must not outlive its move, nor that of the light.
TEST_F(GlPictures, FollowCameraAndLight) {
  const auto lights = test::lights_of_every_kind();
  const auto draw = [&](std::size_t light, const SceneCamera& from) {
    gl_.set_lights(lights[light].lights);
    gl_.draw(view_, from, {});
    return view_.pixels();
  };
  const auto first = draw(0, cameras()[0]);
  const auto other_light = draw(3, cameras()[0]);
  const auto other_camera = draw(3, cameras()[1]);
  EXPECT_GT(test::difference(first, other_light, kWidth, kHeight).mean, 0.02);
  EXPECT_GT(test::difference(other_light, other_camera, kWidth, kHeight).mean, 0.02);
  EXPECT_EQ(draw(0, cameras()[0]), first);
}

}  // namespace
}  // namespace prt
